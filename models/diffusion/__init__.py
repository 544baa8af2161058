"""Diffusion of a density (paper Figure 7, b)."""

from .agents import Parcel
from .model import DensityDiffusion

__all__ = ["DensityDiffusion", "Parcel"]
