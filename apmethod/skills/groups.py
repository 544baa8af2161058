"""Groups of agents, found in each step and followed over time (paper 3.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from apmethod.checks import finite_number, whole_number
from apmethod.skills.cluster import centres_of, clusters_in, clusters_in_sight, search
from apmethod.skills.lineage import overlap
from apmethod.skills.skill import Skill

if TYPE_CHECKING:
    from mesa.agent import AgentSet

    from apmethod.model import ParticleModel
    from apmethod.perceive.cells import SortedCells

#: Cells serve from this share of their search radius on: below, sorting anew costs less than
#: looking through all the pairs that are too far apart (measured with 10^5 agents).
_FITTING = 0.7
#: Share of a group that must have gone one way for it to count as a merge or a split.
_MOST = 0.5


@dataclass(frozen=True)
class Group:
    """A group of agents as it stood when it was last found.

    Attributes:
        identity: its number, kept as long as it lives.
        born: physical time at which it was first found.
        age: how long it has lived.
        size: number of members.
        mass: mass of the members.
        x, y: their centre, of mass.
        radius: root mean square distance of the members from it.
    """

    identity: int
    born: float
    age: float
    size: int
    mass: float
    x: float
    y: float
    radius: float


@dataclass(frozen=True)
class GroupEvent:
    """Something that happened to a group.

    Attributes:
        time: physical time.
        kind: "birth", "split" (it came out of another), "merge" (it went into another) or
            "end".
        group: identity of the group that came or went.
        other: identity of the group that it split off or merged into, or None.
    """

    time: float
    kind: str
    group: int
    other: int | None = None


class Groups(Skill):
    """Finds groups in each step, among the agents as they perceive each other.

    A group is a cluster as DBSCAN finds it (see `apmethod.skills.cluster`); agents that a wall
    separates are not near each other, unless contributions go through walls.  A group keeps its
    identity from one step to the next if each of the two has most of its members in common
    with the other; the column ``group`` tells each agent's, -1 for an agent that is alone.

    Groups are those of the state that the agents perceive in a step, that is of its start;
    `find` brings them up to date after the last one.

    Args:
        radius: distance at which two agents are near.  Where it is near the core radius,
            and below, the cells that the agents perceive by serve.
        least: how many agents, itself included, a core agent has within the radius.

    Raises:
        ValueError: for a radius that is not above 0 or a ``least`` below 2.

    Attributes:
        current: the groups, in the order of their identities.
        events: births, splits, merges and ends, in order.
    """

    def __init__(self, radius: float, least: int = 10):
        self.radius = finite_number("radius", radius, above=0.0)
        self.least = whole_number("least", least, least=2)
        self.current: tuple[Group, ...] = ()
        self.events: list[GroupEvent] = []
        self._next = 0
        self._due = False

    def __repr__(self) -> str:
        return f"groups of {self.least} or more agents within {self.radius:g} of one of them"

    def attach(self, model: ParticleModel) -> None:
        """Declare the column ``group``."""
        super().attach(model)
        model.space.domain.check_radius(self.radius)
        self.declare("group", dtype=np.int64, start=-1)

    # -- turns -------------------------------------------------------------------------

    def begin(self, dt: float) -> None:
        """A step has begun, in which groups are found once."""
        self._due = True

    def perceived(self) -> None:
        """Find the groups, in the first stage of a step."""
        if self._due:
            self._due = False
            self._follow(self._labels())

    def state(self) -> tuple:
        """Groups, events and identities; the agents' column is the model's to keep."""
        return self.current, len(self.events), self._next

    def restore(self, state: tuple) -> None:
        """Go back to earlier groups."""
        self.current, count, self._next = state
        del self.events[count:]

    def diagnostics(self) -> dict[str, float]:
        """Number of groups, of agents in them, and the largest size."""
        sizes = [group.size for group in self.current]
        return {
            "groups": len(sizes), "grouped": sum(sizes), "largest_group": max(sizes, default=0),
        }  # fmt: skip

    # -- for agents, scenes and people -------------------------------------------------

    def find(self) -> tuple[Group, ...]:
        """Find the groups of the agents as they stand now, outside of a step."""
        self.model.space.forget()
        self._follow(self._labels())
        self.model.space.forget()
        return self.current

    def members(self, group: Group | int) -> AgentSet:
        """The agents of a group, as an ``AgentSet``."""
        identity = group.identity if isinstance(group, Group) else group
        agents = self.model.particles.agents
        rows = np.flatnonzero(self.column("group") == identity)
        return type(self.model.agents)([agents[row] for row in rows], random=self.model.random)

    # -- how it is done ----------------------------------------------------------------

    def _labels(self) -> np.ndarray:
        space, cells = self.model.space, self._cells()
        if space.obstacles is not None and space.obstacles.contributions != "through":
            return clusters_in_sight(
                self.column("position"), cells, self.radius, self.least, space.obstacles,
                space.domain,
            )  # fmt: skip
        return clusters_in(cells, len(self.model.particles), self.radius, self.least)

    def _cells(self) -> SortedCells:
        """The cells the agents have perceived by, where these fit the groups' radius."""
        space = self.model.space
        fits = _FITTING <= self.radius / space.core_radius < 1.0 - 1e-9 and not space.own_radii
        if fits and not space.domain.mirrors:  # a mirror image is nobody's neighbour
            return space.cells
        return search(self.column("position"), self.radius, space.domain)

    def _follow(self, label: np.ndarray) -> None:
        """Give the clusters identities, and note what has happened."""
        column, time = self.column("group"), self.model.elapsed
        known = np.array([group.identity for group in self.current], np.int64)
        count = int(label.max(initial=-1)) + 1
        from_old, from_share, into_new, into_share = overlap(label, column, known, count)
        # A cluster goes on as the group it has most from, if that has most of it here.
        goes_on = (from_old >= 0) & (into_new[from_old] == np.arange(count)) if len(known) else (
            np.zeros(count, bool)
        )  # fmt: skip
        identity = np.empty(count, np.int64)
        identity[goes_on] = known[from_old[goes_on]]
        fresh = np.flatnonzero(~goes_on)
        identity[fresh] = self._next + np.arange(len(fresh))
        self._next += len(fresh)
        for k in fresh:
            split = from_share[k] >= _MOST
            self._note(time, "split" if split else "birth", identity[k],
                       known[from_old[k]] if split else None)  # fmt: skip
        for k in np.setdiff1d(np.arange(len(known)), from_old[goes_on]):
            merged = into_share[k] >= _MOST
            self._note(time, "merge" if merged else "end", known[k],
                       identity[into_new[k]] if merged else None)  # fmt: skip
        born = {group.identity: group.born for group in self.current}
        self.current = self._described(label, identity, born)
        column[:] = np.append(identity, -1)[label]

    def _note(self, time: float, kind: str, group: int, other: int | None) -> None:
        other = None if other is None else int(other)
        self.events.append(GroupEvent(time, kind, int(group), other))

    def _described(
        self, label: np.ndarray, identity: np.ndarray, born: dict[int, float]
    ) -> tuple[Group, ...]:
        inside = np.flatnonzero(label >= 0)
        mass, position = self.column("mass")[inside], self.column("position")[inside]
        sizes = np.bincount(label[inside], minlength=len(identity))
        masses, centres, radii = centres_of(
            label[inside], position, mass, sizes, self.model.space.domain
        )
        time = self.model.elapsed
        groups = (
            Group(number, born.get(number, time), time - born.get(number, time), *values)
            for number, *values in zip(
                identity.tolist(), sizes.tolist(), masses.tolist(), *centres.T.tolist(),
                radii.tolist(), strict=True,
            )
        )  # fmt: skip
        return tuple(sorted(groups, key=lambda group: group.identity))
