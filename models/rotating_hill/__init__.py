"""The rotating hill (paper Figure 7, c): a hump of matter turns and spreads."""

from .agents import HillParticle
from .model import RotatingHill

__all__ = ["HillParticle", "RotatingHill"]
