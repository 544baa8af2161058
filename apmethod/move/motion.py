"""Motion: the laws and the integrator put to work on agents, one or all.

`advance` (one agent, in Python) and `advance_all` (compiled) are the only writers of
positions.  Both go through the same lines here: the formulas of a stage are loops over
rows, run in Python for one row and compiled for many.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.compile import compiled, in_blocks, plain
from apmethod.move.integrate import (
    LEAP_FROG,
    VERLET,
    Integrator,
    Stage,
    leap_frog,
    runge_kutta,
    verlet_drift,
    verlet_kick,
)
from apmethod.move.law import Flow, Law
from apmethod.particles import Column, Particles
from apmethod.perceive.domain import OPEN, Domain, place_along

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle


class Motion:
    """What moves a scene's agents.

    Args:
        particles: the agents' table; columns that the integrator needs are added to it.
        domain: rules where displacements end.
        laws: what the velocity (or acceleration) is the sum of.
        integrator: how it is carried through time.

    Raises:
        ValueError: for more than one flow where the integrator splits it off.
    """

    def __init__(
        self, particles: Particles, domain: Domain, laws: Sequence[Law], integrator: Integrator
    ):
        self.particles = particles
        self.domain = domain
        self.laws = tuple(laws)
        self.integrator = integrator
        flows = [law for law in self.laws if isinstance(law, Flow)]
        if integrator.splits and len(flows) > 1:
            raise ValueError(
                f"integrator {integrator.name!r} splits off one flow and the scene has "
                f"{len(flows)}; add them up in one V(x, y, t)"
            )
        self.split_flow = flows[0] if integrator.splits and flows else None
        #: The laws that a stage evaluates; a split flow is carried on its own.
        self.evaluated = tuple(law for law in self.laws if law is not self.split_flow)
        # Written within a step before they are read, so not part of an agent's state.
        scratch = ["start_of_step", "rate"]
        if integrator.of == "acceleration":
            particles.declare("velocity", Column(2, unit="length/time"))
            if integrator is VERLET:
                particles.declare("acceleration", Column(2, unit="length/time^2"))
            else:
                particles.declare("pushed", Column())
        else:
            scratch.append("displacement")
        if self.split_flow is not None:
            scratch.append("carried")
        for name in scratch:
            particles.declare(name, Column(2, kept=False))
        self._changes = -1

    # -- a step ------------------------------------------------------------------------

    def stages(self) -> tuple[Stage, ...]:
        """The stages of the next step, without those that the scene has no use for."""
        stages = self.integrator.stages
        if self.integrator.splits and self.split_flow is None:
            return tuple(stage for stage in stages if stage.interacts)
        if self.integrator is VERLET and self._changes != self.particles.changes:
            # The drift needs the acceleration at the start, which new agents lack.
            return (Stage(0.0, 0.0, 0.0), *stages)
        return stages

    def begin(self, time: float, dt: float) -> None:
        """Take down where the agents start from."""
        self.time, self.dt = time, dt
        positions = self.particles.array("position")
        self.particles.array("start_of_step")[:] = positions
        if "displacement" in self.particles:
            self.particles.array("displacement")[:] = 0.0
        if self.split_flow is not None:
            self.turning = self.split_flow.turning(positions, time)

    def enter(self, stage: Stage, smoothing_length: float) -> None:
        """Begin a stage."""
        self.stage = stage
        self.now = self.time + stage.at * self.dt
        self.smoothing_length = smoothing_length

    def end(self) -> None:
        """Note that the agents that are there now have moved."""
        self._changes = self.particles.changes

    # -- one agent, and all ------------------------------------------------------------

    def dynamics(self, agent: AgentParticle) -> np.ndarray:
        """The sum of the laws on one agent, an array of shape (2,)."""
        total = np.zeros(2)
        for law in self.evaluated:
            total += law.of(agent, self.now, self.smoothing_length)
        return total

    def advance(self, agent: AgentParticle) -> None:
        """Carry out the current stage on one agent, in Python."""
        row = self.particles.row(agent)
        if self.stage.interacts:
            self.particles.array("rate")[row] = agent.dynamics()
        self._carry_out(np.array([row]), in_python=True)
        position = self.particles.array("position")
        position[row] = self.domain.place(*position[row].tolist())

    def advance_all(self, rows: np.ndarray) -> None:
        """Carry out the current stage on the agents in ``rows`` of the table, compiled."""
        if self.stage.interacts:
            rate = self.particles.array("rate")
            rate[rows] = 0.0
            for law in self.evaluated:
                law.add_to(rate, self.particles, rows, self.now, self.smoothing_length)
        self._carry_out(rows, in_python=False)
        if self.domain.kinds != (OPEN, OPEN):
            position = self.particles.array("position")
            in_blocks(_place, len(rows), rows, position, *self.domain.limits)

    def _carry_out(self, rows: np.ndarray, in_python: bool) -> None:
        if self.integrator is LEAP_FROG:
            self._run(leap_frog, rows, in_python, "start_of_step", "rate", "velocity", "pushed",
                      self.dt, "position")  # fmt: skip
        elif self.integrator is VERLET:
            self._verlet(rows, in_python)
        elif self.stage.interacts:
            self._runge_kutta(rows, in_python)
        else:
            self._carry("carried", "start_of_step", rows, in_python, self.time)
            self.particles.array("position")[rows] = self.particles.array("carried")[rows]

    def _runge_kutta(self, rows: np.ndarray, in_python: bool) -> None:
        stage = self.stage
        start = "start_of_step" if self.split_flow is None else "carried"
        self._run(runge_kutta, rows, in_python, start, "rate", "displacement", self.dt,
                  stage.ahead, stage.weight, stage.moves, "position")  # fmt: skip
        if stage.moves and self.split_flow is not None:
            halfway = self.time + 0.5 * self.dt
            self._carry("position", "position", rows, in_python, halfway)

    def _verlet(self, rows: np.ndarray, in_python: bool) -> None:
        if not self.stage.interacts:
            self._run(verlet_drift, rows, in_python, "start_of_step", "velocity", "acceleration",
                      self.dt, "position")  # fmt: skip
        elif self.stage.moves:
            self._run(verlet_kick, rows, in_python, "rate", "velocity", "acceleration", self.dt)
        else:
            self.particles.array("acceleration")[rows] = self.particles.array("rate")[rows]

    def _carry(
        self, to: str, place: str, rows: np.ndarray, in_python: bool, time: float
    ) -> None:
        """Half a step in the split flow."""
        arrived, places = self.particles.array(to), self.particles.array(place)
        self.split_flow.carry(
            arrived, places, rows, time, 0.5 * self.dt, self.turning, in_python=in_python
        )

    def _run(self, formula: Callable, rows: np.ndarray, in_python: bool, *arguments) -> None:
        """A stage's formula over ``rows``; column names among the arguments become arrays."""
        arguments = [self.particles.array(a) if isinstance(a, str) else a for a in arguments]
        if in_python:
            plain(formula)(0, len(rows), rows, *arguments)
        else:
            in_blocks(formula, len(rows), rows, *arguments)


@compiled
def _place(first, last, rows, position, along_x, along_y):
    for k in range(first, last):
        row = rows[k]
        x, y = position[row, 0], position[row, 1]
        position[row, 0] = place_along(x, along_x[0], along_x[1], along_x[2])
        position[row, 1] = place_along(y, along_y[0], along_y[1], along_y[2])
