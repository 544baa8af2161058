"""How the core radius follows the agents (paper 2.4.4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from apmethod.particles import Particles
    from apmethod.perceive.lattice import QuadLattice


#: Share of the first core radius below which none falls.
_LEAST = 1e-3


class FollowDensity:
    """One core radius for all agents that grows as the cloud thins out.

    With u the density that agents last received and u0 the first one,

        R(t) = R(0) sqrt(mean(u0) / mean(u)),   mean(u) = sum m u / sum m,

    which keeps the number of neighbours of the typical agent.  A fixed radius runs out of
    neighbours when a cloud spreads.

    Agents that are all isolated keep the radius, as each is its own density, m W(0).  It is
    at most half the shortest periodic side, and at least a thousandth of R(0): agents on one
    point would shrink it without end.  While no mass has a density it stays what it is.
    """

    def __init__(self) -> None:
        self._first: tuple[float, float] | None = None

    def __repr__(self) -> str:
        return "follows the mean density, to keep the number of neighbours"

    def grown(self, factor: float) -> None:
        """Take note that all masses have been multiplied, which thins no cloud out."""
        if self._first is not None:
            radius, first = self._first
            self._first = (radius, first * factor)

    def adapt(self, space: QuadLattice, particles: Particles) -> None:
        """Set the core radius from the density that agents last received."""
        mass, density = particles.array("mass"), particles.array("density")
        total = mass.sum()
        mean = (mass * density).sum() / total if total else 0.0
        if not (np.isfinite(mean) and mean > 0.0):
            return  # nothing delivered yet
        if self._first is None:
            self._first = (space.core_radius, mean)
        radius, first = self._first
        wanted = radius * max(np.sqrt(first / mean), _LEAST)
        space.core_radius = min(wanted, _largest(space))


def _largest(space: QuadLattice) -> float:
    """Half of the shortest periodic side."""
    periods = [period for period in space.domain.periods if period]
    return 0.5 * min(periods, default=np.inf)
