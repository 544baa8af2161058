"""Animals that leave a signal and gather (paper 3.2, Figure 9)."""

from .agents import GregariousAnimal
from .model import Aggregation

__all__ = ["Aggregation", "GregariousAnimal"]
