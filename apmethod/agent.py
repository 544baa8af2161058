"""The agent-particle: a Mesa agent with the paper's four steps (paper 2.2)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import mesa
import numpy as np
from mesa.agent import AgentSet

from apmethod.particles import Column

if TYPE_CHECKING:
    from apmethod.model import ParticleModel


class Position(Column):
    """Where an agent is; what is assigned ends where the domain's borders let it.

    Within a step an agent displaces itself there, as far as obstacles let it; between steps
    it is put there, which is refused inside of an obstacle.
    """

    def __set__(self, agent: AgentParticle, value: Any) -> None:
        x, y = self.checked(value, 1)[0].tolist()
        obstacles = agent.model.obstacles
        if obstacles is not None:
            super().__set__(agent, obstacles.put(agent, x, y))
            return
        super().__set__(agent, agent.model.space.domain.place(x, y))


class AgentParticle(mesa.Agent):
    """A particle that is an agent: it perceives, contributes, messages and moves.

    The four methods are the definition of a step, in plain Python.  A class that does not
    override them has its agents stepped by compiled code that gives the same sums; a class
    that overrides some has those run agent by agent, beside compiled ones in one scene.

    ::

        class Shy(DiffusingParticle):
            def dynamics(self):
                crowd = sum(other.position - self.position for other in self.neighbours)
                return super().dynamics() - 0.1 * crowd

    All agents perceive before any contributes, all contribute before any messages, and so
    on: the motion is synchronous.

    Args:
        model: the model the agent lives in.
        columns: start values of columns that the class declares, such as ``position`` and
            ``mass``.

    Raises:
        TypeError: for a name that is not a column.
        ValueError: for a value of the wrong shape, not finite, or outside the domain.
    """

    position = Position(2, unit="length")
    mass = Column(start=1.0, unit="mass", minimum=0.0)
    #: There in scenes that give each agent its own, as `KeepNeighbours` does.
    core_radius = Column(kept=False, unit="length", minimum=0.0)

    _row: int | None = None

    def __init__(self, model: ParticleModel, **columns: Any):
        values = model.particles.checked(type(self), 1, columns)
        super().__init__(model)
        model.particles.append([self], values)

    @classmethod
    def create_agents(cls, model: ParticleModel, n: int, **columns: Any) -> AgentSet:
        """Create ``n`` agents at once; each column is one value or one for each agent."""
        if cls.__init__ is not AgentParticle.__init__:
            return super().create_agents(model, n, **columns)
        values = model.particles.checked(cls, n, columns)
        agents = []
        for _ in range(n):
            agent = cls.__new__(cls)
            # Before the next one is made: each leaves less room among the attribute names that
            # instances share, and those who find none have a dict of their own, some 250 bytes.
            mesa.Agent.__init__(agent, model)
            agents.append(agent)
        model.particles.append(agents, values)
        return AgentSet(agents, random=model.random)

    def remove(self) -> None:
        """Leave the model; the agent's columns can no longer be read."""
        if self._row is not None:
            super().remove()
            self.model.particles.remove(self)

    @classmethod
    def remove_agents(cls, agents: Iterable[AgentParticle]) -> None:
        """Have many agents of one model leave it at once.

        An agent whose class has a `remove` of its own leaves by that.
        """
        agents = [agent for agent in dict.fromkeys(agents) if agent._row is not None]
        alike = [agent for agent in agents if type(agent).remove is AgentParticle.remove]
        for agent in alike:
            mesa.Agent.remove(agent)
        if alike:
            alike[0].model.particles.remove_all(alike)
        for agent in agents:
            agent.remove()

    def __repr__(self) -> str:
        name = f"{type(self).__name__} {self.unique_id}"
        if self._row is None:
            return f"<{name}, removed>"
        x, y = self.position
        return f"<{name} at ({x:.4g}, {y:.4g})>"

    # -- the steps ---------------------------------------------------------------------

    def perceive(self) -> None:
        """Find the neighbours within the core radius (paper 2.4)."""
        self.neighbours = self.model.space.neighbours_of(self)

    def contribute(self) -> None:
        """Compute what each neighbour gives, once a pair, and post it to both ends (2.3)."""
        bus = self.model.bus
        bus.post(self, self, bus.own(self))
        for other in self.neighbours:
            if bus.received(self, sender=other):
                continue  # the other end has computed this pair
            mine, theirs = bus.exchange(self, other)
            bus.post(other, self, mine)
            if other.perceives(self):
                bus.post(self, other, theirs)

    def message(self) -> None:
        """Take in what has been posted: each term's sum goes to the column of its name."""
        for name, total in self.model.bus.read(self).items():
            self.model.particles.array(name)[self.model.particles.row(self)] = total

    def predict(self) -> None:
        """Go to a trial place that the integrator wants to perceive from."""
        self.model.motion.advance(self)

    def move(self) -> None:
        """End the step: go where the dynamics lead from where it began (paper 2.2, 3.1)."""
        self.model.motion.advance(self)

    # -- what the steps use ------------------------------------------------------------

    @property
    def neighbours(self) -> list[AgentParticle]:
        """The agents that this one perceives, as they stood when all perceived.

        Assigned in `perceive`; a class that perceives in its own way assigns its own list.
        """
        own = self.model.space.perceived.get(self)
        return self.model.space.neighbours_of(self) if own is None else own

    @neighbours.setter
    def neighbours(self, agents: Sequence[AgentParticle]) -> None:
        self.model.space.perceived[self] = list(agents)

    def perceives(self, other: AgentParticle) -> bool:
        """Whether ``other`` is among this agent's neighbours."""
        own = self.model.space.perceived.get(self)
        return self.model.space.near(self, other) if own is None else other in own

    def dynamics(self) -> np.ndarray:
        """The agent's velocity, the sum of the scene's laws; acceleration in second order.

        The method to override for behaviour that changes where an agent wants to go.
        """
        return self.model.motion.dynamics(self)

    @property
    def pos(self) -> np.ndarray | None:
        """``position``, by the name that Mesa uses."""
        return None if self._row is None else self.position

    @pos.setter
    def pos(self, value: Any) -> None:
        if value is not None:  # Mesa's constructor assigns None before there is a row
            self.position = value


class InertialParticle(AgentParticle):
    """An agent-particle that keeps its velocity: for laws that give an acceleration.

    With leap-frog the velocity is that of half a step before the position.
    """

    velocity = Column(2, unit="length/time")


class DiffusingParticle(AgentParticle):
    """An agent-particle of a diffusing field: its mass is what it carries of the field.

    The sums below are there in scenes whose diffusion form exchanges them.
    """

    density = Column(kept=False, unit="mass/area")
    density_gradient = Column(2, kept=False, unit="mass/volume")
    density_difference = Column(2, kept=False)
    blob_gradient = Column(2, kept=False, unit="1/length")
    #: What walls that take mass add to -grad u / u, see `apmethod.move.obstacles.absorption`.
    held_off = Column(2, kept=False, unit="1/length")
