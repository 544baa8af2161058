"""Laying agents anew on a lattice, where they have strained the one they stood on.

Sums over neighbours are integrals as long as the agents stand about as densely in every
direction.  `Remesh` measures how far that still holds and, beyond a strain, moves the
masses to the nodes of a new square lattice (by M6', Bergdorf and Koumoutsakos 2006:
mass, centre of mass and second moments are kept to round-off but for what the cut of the
thin tail drops).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from apmethod.compile import compiled, inlined
from apmethod.contribute.sample import lattice_axis, spacing_along
from apmethod.particles import Column
from apmethod.perceive.domain import BOUNDED, MIRRORED, OPEN, PERIODIC, shortest

if TYPE_CHECKING:
    from apmethod.field.model import FieldModel

#: Nodes on each side of an agent that M6' reaches.
_REACH = 3
#: Nodes around the lattice that take what is laid beyond it; one more for rounding.
_PAD = _REACH + 1
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
        node, mass = particles.array("_node"), particles.array("mass")
        at_node = np.full(self._grid, -1, np.int64)
        rows = np.flatnonzero(node[:, 0] >= 0)
        at_node[node[rows, 0], node[rows, 1]] = rows
        stretch = np.full(len(particles), np.nan)
        _stretch(at_node, particles.array("position"), self._spacings, domain.periods, stretch)
        inner = np.flatnonzero(np.isfinite(stretch))
        if not len(inner):
            return 0.0
        order = inner[np.argsort(stretch[inner])]
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
        """Move the agents' masses to the nodes of a new lattice, of the spacing they have now."""
        model, particles = self.model, self.model.particles
        axes = self._axes(model.spacing)
        spacings = tuple(spacing for _, spacing in axes)
        kinds = model.space.domain.kinds
        masses = spread(
            particles.array("position"), particles.array("mass"),
            tuple(float(line[0]) for line, _ in axes), spacings,
            tuple(len(line) for line, _ in axes), kinds,
        )  # fmt: skip
        total, least = particles.array("mass").sum(), model.accuracy.least(len(particles))
        nodes = np.argwhere(masses > least * masses.max())
        kept = masses[nodes[:, 0], nodes[:, 1]]
        kept *= total / kept.sum()
        places = np.column_stack([axes[k][0][nodes[:, k]] for k in range(2)])
        order = self._assign(nodes, (axes[0][0][0], axes[1][0][0]), spacings, masses.shape)
        self._number(nodes[order], spacings)
        particles.assign("position", places[order])
        particles.assign("mass", kept[order])
        # The core radius follows what was last received: until then, the field at the node.
        particles.array("density")[:] = kept[order] / (spacings[0] * spacings[1])
        self.times.append(model.elapsed)

    def _axes(self, spacing: float) -> list[tuple[np.ndarray, float]]:
        """Coordinates and spacing of the nodes along x and y, with room for M6' around."""
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


def spread(
    positions: np.ndarray,
    masses: np.ndarray,
    origin: tuple[float, float],
    spacings: tuple[float, float],
    shape: tuple[int, int],
    kinds: tuple[int, int],
) -> np.ndarray:
    """Masses on the nodes of a lattice, by M6' from anywhere; an array of that shape.

    What M6' lays beyond a wall comes back as from its mirror, and what it lays beyond a
    periodic side from the other one.
    """
    padded = np.zeros((shape[0] + 2 * _PAD, shape[1] + 2 * _PAD))
    _spread(positions, masses, origin, spacings, padded)
    for axis, kind in enumerate(kinds):
        along = np.moveaxis(padded, axis, 0)
        first, last = along[_PAD : 2 * _PAD], along[-2 * _PAD : -_PAD]
        if kind in (BOUNDED, MIRRORED):
            first += along[:_PAD][::-1]
            last += along[-_PAD:][::-1]
        elif kind == PERIODIC:
            first += along[-_PAD:]
            last += along[:_PAD]
    return padded[_PAD:-_PAD, _PAD:-_PAD]


@inlined
def m6(q):
    """M6'(q): third-order interpolation on a lattice, zero from q = 3 on."""
    q = abs(q)
    if q < 1.0:
        return -(q - 1.0) * (60.0 * q**4 - 87.0 * q**3 - 87.0 * q**2 + 88.0 * q + 88.0) / 88.0
    if q < 2.0:
        cubic = 60.0 * q**3 - 261.0 * q**2 + 257.0 * q + 68.0
        return (q - 1.0) * (q - 2.0) * cubic / 176.0
    if q < 3.0:
        return -3.0 * (q - 2.0) * (4.0 * q**2 - 17.0 * q + 12.0) * (q - 3.0) ** 2 / 176.0
    return 0.0


@compiled
def _spread(positions, masses, origin, spacings, padded):
    weights = np.empty((2, 2 * _REACH))
    for k in range(positions.shape[0]):
        x = (positions[k, 0] - origin[0]) / spacings[0]
        y = (positions[k, 1] - origin[1]) / spacings[1]
        west, south = int(np.floor(x)) - _REACH + 1, int(np.floor(y)) - _REACH + 1
        for n in range(2 * _REACH):
            weights[0, n] = m6(x - (west + n))
            weights[1, n] = m6(y - (south + n))
        for i in range(2 * _REACH):
            for j in range(2 * _REACH):
                share = masses[k] * weights[0, i] * weights[1, j]
                padded[west + i + _PAD, south + j + _PAD] += share


@compiled
def _stretch(at_node, positions, spacings, periods, stretch):
    """How far apart each agent's neighbours on the lattice are, over how far they were."""
    for i in range(1, at_node.shape[0] - 1):
        for j in range(1, at_node.shape[1] - 1):
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
            stretch[here] = 0.5 * np.sqrt(0.5 * (square + root))
