"""Aggregation with a floor to perception (paper 3.2, Figure 10)."""

from .agents import FarSightedAnimal
from .model import AggregationPerception

__all__ = ["AggregationPerception", "FarSightedAnimal"]
