"""What Mesa's own spaces answer, so that Mesa and its views can ask the lattice."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.perceive.domain import Domain

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle
    from apmethod.particles import Particles


class MesaSpace:
    """The questions of Mesa's continuous space, answered from the table of agents.

    Attributes:
        particles: the agents' table.
        domain: where they are.
    """

    particles: Particles
    domain: Domain

    @property
    def torus(self) -> bool:
        """Whether every side is periodic."""
        return all(self.domain.periods)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """x_min, x_max, y_min, y_max of the domain, or of the agents where it is open."""
        positions = self.particles.array("position")
        if len(positions):
            low, high = positions.min(axis=0), positions.max(axis=0)
        else:
            low, high = np.zeros(2), np.ones(2)
        low = np.where(np.isfinite(self.domain.lower), self.domain.lower, low)
        high = np.where(np.isfinite(self.domain.upper), self.domain.upper, high)
        return float(low[0]), float(high[0]), float(low[1]), float(high[1])

    def out_of_bounds(self, position: Sequence[float]) -> bool:
        """Whether a position is outside the domain."""
        return bool(((position < self.domain.lower) | (position > self.domain.upper)).any())

    def get_distance(self, here: Sequence[float], there: Sequence[float]) -> float:
        """Distance of two positions, the shorter way across periodic sides."""
        return float(np.hypot(*self.domain.displacement(here, there)))

    def get_neighbors(self, position: Sequence[float], radius: float) -> list[AgentParticle]:
        """The agents at most ``radius`` from a position; any radius, by trying all agents."""
        apart = np.asarray(position, float) - self.particles.array("position")
        for axis, period in enumerate(self.domain.periods):
            if period:
                apart[:, axis] -= period * np.round(apart[:, axis] / period)
        agents = self.particles.agents
        return [agents[row] for row in np.flatnonzero(np.hypot(*apart.T) <= radius)]
