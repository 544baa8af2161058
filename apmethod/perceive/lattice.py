"""The quad-lattice: the space agent-particles live in (paper 2.4)."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from apmethod.checks import finite_number
from apmethod.perceive.cells import SortedCells, sort_into_cells
from apmethod.perceive.domain import Domain, Open, distance_2
from apmethod.perceive.images import MIRROR, REAL
from apmethod.perceive.lists import neighbour_counts
from apmethod.perceive.mesa_space import MesaSpace
from apmethod.perceive.pairs import neighbour_pairs
from apmethod.perceive.radii import sort_by_radius
from apmethod.perceive.skin import Skin
from apmethod.perceive.sorting import sharing_a_cell
from apmethod.perceive.vicinity import Vicinity

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle
    from apmethod.move.obstacles.collection import Obstacles
    from apmethod.move.obstacles.sight import Lines, Sights
    from apmethod.particles import Particles

#: More potential neighbours than any smoothing needs.
_CROWD = 5_000


class QuadLattice(MesaSpace):
    """Cells as wide as the core radius, each split in 4^p sub-domains (paper Table 1 and 2).

    It is the model's space as Mesa knows one.  Each time agents perceive, it takes down
    where all of them are; until the next time every question is answered from that, so
    that agents act on one and the same state whatever order they act in.

    Agents whose class has a column ``core_radius``, as `KeepNeighbours` gives all of them,
    have radii of their own: two of them are neighbours if they are closer than the mean.

    Args:
        particles: the agents' table.
        core_radius: distance up to which agents perceive each other (the support of the
            smoothing kernel, not its smoothing length), unless they have their own.
        domain: open if not given.
        level: p; 0 is the plain cell (algorithm A1), 1 the quad-lattice (A2).  None takes
            what is quicker for compiled sums: 0 for few agents in a cell, 1 for many.
        skin: how much further than the core radius a search reaches, as a share of it, so
            that it serves until an agent has gone half of that.  0 searches every time, as do
            domains with periodic or mirrored sides, obstacles, and radii of agents' own.

    Raises:
        ValueError: for a core radius that is not finite and positive or too large for a
            periodic domain, or a level outside 0 to 6.
    """

    def __init__(
        self,
        particles: Particles,
        core_radius: float,
        domain: Domain | None = None,
        level: int | None = None,
        skin: float = 0.0,
    ):
        self.particles = particles
        self.domain = domain or Open()
        if level is not None and (not isinstance(level, int) or not 0 <= level <= 6):
            raise ValueError(f"level is {level!r}; it must be a whole number from 0 to 6, or None")
        self._chooses_level = level is None
        self._level_is_guess = level is None
        self.level = 0 if level is None else level
        self.core_radius = core_radius
        self.skin = Skin(skin)
        self._cells: SortedCells | None = None
        self._vicinity: Vicinity | None = None  # made when an agent asks
        self._changes = -1
        self._warned = False
        #: What agents do not perceive through, if there is anything.
        self.obstacles: Obstacles | None = None
        self._sights: list[tuple[SortedCells, Sights | None]] = []
        #: What agents have perceived in a way of their own, until they perceive again.
        self.perceived: dict[AgentParticle, list[AgentParticle]] = {}
        particles.checks["position"] = self.domain.check_positions

    @property
    def core_radius(self) -> float:
        """Distance up to which agents perceive each other; the largest of their own radii."""
        if self.own_radii and len(self.particles):
            return float(self.particles.array("core_radius").max())
        return self._core_radius

    @core_radius.setter
    def core_radius(self, value: float) -> None:
        value = finite_number("core_radius", value, above=0.0)
        self.domain.check_radius(value)
        self._core_radius = value

    @property
    def own_radii(self) -> bool:
        """Whether each agent has a core radius of its own."""
        return "core_radius" in self.particles

    @property
    def smallest_radius(self) -> float:
        """The smallest core radius of any agent."""
        if self.own_radii and len(self.particles):
            return float(self.particles.array("core_radius").min())
        return self._core_radius

    def radius_of(self, agent: AgentParticle) -> float:
        """The core radius of one agent."""
        return agent.core_radius if self.own_radii else self._core_radius

    def radius_between(self, agent: AgentParticle, other: AgentParticle) -> float:
        """Distance up to which two agents are neighbours: the mean of their core radii."""
        if self.own_radii:
            return 0.5 * (agent.core_radius + other.core_radius)
        return self._core_radius

    # -- the state that all questions are answered from --------------------------------

    def take_down(self) -> None:
        """Sort the agents as they stand now into the sub-domains."""
        self.perceived.clear()
        self._sights, self._lines = [], None
        self._changes = self.particles.changes
        self._cells = self._search()
        if self._chooses_level:
            self.level = self._quickest_level()
            if self._level_is_guess and self.level != self._cells.level:
                self._cells = self._search()
            self._level_is_guess = False
        if self._cells.longest > _CROWD and not self._warned:
            self._warned = True
            warnings.warn(self._crowd_warning(), stacklevel=2)
        self._vicinity = None
        #: Whether whoever is within the core radius is a neighbour.
        self._all_count = self.obstacles is None and not self.own_radii

    def _search(self) -> SortedCells:
        """Sort all agents, or take the last search where it still serves."""
        positions = self.particles.array("position")
        if not self.may_reuse:
            return self.sorted(positions)
        return self.skin.search(
            positions, self.particles.changes, self.core_radius, self.level, self.domain
        )

    @property
    def may_reuse(self) -> bool:
        """Whether nothing but the agents' places decides who is near whom."""
        plain = not self.own_radii and not self.domain.makes_images and self.obstacles is None
        return plain and self.skin.share > 0.0

    def _quickest_level(self) -> int:
        """The level for the next search, after how many agents share a cell in this one.

        Sub-domains spare candidates, and cost time of their own.  Measured: with 28
        neighbours, 9 agents to a cell, they cost as much as they spare, with 40 and more they
        spare more.
        """
        if not len(self._cells.row) or self.own_radii:
            return 0
        level = self._cells.level
        sharing = sharing_a_cell(self._cells.start) * 4**level
        return int(sharing > (15.0 if level == 0 else 14.0))

    def _crowd_warning(self) -> str:
        cells = self._cells
        crowd = int(np.argmax(cells.potential))
        agent = self.particles._agents[cells.row[cells.start[crowd]]]
        return (
            f"around {agent!r} an agent tests {cells.longest} others for being nearer than the "
            f"core radius {self.core_radius:.4g}; where agents crowd, a step's time grows with "
            "the square of their number: a smaller core radius would help"
        )

    def forget(self) -> None:
        """Answer the next question from where the agents stand then."""
        self.perceived.clear()
        self._cells, self._vicinity, self._sights = None, None, []

    def sorted(self, positions: np.ndarray, rows: np.ndarray | None = None) -> SortedCells:
        """Positions, of shape (n, 2), in this lattice's sub-domains.

        ``rows`` are the rows of the table that they belong to, None for all.
        """
        if not (self.own_radii and len(positions)):
            return sort_into_cells(positions, self.core_radius, self.level, self.domain)
        radii = self.particles.array("core_radius")
        self._check_radii(radii)
        chosen = radii if rows is None else radii[rows]
        return sort_by_radius(positions, chosen, self.level, self.domain)

    def _check_radii(self, radii: np.ndarray) -> None:
        if not radii.min() > 0.0:
            row = int(np.flatnonzero(~(radii > 0.0))[0])
            raise ValueError(
                f"core_radius of {self.particles._agents[row]!r} is {radii[row]:g}; it must be "
                "above 0"
            )
        self.domain.check_radius(float(radii.max()))

    def tidy(self) -> None:
        """Put the table's rows in the order of the sub-domains.

        Neighbours are then near each other in memory, too.
        """
        self.particles.reorder(self.cells.row[self.cells.of_kind(REAL)])
        self.skin.forget()
        self.forget()

    @property
    def cells(self) -> SortedCells:
        """The agents in the order of their sub-domains."""
        if self._is_stale:
            self.take_down()
        return self._cells

    @property
    def _is_stale(self) -> bool:
        return self._cells is None or self._changes != self.particles.changes

    def pairs(self) -> np.ndarray:
        """All pairs of neighbours as rows i < j of the table, of shape (pairs, 2)."""
        pairs, sights = neighbour_pairs(self.cells), self.sights_of(self.cells)
        return pairs if sights is None else pairs[sights.see_each_other(pairs, self.cells.row)]

    def sights_of(self, cells: SortedCells) -> Sights | None:
        """Whom agents near walls see, of those in ``cells``; None if that is nothing special."""
        if self.obstacles is None or self.obstacles.contributions == "through":
            return None
        for known, sights in self._sights:
            if known is cells:
                return sights
        from apmethod.move.obstacles.sight import sights_of  # loaded where there are obstacles

        sights = sights_of(self.obstacles, cells, self.domain)
        self._sights.append((cells, sights))
        return sights

    @property
    def mirrors(self) -> bool:
        """Whether agents may have mirror images, in the domain's sides or in walls."""
        walls = self.obstacles is not None and self.obstacles.contributions == "mirrored"
        return self.domain.mirrors or walls

    def neighbour_counts(self) -> np.ndarray:
        """How many neighbours each row of the table has, mirror images among them."""
        cells, counts = self.cells, np.zeros(len(self.particles), np.int64)
        real = cells.of_kind(REAL)
        counts[cells.row[real]] = neighbour_counts(cells)[1:][real]
        return counts

    # -- one agent ---------------------------------------------------------------------

    def place_of(self, agent: AgentParticle) -> tuple[float, float]:
        """Where the agent stood when the agents last perceived."""
        return self._seen.of_row[self.particles.row(agent)][:2]

    @property
    def _seen(self) -> Vicinity:
        """The sorted agents as lists, made when the first agent asks."""
        if self._vicinity is None or self._changes != self.particles.changes:
            self._vicinity = Vicinity(self.cells, self.particles._agents)
        return self._vicinity

    def displacement(self, agent: AgentParticle, other: AgentParticle) -> tuple[float, float]:
        """x_i - x_j, the shorter way across periodic sides."""
        return self.domain.displacement(self.place_of(agent), self.place_of(other))

    def near(self, agent: AgentParticle, other: AgentParticle) -> bool:
        """Whether two agents are closer than the core radius, with no wall in between."""
        reach = self.radius_between(agent, other)
        if not distance_2(*self.displacement(agent, other)) < reach * reach:
            return False
        lines = self._lines_to(agent)
        return lines is None or self.particles.row(other) in lines.straight

    def neighbours_of(self, agent: AgentParticle) -> list[AgentParticle]:
        """The agents within the core radius (algorithms A1 and A2 of paper 2.4.2), in sight."""
        vicinity = self._seen
        x, y, begin, end, own, first, last = vicinity.of_row[self.particles.row(agent)]
        radius_2 = self._cells.core_radius * self._cells.core_radius
        neighbours = []
        potential = vicinity.potential[begin:end]
        del potential[own]  # to ask each one whether it is the agent takes longer
        for other, other_x, other_y in potential:
            if distance_2(x - other_x, y - other_y) < radius_2:
                neighbours.append(other)
        if first < last:
            for other, other_x, other_y, shift_x, shift_y in vicinity.images[first:last]:
                if distance_2((x - other_x) - shift_x, (y - other_y) - shift_y) < radius_2:
                    neighbours.append(other)
        return neighbours if self._all_count else self._that_count(agent, neighbours)

    def _that_count(
        self, agent: AgentParticle, neighbours: list[AgentParticle]
    ) -> list[AgentParticle]:
        """Those of the agents within the (largest) core radius that are in reach and in sight."""
        lines = self._lines_to(agent)
        if lines is not None:
            row = self.particles.row
            neighbours = [other for other in neighbours if row(other) in lines.straight]
        if self.own_radii:
            return [other for other in neighbours if self.near(agent, other)]
        return neighbours

    def mirrored_near(self, agent: AgentParticle) -> list[tuple[AgentParticle, float, float, int]]:
        """Agents whose mirror images are within the core radius: (agent, dx, dy, sign).

        dx and dy are x_i - x_j to the image; the sign is -1 in walls that absorb, else 1.
        """
        cells, agents = self.cells, self.particles._agents
        lines = self._lines_to(agent)
        if lines is not None:
            return [(agents[row], *image) for row, *image in lines.mirrored]
        if not len(cells.image):
            return []
        (x, y), place = self.place_of(agent), self._seen.cell[self.particles.row(agent)]
        found = []
        for run in range(cells.first[place], cells.first[place + 1]):
            for k in range(cells.low[run], cells.high[run]):
                if cells.image[k] == MIRROR:
                    other = agents[cells.row[k]]
                    reach = self.radius_between(agent, other)
                    dx, dy = x - cells.x[k] - cells.shift_x[k], y - cells.y[k] - cells.shift_y[k]
                    if distance_2(dx, dy) < reach * reach:
                        found.append((other, float(dx), float(dy), 1))
        return found

    def _lines_to(self, agent: AgentParticle) -> Lines | None:
        """The agent's lines of sight, if it is near a wall."""
        sights = self.sights_of(self.cells)
        if sights is None:
            return None
        if self._lines is None:
            self._lines = sights.lines(self.cells.row)
        return self._lines.get(self.particles.row(agent))
