"""Uniform random agents that make random moves: what the paper measures on (2.4.3)."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

#: Neighbours within the core radius, in the middle of the paper's 25 to 30 (2.4.4).
NEIGHBOURS = 28


def core_radius_for(agents: int, neighbours: float = NEIGHBOURS) -> float:
    """R with pi R^2 agents = neighbours, for agents all over the unit square."""
    return sqrt(neighbours / (pi * agents))


class Cloud:
    """Agents all over ]-1/2, 1/2[^2 and their random moves, which keep them uniform.

    Args:
        agents: how many.
        reach: largest move along each axis.
        periodic: whether agents that leave enter opposite; otherwise they are reflected.
        seed: of the places and the moves.
    """

    def __init__(self, agents: int, reach: float, *, periodic: bool, seed: int):
        self._draw = np.random.default_rng(seed)
        self.reach = reach
        self.periodic = periodic
        self.positions = self._draw.random((agents, 2)) - 0.5

    def move(self) -> None:
        """Move every agent at random."""
        moves = self._draw.uniform(-self.reach, self.reach, self.positions.shape)
        from_corner = self.positions + moves + 0.5
        if self.periodic:
            self.positions = from_corner % 1.0 - 0.5
        else:
            folded = from_corner % 2.0
            self.positions = np.minimum(folded, 2.0 - folded) - 0.5
