"""Laying agents anew on a lattice, where they have strained the one they stood on.

Sums over neighbours are integrals as long as the agents stand about as densely in every
direction.  `Remesh` measures how far that still holds and, beyond a strain, reads the field
at the nodes of a new square lattice, by the sixth-order `reconstruct`: a node's mass is u
there times its square.  Mass and centre of mass are then mended, which keeps both to
round-off.

Particle methods commonly interpolate the masses to the nodes instead (M6', Bergdorf and
Koumoutsakos 2006).  From a lattice that a shear flow has strained this left errors of up to
8e-4 with 12 000 agents and 5e-4 with 32 000, where reading the field leaves 1e-4 and 4e-5.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from apmethod.compile import compiled
from apmethod.contribute.reconstruct import reconstruct
from apmethod.contribute.sample import lattice_axis, spacing_along
from apmethod.particles import Column
from apmethod.perceive.domain import OPEN, Domain, shortest

if TYPE_CHECKING:
    from apmethod.field.model import FieldModel

#: Spacings beyond the outermost agents in which nodes are looked for.
_REACH = 3
#: Smoothing length by which the field is read at the nodes, in spacings.  At 1.8 the reading
#: smooths the field of a few agents (error of 4000 in a shear flow up to 1.8e-3, not 1.1e-3),
#: at 1.35 that of many sees the single ones (of 32 000 7.8e-5, not 4.3e-5).
_SMOOTHING = 1.5
#: Share of its mass by which an agent may be changed to keep the centre of all.
_MOST = 0.5
#: Share of the mass that may be strained more than what is measured.
_BEYOND = 0.05


class Remesh:
    """Measures the strain of the agents' lattice and lays them on a new one.

    Each agent remembers the node it was laid on (column ``_node``).  From where the agents
    of the four nodes around it are now comes the deformation F since then.  Its largest
    singular value s says how far neighbours have been drawn apart; with s0 for the growth
    of the typical spacing, which the core radius follows, the strain is log(s/s0): 0 for a
    rotation or an even spreading, asinh(g/2) for a shear by g.  What counts is the strain
    that 95 % of the mass stay below.

    The agents are the ones that there were: each goes to the node nearest to it that is
    free, so that it keeps its identity near where it was.  Those left over take the nodes
    left over; if nodes are more, agents are created for them (of the class the scene was
    given), and if agents are more, they are removed, each in bulk.  Columns other than
    position and mass stay what they were, or start as in any new agent.

    Args:
        model: the scene.
        threshold: strain at which agents are laid anew.

    Attributes:
        times: physical times at which they have been.
    """

    def __init__(self, model: FieldModel, threshold: float):
        self.model = model
        self.threshold = threshold
        self.times: list[float] = []
        model.particles.declare("_node", Column(2, dtype=np.int64, start=(-1, -1), kept=False))

    def take_down(self, spacing: float) -> None:
        """Number the nodes that all agents stand on now, on a lattice of about that spacing."""
        places = self.model.particles.array("position")
        places = places - places.min(axis=0)
        spacings = tuple(spacing_along(places[:, axis], spacing) for axis in range(2))
        self._number(np.rint(places / spacings).astype(np.int64), spacings)

    def _number(self, nodes: np.ndarray, spacings: tuple[float, float]) -> None:
        self.model.particles.array("_node")[:] = nodes
        self._spacings = spacings
        self._grid = tuple(int(n) + 1 for n in nodes.max(axis=0))

    def strain(self) -> float:
        """The strain since the agents were laid that 95 % of the mass stay below."""
        particles, domain = self.model.particles, self.model.space.domain
        stretch, mass = _stretches(
            particles.array("_node"), self._grid, particles.array("position"),
            particles.array("mass"), self._spacings, domain.periods,
        )  # fmt: skip
        if not len(stretch):
            return 0.0
        order = np.argsort(stretch)
        share = np.cumsum(mass[order])
        worst = order[np.searchsorted(share, (1.0 - _BEYOND) * share[-1])]
        spread = self.model.spacing / np.sqrt(self._spacings[0] * self._spacings[1])
        return float(np.log(stretch[worst] / spread))

    def where_strained(self) -> bool:
        """Lay the agents anew if they are strained beyond the threshold."""
        if self.strain() <= self.threshold:
            return False
        self.lay_anew()
        return True

    def lay_anew(self) -> None:
        """Put agents with the field's masses on a new lattice, of the spacing they have now."""
        model, particles = self.model, self.model.particles
        axes = self._axes(model.spacing)
        spacings = tuple(spacing for _, spacing in axes)
        points = np.stack(np.meshgrid(axes[0][0], axes[1][0], indexing="ij"), axis=-1)
        u = self._field_at(points)
        if not u.max() > 0.0:
            return  # nothing to lay
        nodes = np.argwhere(u > model.accuracy.least(len(particles)) * u.max())
        places, density = points[*nodes.T], u[*nodes.T]
        masses = keeping_moments(
            places, density * spacings[0] * spacings[1],
            particles.array("position"), particles.array("mass"), model.space.domain,
        )  # fmt: skip
        order = self._assign(nodes, points[0, 0], spacings, u.shape)
        self._number(nodes[order], spacings)
        particles.assign("position", places[order])
        particles.assign("mass", masses[order])
        # The core radius follows what was last received: until then, the field at the node.
        particles.array("density")[:] = density[order]
        self.times.append(model.elapsed)

    def _field_at(self, points: np.ndarray) -> np.ndarray:
        """u at points, of shape (..., 2), which goes on behind walls as in a mirror."""
        model, domain = self.model, self.model.space.domain
        borders = tuple("mirrored" if name == "bounded" else name for name in domain.borders)
        values = reconstruct(
            points.reshape(-1, 2), model.particles.position, model.particles.mass,
            _SMOOTHING * model.spacing, domain=Domain(domain.lower, domain.upper, borders),
        )  # fmt: skip
        return values.reshape(points.shape[:-1])

    def _axes(self, spacing: float) -> list[tuple[np.ndarray, float]]:
        """Coordinates and spacing of the nodes along x and y, with room around the agents."""
        domain, positions = self.model.space.domain, self.model.particles.array("position")
        axes = []
        for axis, kind in enumerate(domain.kinds):
            if kind == OPEN:
                low = positions[:, axis].min() - _REACH * spacing
                high = positions[:, axis].max() + (_REACH + 0.5) * spacing
            else:
                low, high = domain.lower[axis], domain.upper[axis]
            axes.append(lattice_axis(low, high, spacing, 0.0, kind))
        return axes

    def _assign(
        self, nodes: np.ndarray, origin: tuple, spacings: tuple, shape: tuple
    ) -> np.ndarray:
        """Bring the number of agents to that of the nodes: which node each row is to take."""
        model, particles = self.model, self.model.particles
        positions = particles.array("position")
        nearest = np.rint((positions - np.array(origin)) / np.array(spacings)).astype(np.int64)
        nearest = np.clip(nearest, 0, np.array(shape) - 1)
        number = np.full(shape, -1, np.int64)
        number[nodes[:, 0], nodes[:, 1]] = np.arange(len(nodes))
        wanted = number[nearest[:, 0], nearest[:, 1]]
        taken = np.full(len(particles), -1, np.int64)
        # The first that wants a node gets it.
        claimed, first = np.unique(wanted, return_index=True)
        first, claimed = first[claimed >= 0], claimed[claimed >= 0]
        taken[first] = claimed
        left_nodes = np.setdiff1d(np.arange(len(nodes)), claimed, assume_unique=True)
        left_rows = np.flatnonzero(taken < 0)
        both = min(len(left_nodes), len(left_rows))
        taken[left_rows[:both]] = left_nodes[:both]
        for agent in [particles.agents[row] for row in left_rows[both:]]:
            taken[particles.row(agent)] = taken[-1]  # as the table fills the gap
            taken = taken[:-1]
            agent.remove()
        if len(left_nodes) > both:
            place = positions[0] if len(positions) else np.zeros(2)
            model.agent_class.create_agents(model, len(left_nodes) - both, position=place)
            taken = np.concatenate([taken, left_nodes[both:]])
        return taken


def keeping_moments(
    places: np.ndarray, masses: np.ndarray, before: np.ndarray, weights: np.ndarray, domain: Domain
) -> np.ndarray:
    """Masses at new places with the sum and the centre of the old ones.

    Each is multiplied by 1 + b.(x - c), c their centre, with the b that brings it to the old
    one; then all are scaled to the old sum.  |b.(x - c)| is at most `_MOST`: a few agents
    whose centre is further off than this can mend do not keep it.

    Args:
        places, masses: the new places, of shape (n, 2), and masses above 0, of shape (n,).
        before, weights: the old positions, of shape (m, 2), and masses, of shape (m,).
        domain: along a periodic axis of it there is no centre, and b is 0.
    """
    mass, total = masses.sum(), weights.sum()
    periodic = np.array(domain.periods) > 0.0
    off = np.where(periodic, 0.0, places - masses @ places / mass)
    wanted = np.where(periodic, 0.0, mass / total * (weights @ before) - masses @ places)
    # The pseudo-inverse leaves out a direction in which the places do not differ.
    inverse = np.linalg.pinv(off.T @ (masses[:, None] * off), rcond=1e-9, hermitian=True)
    tilt = off @ (inverse @ wanted)
    masses = masses * (1.0 + tilt * min(1.0, _MOST / max(np.abs(tilt).max(), _MOST)))
    return masses * (total / masses.sum())


@compiled
def _stretches(node, grid, positions, mass, spacings, periods):
    """How far apart agents' neighbours on the lattice are, over how far they were.

    Returns:
        That of each agent that has all four, and the agent's mass.
    """
    at_node = np.full(grid, -1, np.int64)
    for row in range(len(node)):
        if node[row, 0] >= 0:
            at_node[node[row, 0], node[row, 1]] = row
    stretch, share, count = np.empty(len(node)), np.empty(len(node)), 0
    for i in range(1, grid[0] - 1):
        for j in range(1, grid[1] - 1):
            here, east, west = at_node[i, j], at_node[i + 1, j], at_node[i - 1, j]
            north, south = at_node[i, j + 1], at_node[i, j - 1]
            if here < 0 or east < 0 or west < 0 or north < 0 or south < 0:
                continue
            a = shortest(positions[east, 0] - positions[west, 0], periods[0]) / spacings[0]
            c = shortest(positions[east, 1] - positions[west, 1], periods[1]) / spacings[0]
            b = shortest(positions[north, 0] - positions[south, 0], periods[0]) / spacings[1]
            d = shortest(positions[north, 1] - positions[south, 1], periods[1]) / spacings[1]
            # The larger singular value of F = ((a, b), (c, d)) / 2.
            square, det = a * a + b * b + c * c + d * d, a * d - b * c
            root = np.sqrt(max(square * square - 4.0 * det * det, 0.0))
            stretch[count], share[count] = 0.5 * np.sqrt(0.5 * (square + root)), mass[here]
            count += 1
    return stretch[:count], share[:count]
