"""Motion: the laws and the integrator put to work on agents, one or all.

`advance` (one agent, in Python) and `advance_all` (compiled) are the only writers of
positions.  Both go through the same lines here: the formulas of a stage are loops over
rows, run in Python for one row and compiled for many.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.compile import in_blocks, plain
from apmethod.contribute.smoothing import Kernel
from apmethod.move.flow import Flow
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
from apmethod.move.law import Law, Now
from apmethod.particles import Column, Particles
from apmethod.perceive.domain import bounce, place

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle
    from apmethod.move.obstacles.absorption import Absorption
    from apmethod.move.obstacles.collection import Obstacles
    from apmethod.move.obstacles.shapes import Obstacle
    from apmethod.perceive.lattice import QuadLattice

#: Error that a split flow is carried with, in smoothing lengths: to round-off, almost.
CARRY_TOLERANCE = 1e-11


class Motion:
    """What moves a scene's agents.

    Args:
        particles: the agents' table; columns that the integrator needs are added to it.
        space: its domain rules where displacements end; it learns of the obstacles.
        laws: what the velocity (or acceleration) is the sum of.
        integrator: how it is carried through time.
        kernel: the scene's smoothing kernel.
        obstacles: what displacements meet, if there is anything.

    Raises:
        ValueError: for more than one flow where the integrator splits it off.
    """

    def __init__(
        self,
        particles: Particles,
        space: QuadLattice,
        laws: Sequence[Law],
        integrator: Integrator,
        kernel: Kernel,
        obstacles: Obstacles | Sequence[Obstacle] | None = None,
    ):
        self.kernel = kernel
        self.particles = particles
        self.domain = space.domain
        self.obstacles: Obstacles | None = None
        if obstacles is not None:
            from apmethod.move.obstacles.collection import collected  # costs nothing without

            self.obstacles = space.obstacles = collected(obstacles)
            self.obstacles.attach(particles, self.domain)
        #: What takes the mass of agents beside walls, where walls do.
        self.absorption: Absorption | None = None
        if self.obstacles is not None and self.obstacles.takes_mass:
            from apmethod.move.obstacles.absorption import Absorption

            self.absorption = Absorption(self.obstacles, space, laws)
            laws = self.absorption.laws
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
        particles.declare("_start", Column(2, kept=False, like="position"))
        particles.declare("_rate", Column(2, kept=False))
        if integrator.of == "acceleration":
            if "velocity" not in particles:
                raise ValueError(
                    f"integrator is {integrator.name!r}, which moves agents by acceleration, and "
                    "no agent class has a velocity; derive one from InertialParticle"
                )
            if integrator is VERLET:
                particles.declare("_acceleration", Column(2))
            else:
                particles.declare("_pushed", Column())
        else:
            particles.declare("_displacement", Column(2, kept=False))
        if self.split_flow is not None:
            particles.declare("_carried", Column(2, kept=False, like="position"))
        self._changes = -1
        self.stage: Stage | None = None
        self._own_w = float(kernel.w(0.0, 1.0))

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
        self.particles.array("_start")[:] = positions
        if "_displacement" in self.particles:
            self.particles.array("_displacement")[:] = 0.0
        if self.split_flow is not None:
            self.turning = self.split_flow.turning(positions, time)
        if self.obstacles is not None:
            self.obstacles.begin(time, dt)
        if self.absorption is not None:
            self.absorption.begin()

    def enter(self, stage: Stage, smoothing_length: float) -> None:
        """Begin a stage; ``smoothing_length`` is the (largest) one of the agents."""
        self.stage = stage
        self.smoothing_length = smoothing_length

    def received(self, smoothing_length: float) -> None:
        """Note that the agents have taken in their sums; walls that take mass mind them."""
        if self.absorption is not None:
            self.absorption.received(smoothing_length)

    def now(self, row: int | slice = slice(None)) -> Now:
        """What laws may use in this stage besides the agent, for one row or all."""
        h: float | np.ndarray = self.smoothing_length
        if "core_radius" in self.particles:
            h = self.particles.array("core_radius")[row] / self.kernel.support
        return Now(self.time + self.stage.at * self.dt, h, self._own_w / h**2)

    @property
    def arrives(self) -> bool:
        """Whether the stage leads where the step ends; otherwise to a trial place."""
        if self.integrator is VERLET:
            return not self.stage.interacts
        return self.stage.moves

    @property
    def reflected(self) -> str:
        """The column of velocities that walls reflect; scratch where agents keep none."""
        return "velocity" if self.integrator.of == "acceleration" else "_rate"

    def arrived(self) -> None:
        """Note that the agents that are there now have moved; now the obstacles do."""
        if self.absorption is not None:
            self.absorption.arrived()
        if self.obstacles is not None:
            self.obstacles.sweep(self.reflected)
        self._changes = self.particles.changes

    def end(self) -> None:
        """End the step, however it went."""
        self.stage = None

    # -- one agent, and all ------------------------------------------------------------

    def dynamics(self, agent: AgentParticle) -> np.ndarray:
        """The sum of the laws on one agent, an array of shape (2,)."""
        total, now = np.zeros(2), self.now(self.particles.row(agent))
        for law in self.evaluated:
            total += law.of(agent, now)
        return total

    def advance(self, agent: AgentParticle) -> None:
        """Carry out the current stage on one agent, in Python."""
        if self.stage is None:
            raise RuntimeError("agents move within a step of their model; call model.step()")
        row = self.particles.row(agent)
        rows = np.array([row])
        if self.stage.interacts:
            self._hold_off(rows, in_python=True)
            self.particles.array("_rate")[row] = agent.dynamics()
        self._carry_out(rows, in_python=True)
        self._place(rows, in_python=True)

    def advance_all(self, rows: np.ndarray) -> None:
        """Carry out the current stage on the agents in ``rows`` of the table, compiled."""
        if self.stage.interacts:
            self._hold_off(rows, in_python=False)
            rate = self.particles.array("_rate")
            rate.fill(0.0)
            for law in self.evaluated:
                law.add_to(rate, self.particles, rows, self.now())
        self._carry_out(rows, in_python=False)
        self._place(rows, in_python=False)

    def _hold_off(self, rows: np.ndarray, in_python: bool) -> None:
        """Hold agents off walls that take mass, which take it."""
        if self.absorption is not None:
            self.absorption.look(rows, in_python=in_python)
            self.absorption.take(rows, self.now(), self.stage, self.dt, in_python=in_python)

    def _carry_out(self, rows: np.ndarray, in_python: bool) -> None:
        if self.integrator is LEAP_FROG:
            self._run(leap_frog, rows, in_python, "_start", "_rate", "velocity", "_pushed",
                      self.dt, "position")  # fmt: skip
        elif self.integrator is VERLET:
            self._verlet(rows, in_python)
        elif self.stage.interacts:
            self._runge_kutta(rows, in_python)
        else:
            self._carry("_carried", "_start", rows, in_python, self.time)
            self.particles.array("position")[rows] = self.particles.array("_carried")[rows]

    def _place(self, rows: np.ndarray, in_python: bool) -> None:
        """Let displacements end where obstacles and the domain's borders allow."""
        if self.obstacles is not None:
            if self.integrator is not VERLET or not self.stage.interacts:
                self.obstacles.carry(
                    rows, self.reflected, trial=not self.arrives, in_python=in_python
                )
            return
        if self.domain.is_open:
            return
        if self.integrator.of == "acceleration":
            self._run(bounce, rows, in_python, "position", "velocity", *self.domain.limits)
        self._run(place, rows, in_python, "position", *self.domain.limits)

    def _runge_kutta(self, rows: np.ndarray, in_python: bool) -> None:
        stage = self.stage
        start = "_start" if self.split_flow is None else "_carried"
        self._run(runge_kutta, rows, in_python, start, "_rate", "_displacement", self.dt,
                  stage.ahead, stage.weight, stage.moves, "position")  # fmt: skip
        if stage.moves and self.split_flow is not None:
            halfway = self.time + 0.5 * self.dt
            self._carry("position", "position", rows, in_python, halfway)

    def _verlet(self, rows: np.ndarray, in_python: bool) -> None:
        if not self.stage.interacts:
            self._run(verlet_drift, rows, in_python, "_start", "velocity", "_acceleration",
                      self.dt, "position")  # fmt: skip
        elif self.stage.moves:
            self._run(verlet_kick, rows, in_python, "_rate", "velocity", "_acceleration", self.dt)
        else:
            self.particles.array("_acceleration")[rows] = self.particles.array("_rate")[rows]

    def _carry(self, to: str, place: str, rows: np.ndarray, in_python: bool, time: float) -> None:
        """Half a step in the split flow."""
        arrived, places = self.particles.array(to), self.particles.array(place)
        self.split_flow.carry(
            arrived, places, rows, time, 0.5 * self.dt, self.turning,
            CARRY_TOLERANCE * self.smoothing_length, in_python=in_python,
        )  # fmt: skip

    def _run(self, formula: Callable, rows: np.ndarray, in_python: bool, *arguments) -> None:
        """A stage's formula over ``rows``; column names among the arguments become arrays."""
        arguments = [self.particles.array(a) if isinstance(a, str) else a for a in arguments]
        if in_python:
            plain(formula)(0, len(rows), rows, *arguments)
        else:
            in_blocks(formula, len(rows), rows, *arguments)
