"""What an animal remembers of its life: its age, its heading, and where it went."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from apmethod.checks import whole_number
from apmethod.skills.skill import Skill

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle
    from apmethod.model import ParticleModel


class Life(Skill):
    """Columns ``age``, time since an agent came, and ``heading``, where it last moved to.

    The heading is a unit vector, (1, 0) at first; an agent that stands still keeps its own.
    """

    def __repr__(self) -> str:
        return "age and heading"

    def attach(self, model: ParticleModel) -> None:
        """Declare the columns."""
        super().attach(model)
        self.declare("age", unit="time")
        self.declare_heading()

    def end(self, dt: float) -> None:
        """Grow older, and look where the step went."""
        self.column("age")[:] += dt
        went = self.column("position") - self.column("_start")
        for axis, period in enumerate(self.model.space.domain.periods):
            if period:
                went[:, axis] -= period * np.round(went[:, axis] / period)
        length = np.hypot(*went.T)
        moved = length > 0.0
        self.column("heading")[moved] = went[moved] / length[moved, None]


class Trajectories(Skill):
    """Records where some agents are after each step, or each few.

    Args:
        every: steps between two records.

    Attributes:
        times: physical time of each record.
        paths: for each followed agent's unique_id its places, one a record while it lives.
    """

    def __init__(self, every: int = 1):
        self.every = whole_number("every", every, least=1)
        self.times: list[float] = []
        self.paths: dict[int, list[tuple[float, float]]] = {}
        self._followed: dict[int, AgentParticle] = {}

    def __repr__(self) -> str:
        return f"of {len(self._followed)} agents, every {self.every} steps"

    def follow(self, agents: Iterable[AgentParticle]) -> None:
        """Follow agents from now on."""
        for agent in agents:
            self._followed[agent.unique_id] = agent
            self.paths.setdefault(agent.unique_id, []).append(tuple(agent.position.tolist()))
        self.times = self.times or [self.model.elapsed]

    def end(self, dt: float) -> None:
        """Record where they are."""
        if self.model.steps % self.every:
            return
        self.times.append(self.model.elapsed + dt)
        position = self.column("position")
        for identity, agent in self._followed.items():
            if agent._row is not None:
                self.paths[identity].append(tuple(position[agent._row].tolist()))
