"""Change of description scale: a group becomes one agent, and dissolves again (paper 2.2).

Mesa's meta-agents are not used: they keep their members in the model, to be stepped on,
while here the point is that one agent takes the place of many.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.agent import AgentParticle
from apmethod.mesa_versions import come_back
from apmethod.particles import Column
from apmethod.skills.animal import Animal
from apmethod.skills.groups import Group, Groups
from apmethod.skills.signal import SignalField
from apmethod.skills.skill import Skill

if TYPE_CHECKING:
    from apmethod.model import ParticleModel


class Aggregate(Animal):
    """Many agents as one: their mass, their momentum and what they produce are its own.

    Attributes:
        size: how many agents it stands for.
        since: physical time at which it came to be, or at which the step began that made it.
        members: these agents, which are out of the model until it dissolves.
    """

    size = Column(dtype=np.int64, start=1)

    since: float
    members: Sequence[AgentParticle]


class DescriptionScale(Skill):
    """Replaces groups by aggregates, and aggregates by their members, at the end of steps.

    An aggregate has the sum of its members' masses, and of each column that a signal's
    production goes by; it stands at their centre of mass and, where agents have a velocity,
    moves with their momentum.  When it dissolves, its members come back around it as they
    stood around their centre, the same agents with the same ids; they share what it has then
    in the proportions they had, so that again nothing is lost.

    Args:
        groups: the groups, which must be among the scene's skills.
        gather: tells of a `Group` whether it becomes an aggregate.
        dissolve: tells of an `Aggregate` whether it dissolves; by default none does.
        agent_class: class of the aggregates; it must be among the model's agent classes.

    Attributes:
        aggregates: those that are there.
    """

    def __init__(
        self,
        groups: Groups,
        gather: Callable[[Group], bool],
        dissolve: Callable[[Aggregate], bool] = lambda aggregate: False,
        agent_class: type[Aggregate] = Aggregate,
    ):
        self.groups, self.agent_class = groups, agent_class
        self._gather, self._dissolve = gather, dissolve
        self.aggregates: list[Aggregate] = []
        #: What an aggregate had at first, and its members with their columns, by class.
        self._records: dict[Aggregate, list] = {}

    def __repr__(self) -> str:
        return f"{len(self.aggregates)} groups are aggregates"

    def attach(self, model: ParticleModel) -> None:
        """Find out which columns add up.

        Raises:
            ValueError: if the groups or the class of the aggregates are not the model's.
        """
        super().attach(model)
        if self.groups not in model.skills:
            raise ValueError("groups is not among the model's skills; name it there, too")
        if self.agent_class not in model.particles.classes:
            raise ValueError(
                f"agent_class is {self.agent_class.__name__}, which is not among the model's "
                "agent_classes; name it there, too"
            )
        produced = {skill.by for skill in model.skills if isinstance(skill, SignalField)}
        self._summed = sorted({"mass", "size"} | produced)

    def end(self, dt: float) -> None:
        """Dissolve and gather as the rules say."""
        self.aggregates = [one for one in self.aggregates if one._row is not None]
        for aggregate in tuple(self.aggregates):
            if self._dissolve(aggregate):
                self.dissolve(aggregate)
        for group in self.groups.current:
            if self._gather(group):
                self.gather(group)

    def diagnostics(self) -> dict[str, float]:
        """Number of aggregates, and of the agents that they stand for."""
        return {
            "aggregates": len(self.aggregates),
            "aggregated": sum(aggregate.size for aggregate in self.aggregates),
        }

    # -- one group, one aggregate ------------------------------------------------------

    def gather(self, group: Group) -> Aggregate | None:
        """Make an aggregate of a group's members; None if there are fewer than two left."""
        table, domain = self.model.particles, self.model.space.domain
        rows = np.flatnonzero(table.array("group") == group.identity)
        if len(rows) < 2:
            return None
        before = {name: array[rows] for name, array in table.state().items()}
        before.setdefault("size", np.ones(len(rows), np.int64))
        share = before["mass"] / before["mass"].sum() if before["mass"].any() else 1 / len(rows)
        apart = _apart(before["position"] - (group.x, group.y), domain.periods)
        off = (np.multiply(share, apart.T)).sum(axis=1)
        before["position"] = apart - off
        values = {
            name: before[name].sum(axis=0)
            for name in self._summed
            if isinstance(getattr(self.agent_class, name, None), Column)
        }
        values["position"] = domain.place(group.x + off[0], group.y + off[1])
        if "velocity" in before:
            values["velocity"] = np.multiply(share, before["velocity"].T).sum(axis=1)
        members = [table._agents[row] for row in rows]
        records = _by_class(members, before)
        for agent in members:
            agent.remove()
        self.aggregates = [one for one in self.aggregates if one._row is not None]
        aggregate = self.agent_class(self.model, **values)
        aggregate.since, aggregate.members = self.model.elapsed, members
        self.aggregates.append(aggregate)
        self._records[aggregate] = [values, *records]
        return aggregate

    def dissolve(self, aggregate: Aggregate) -> list[AgentParticle]:
        """Put an aggregate's members back into the model."""
        was, *records = self._records.pop(aggregate)
        place, domain = aggregate.position, self.model.space.domain
        now = {name: getattr(aggregate, name) for name in was}
        self.aggregates.remove(aggregate)
        aggregate.remove()
        for members, columns in records:
            columns["position"] = np.array(
                [domain.place(*where) for where in (columns["position"] + place).tolist()]
            )
            for name in set(was) & set(self._summed) - {"size"}:
                if was[name]:
                    columns[name] = columns[name] * (now[name] / was[name])
            if "velocity" in was:
                columns["velocity"] = columns["velocity"] + (now["velocity"] - was["velocity"])
            columns["group"] = np.full(len(members), -1)  # its group has ended; it is found anew
            for agent in members:
                come_back(self.model, agent)
            self.model.particles.append(members, columns)
            self.aggregates += [agent for agent in members if agent in self._records]
        return list(aggregate.members)


def _apart(difference: np.ndarray, periods: tuple[float, float]) -> np.ndarray:
    """Differences of places, of shape (n, 2), the shorter way round periodic axes."""
    for axis, period in enumerate(periods):
        if period:
            difference[:, axis] -= period * np.round(difference[:, axis] / period)
    return difference


def _by_class(
    members: Sequence[AgentParticle], columns: dict[str, np.ndarray]
) -> list[tuple[list[AgentParticle], dict[str, np.ndarray]]]:
    """Members of one class together, each class with its rows of the columns."""
    kinds: dict[type, list[int]] = {}
    for place, agent in enumerate(members):
        kinds.setdefault(type(agent), []).append(place)
    return [
        (
            [members[place] for place in places],
            {name: values[places] for name, values in columns.items()},
        )
        for places in kinds.values()
    ]
