"""The procedure: which of the paper's steps a scene runs, how, and what it skips.

For each class of agents and each step the procedure decides once whether compiled code
does it or the agents' own methods.  Mixed scenes keep the promise of one contribution a
pair: pairs of two compiled agents are summed compiled, and every pair with an agent that
runs its own perceive or contribute is computed by that agent, in Python.
"""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from apmethod.agent import AgentParticle
from apmethod.move.integrate import Stage
from apmethod.perceive.cells import SortedCells

if TYPE_CHECKING:
    from apmethod.model import ParticleModel

PHASES = ("perceive", "contribute", "message", "move")

#: A class that overrides one of these methods runs the step in Python.
_METHODS = {
    "pairs": ("perceive", "contribute", "perceives"),
    "message": ("perceive", "contribute", "perceives", "message"),
    "move": ("predict", "move", "dynamics"),
}


class Procedure:
    """Runs the four steps for all agents of a model.

    Args:
        model: the model.
        tier: "compiled", or "agents" to run every agent's own methods.

    Raises:
        ValueError: for an unknown tier.
    """

    def __init__(self, model: ParticleModel, tier: str):
        if tier not in ("compiled", "agents"):
            raise ValueError(f"tier is {tier!r}; it must be 'compiled' or 'agents'")
        self.model = model
        self.tier = tier
        #: Seconds spent in each phase since the model was made.
        self.seconds = dict.fromkeys(PHASES, 0.0) | ({"skills": 0.0} if model.skills else {})
        self._clocks = {phase: _Clock(self.seconds, phase) for phase in self.seconds}
        self._split_cells: SortedCells | None = None
        self._everybody = np.arange(0)

    # -- who runs what -----------------------------------------------------------------

    def overrides(self, cls: type, step: str) -> list[str]:
        """Methods by which ``cls`` takes a step ("pairs", "message" or "move") in its own hands."""
        return [
            name
            for name in _METHODS[step]
            if getattr(cls, name) is not getattr(AgentParticle, name)
        ]

    def in_python(self, cls: type, step: str) -> bool:
        """Whether agents of ``cls`` run a step ("pairs", "message" or "move") themselves."""
        return self.tier == "agents" or bool(self.overrides(cls, step))

    @property
    def perceives(self) -> bool:
        """Whether anybody needs to know who is near: a term, or an agent's own method."""
        return bool(self.model.bus.rounds) or any(
            self.in_python(cls, step) for cls in self.model.particles.classes for step in _METHODS
        )

    @property
    def tidies(self) -> bool:
        """Whether the rows are to be put in lattice order before this step."""
        return self.worth_tidying and self.model.steps % 50 == 1

    @property
    def worth_tidying(self) -> bool:
        """Whether it pays to keep the rows in lattice order.

        Measured with agents at random places: from 8000 agents on a search and sum over
        scattered rows take an eighth longer, and a third from where the caches no longer hold
        the table.  Putting them in order takes the time of one or two.
        """
        return len(self.model.particles) >= 8_000 and bool(self.model.bus.rounds)

    def _divided(self, step: str) -> tuple[list[AgentParticle], np.ndarray]:
        """The agents that run a step in Python, and the rows of all others."""
        particles = self.model.particles
        own = [cls for cls in particles.classes if self.in_python(cls, step)]
        if not own:
            if len(self._everybody) != len(particles):
                self._everybody = np.arange(len(particles))
            return [], self._everybody
        rows = particles.rows_of(*own)
        others = np.setdiff1d(np.arange(len(particles)), rows, assume_unique=True)
        return [particles._agents[row] for row in rows], others

    # -- the four steps ----------------------------------------------------------------

    def perceive(self) -> None:
        """Take down where everybody is; agents with eyes of their own look around."""
        with self._clocks["perceive"]:
            space = self.model.space
            space.take_down()
            self._agents, self._rows = self._divided("pairs")
            self._split_cells = None
            if self._agents and len(self._rows):
                positions = self.model.particles.array("position")[self._rows]
                self._split_cells = space.sorted(positions, self._rows)
            for agent in self._agents:
                agent.perceive()

    def contribute(self, number: int) -> None:
        """Compute every pair of round ``number`` once."""
        with self._clocks["contribute"]:
            bus = self.model.bus
            bus.open(number)
            if not self._agents:
                bus.contribute_all(self.model.space.cells)
            elif self._split_cells is not None:
                bus.contribute_all(self._split_cells, self._rows)
            for agent in self._agents:
                agent.contribute()
            if self._split_cells is not None:
                self._contribute_one_sided()

    def _contribute_one_sided(self) -> None:
        """What compiled agents see of agents that did not compute the pair for them."""
        bus, space = self.model.bus, self.model.space
        in_python = set(self._agents)
        for agent in self._agents:
            for other in space.neighbours_of(agent):
                if other in in_python or bus.received(other, sender=agent):
                    continue
                theirs, mine = bus.exchange(other, agent)
                bus.post(agent, other, theirs)
                if agent.perceives(other):
                    bus.post(other, agent, mine)
        if space.mirrors:
            near_images = {
                each for agent in self._agents for each, *_ in space.mirrored_near(agent)
            }
            for other in near_images - in_python:
                bus.add_reflected(other, senders=in_python)

    def message(self) -> None:
        """Deliver the round's sums to the agents."""
        with self._clocks["message"]:
            agents, rows = self._divided("message")
            self.model.bus.deliver_all(rows if agents else None)
            for agent in agents:
                agent.message()
            self.model.bus.close()

    def advance(self, stage: Stage) -> None:
        """Send the agents to the stage's trial places, or move them for good."""
        with self._clocks["move"]:
            agents, rows = self._divided("move")
            if len(rows):
                self.model.motion.advance_all(rows)
            for agent in agents:
                if agent._row is None:
                    continue  # another agent has removed it in this very phase
                if stage.moves:
                    agent.move()
                else:
                    agent.predict()

    def take_turns(self, turn: str, *arguments: float) -> None:
        """Let each skill have its turn ("begin", "perceived" or "end")."""
        if self.model.skills:
            with self._clocks["skills"]:
                for skill in self.model.skills:
                    getattr(skill, turn)(*arguments)


class _Clock:
    """Adds the time spent in a ``with`` block to a phase's seconds."""

    def __init__(self, seconds: dict[str, float], phase: str):
        self._seconds, self._phase = seconds, phase

    def __enter__(self) -> None:
        self._began = perf_counter()

    def __exit__(self, *error: object) -> None:
        self._seconds[self._phase] += perf_counter() - self._began
