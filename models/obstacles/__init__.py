"""Diffusion among obstacles (paper Figures 6 and 8)."""

from .agents import Spreading
from .model import DiffusionAmongObstacles

__all__ = ["DiffusionAmongObstacles", "Spreading"]
