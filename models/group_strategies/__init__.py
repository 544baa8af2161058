"""Animals that choose the group they join (paper 3.2)."""

from .agents import LargestGroup, Leader, Wanderer
from .model import GroupStrategies

__all__ = ["GroupStrategies", "LargestGroup", "Leader", "Wanderer"]
