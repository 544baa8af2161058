"""A pollutant spreads in a harbour, whose map is a GeoJSON file (paper 2.5)."""

from .agents import Oil
from .model import Harbour

__all__ = ["Harbour", "Oil"]
