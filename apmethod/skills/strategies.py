"""Strategies: which group an animal goes to join, if any (paper 3.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from apmethod.checks import finite_number
from apmethod.compile import column_reader, compiled, in_blocks, inlined, plain
from apmethod.perceive.domain import shortest
from apmethod.skills.follow import Follow
from apmethod.skills.groups import Groups
from apmethod.skills.sense import in_cone
from apmethod.skills.signal import SignalField
from apmethod.skills.skill import Skill

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle
    from apmethod.model import ParticleModel


class Prospect(NamedTuple):
    """What a strategy may weigh up of a group."""

    distance: float  #: from the agent to the group's centre
    age: float  #: how long the group has lived
    size: float  #: number of its members
    mass: float  #: their mass
    radius: float  #: root mean square distance of its members from the centre


class Strategy:
    """How an animal chooses the group it wants to be in.

    A strategy of one's own is a score; the agent heads for the group with the highest::

        class LargestGroup(Strategy):
            def score(agent, group):
                return group.size

    ``score`` is plain Python that numba compiles; ``group`` is a `Prospect`, ``agent`` has
    the columns named in ``reads``.  Without a score an animal joins no group on purpose: it
    follows the highest gradient.
    """

    reads: tuple[str, ...] = ()
    score: Callable[[Any, Prospect], float] | None = None


class HighestGradient(Strategy):
    """Follow the signal wherever it leads."""


class ClosestGroup(Strategy):
    """Join the group whose centre is nearest."""

    def score(agent, group):
        """The nearer, the better."""
        return -group.distance


class FarthestGroup(Strategy):
    """Join the group whose centre is farthest away."""

    def score(agent, group):
        """The farther, the better."""
        return group.distance


class OldestGroup(Strategy):
    """Join the group that has lived longest."""

    def score(agent, group):
        """The older, the better."""
        return group.age


class YoungestGroup(Strategy):
    """Join the group that has come up last."""

    def score(agent, group):
        """The younger, the better."""
        return -group.age


class Strategies(Skill):
    """Lets each animal go by the strategy it has been given.

    The column ``strategy`` is the number of an animal's strategy among ``choices``, 0 at
    first, and ``goal`` the direction of the group it wants to join: a unit vector, or 0 if
    it has no such group or is in it.  `Pursue` is the law that takes it there.

    Args:
        groups: the groups to choose from, which must come before among the scene's skills.
        choices: classes of strategies.
        sight: column with how far each agent sees groups; a group is seen if its disc, of
            its `Prospect.radius`, is that near.  By default all groups are known to all.
        view: column with the cosine of the half angle of an agent's view cone around its
            ``heading``, in which a group's centre must be to be seen; see `SignalField`.
            The group that an agent is in it always sees.

    Raises:
        ValueError: for no choices; `attach` refuses ``groups`` that do not come before, and
            columns that the scene does not have.
        TypeError: for a choice that is not a subclass of `Strategy`.
    """

    def __init__(
        self,
        groups: Groups,
        choices: Sequence[type[Strategy]],
        *,
        sight: str | None = None,
        view: str | None = None,
    ):
        self.groups, self.sight, self.view = groups, sight, view
        self.choices = tuple(choices)
        if not self.choices:
            raise ValueError("choices is empty; name at least one strategy")
        for choice in self.choices:
            if not (isinstance(choice, type) and issubclass(choice, Strategy)):
                raise TypeError(f"choices has {choice!r}; each must be a subclass of Strategy")

    def __repr__(self) -> str:
        return ", ".join(choice.__name__ for choice in self.choices)

    def attach(self, model: ParticleModel) -> None:
        """Declare the columns ``strategy`` and ``goal``."""
        super().attach(model)
        if self.groups not in model.skills[: model.skills.index(self)]:
            raise ValueError("skills has Strategies before its Groups; name the groups first")
        self.require(self.sight, self.view)
        if self.view is not None:
            self.declare_heading()
        self.declare("strategy", dtype=np.int64)
        self.declare("goal", 2)

    def number(self, choice: type[Strategy]) -> int:
        """The number of a strategy, to create agents with."""
        if choice not in self.choices:
            names = ", ".join(each.__name__ for each in self.choices)
            raise ValueError(f"{choice!r} is not among the scene's strategies, {names}")
        return self.choices.index(choice)

    def give(self, agents: Iterable[AgentParticle], choice: type[Strategy]) -> None:
        """Give a strategy to agents."""
        rows = [self.model.particles.row(agent) for agent in agents]
        self.column("strategy")[rows] = self.number(choice)

    def perceived(self) -> None:
        """Let every animal look for the group it wants to be in."""
        goal, strategy = self.column("goal"), self.column("strategy")
        goal[:] = 0.0
        groups = self.groups.current
        if not groups:
            return
        table = np.array(
            [(g.identity, g.x, g.y, g.age, g.size, g.mass, g.radius) for g in groups], float
        )
        for number, choice in enumerate(self.choices):
            if choice.score is None:
                continue
            rows = np.flatnonzero(strategy == number)
            columns = tuple(self.column(name) for name in choice.reads) or (goal,)
            particles = self.model.particles
            widths = tuple((name, particles.columns[name].components) for name in choice.reads)
            run = _compile_choice(choice.score, widths)
            arguments = (rows, columns, self.column("position"), self.column("group"), table,
                         self.model.space.domain.periods, *self._eyes(), goal)  # fmt: skip
            if self.model.procedure.tier == "agents":
                plain(run)(0, len(rows), *arguments)
            else:
                in_blocks(run, len(rows), *arguments, least=2000)

    def _eyes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """How far agents see, their headings and view cones; empty for all that see all."""
        sight = np.empty(0) if self.sight is None else self.column(self.sight)
        if self.view is None:
            return sight, np.empty((0, 2)), np.empty(0)
        return sight, self.column("heading"), self.column(self.view)


@cache
def _compile_choice(score: Callable, reads: tuple[tuple[str, int | None], ...]) -> Callable:
    read = column_reader(reads)
    inlined(score, arrays=True)

    @compiled
    def head_for_the_best(
        first, last, rows, columns, position, member, table, periods, sight, heading, view, goal
    ):
        for k in range(first, last):
            row = rows[k]
            me = read(columns, row)
            best, most, ahead_x, ahead_y, far = -1, -np.inf, 0.0, 0.0, 0.0
            for g in range(table.shape[0]):
                dx = shortest(table[g, 1] - position[row, 0], periods[0])
                dy = shortest(table[g, 2] - position[row, 1], periods[1])
                distance = np.sqrt(dx * dx + dy * dy)
                if table[g, 0] != member[row]:
                    if sight.size and distance - table[g, 6] > sight[row]:
                        continue
                    if view.size:
                        head_x, head_y = heading[row, 0], heading[row, 1]
                        ahead = view[row] * np.sqrt(head_x * head_x + head_y * head_y)
                        if not in_cone(dx, dy, distance, head_x, head_y, ahead):
                            continue
                value = score(
                    me, Prospect(distance, table[g, 3], table[g, 4], table[g, 5], table[g, 6])
                )
                if value > most:
                    best, most, ahead_x, ahead_y, far = g, value, dx, dy, distance
            if best >= 0 and table[best, 0] != member[row] and far > 0.0:
                goal[row, 0], goal[row, 1] = ahead_x / far, ahead_y / far

    return head_for_the_best


class Pursue(Follow):
    """An animal goes to the group it wants to be in; else it follows the signal.

        V = speed goal   where there is a goal, else   lambda grad s

    Args:
        signal: the field.
        sensitivity: lambda, see `Follow`.
        speed: of animals on the way to a group, length/time.

    Raises:
        ValueError: if a number is not finite, or the speed negative.
    """

    def __init__(self, signal: SignalField, sensitivity: float, speed: float):
        super().__init__(signal, sensitivity)
        self.name = f"goes to its group or follows {signal.name}"
        self.parameters["speed"] = finite_number("speed", speed, least=0.0)
        self.reads = (*self.reads, "goal")
        self.formula = _pursue(self.formula)


@cache
def _pursue(uphill: Callable) -> Callable:
    inlined(uphill)

    def pursue(agent, p):
        if agent.goal[0] != 0.0 or agent.goal[1] != 0.0:
            return p.speed * agent.goal[0], p.speed * agent.goal[1]
        return uphill(agent, p)

    return pursue
