"""An obstacle that moves and turns among diffusing agents (paper 2.5.3)."""

from .agents import Stirred
from .model import MovingObstacle

__all__ = ["MovingObstacle", "Stirred"]
