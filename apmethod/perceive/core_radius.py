"""How the core radius follows the agents (paper 2.4.4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.checks import finite_number, whole_number
from apmethod.contribute.terms import Term, term
from apmethod.particles import Column

if TYPE_CHECKING:
    from apmethod.particles import Particles
    from apmethod.perceive.lattice import QuadLattice

#: Share of the first core radius below which none falls.
_LEAST = 1e-3
#: Rounds in which radii come to rest before the first step, at the most.
_ROUNDS = 50


class RadiusRule:
    """How core radii follow the agents; a scene's own rule derives from this one."""

    #: What the agents must exchange for it.
    terms: tuple[Term, ...] = ()

    def attach(self, space: QuadLattice, particles: Particles, delivered: Sequence[str]) -> None:
        """Prepare a model's table; ``delivered`` names the sums that its agents receive."""

    def adapt(self, space: QuadLattice, particles: Particles) -> None:
        """Set the radii at the start of a step."""
        raise NotImplementedError


class FollowDensity(RadiusRule):
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

    def attach(self, space: QuadLattice, particles: Particles, delivered: Sequence[str]) -> None:
        """Refuse a scene in which nothing delivers a density."""
        if "density" not in delivered and "density" not in particles:
            raise ValueError(
                "radius_rule is FollowDensity, and nothing delivers a density; give a law that "
                "exchanges one, such as Diffusion"
            )

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


@term("even")
def neighbour_count(pair, i, j):
    """How many neighbours an agent has."""
    return 1.0


class KeepNeighbours(RadiusRule):
    """A core radius for each agent, which keeps its number of neighbours (paper 2.4.4).

    An agent with N neighbours, outside of ``fewest`` to ``most``, changes its radius by

        R <- R (1 + sqrt(N_wanted / N)) / 2,

    N_wanted halfway between the two, by a fifth at most in each step (Hernquist and Katz
    1989, in two dimensions).  Before the first step this is repeated until it comes to rest.
    Two agents are neighbours if they are closer than the mean of their radii, and their
    kernel has the mean of their smoothing lengths, so that messages keep their parity.
    Agents with too many neighbours in one place, or none, keep within the limits.

    Args:
        fewest, most: neighbours that an agent may have, both at least 1.
        smallest, largest: limits of the radii; a hundredth and ten times the model's core
            radius if not given.  A periodic domain has its own limit, which comes first.

    Raises:
        ValueError: for limits that are not above 0 or not in order.
    """

    terms = (neighbour_count,)

    def __init__(
        self,
        fewest: int = 25,
        most: int = 30,
        *,
        smallest: float | None = None,
        largest: float | None = None,
    ):
        self.fewest = whole_number("fewest", fewest, least=1)
        self.most = whole_number("most", most, least=1)
        if most < fewest:
            raise ValueError(f"most is {most}; it must be at least fewest, which is {fewest}")
        for name, value in (("smallest", smallest), ("largest", largest)):
            if value is not None:
                finite_number(name, value, above=0.0)
        if smallest is not None and largest is not None and largest < smallest:
            raise ValueError(f"largest is {largest:g}; it must be at least smallest, {smallest:g}")
        self.smallest, self.largest = smallest, largest
        self._settled = False

    def __repr__(self) -> str:
        return f"each agent's own, to keep {self.fewest} to {self.most} neighbours"

    def attach(self, space: QuadLattice, particles: Particles, delivered: Sequence[str]) -> None:
        """Give every agent a column ``core_radius``, which begins as the model's radius."""
        start = space.core_radius
        self.smallest = 0.01 * start if self.smallest is None else self.smallest
        self.largest = min(10.0 * start if self.largest is None else self.largest, _largest(space))
        particles.declare("core_radius", Column(start=start, unit="length", minimum=0.0))

    def adapt(self, space: QuadLattice, particles: Particles) -> None:
        """Bring every radius nearer to one that has the wanted number of neighbours."""
        if len(particles) == 0:
            return
        if self._settled:
            self._change(particles, particles.array("neighbour_count"), 1.2)
            return
        for _ in range(_ROUNDS):
            space.take_down()
            if not self._change(particles, space.neighbour_counts(), 2.0):
                break
        self._settled = True
        space.forget()

    def _change(self, particles: Particles, count: np.ndarray, most: float) -> bool:
        """Change the radii, by a factor of ``most`` at the most; whether any has."""
        radii = particles.array("core_radius")
        wanted = 0.5 * (self.fewest + self.most)
        factor = 0.5 + 0.5 * np.sqrt(wanted / np.maximum(count, 1.0))
        factor[(count >= self.fewest) & (count <= self.most)] = 1.0
        changed = np.clip(radii * np.clip(factor, 1.0 / most, most), self.smallest, self.largest)
        if (changed == radii).all():
            return False
        radii[:] = changed
        return True


def _largest(space: QuadLattice) -> float:
    """Half of the shortest periodic side."""
    periods = [period for period in space.domain.periods if period]
    return 0.5 * min(periods, default=np.inf)
