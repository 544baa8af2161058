"""A Mesa model whose step is the paper's procedure (paper 2.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import mesa
import numpy as np

from apmethod.agent import AgentParticle
from apmethod.checks import finite_number, seed_checked
from apmethod.contribute.smoothing import CUBIC, Kernel, kernel_named
from apmethod.contribute.terms import Term
from apmethod.guards import check_finite, check_places, whole_or_not_at_all
from apmethod.message.bus import MessageBus
from apmethod.move.integrate import Integrator, Stage, integrator_named
from apmethod.move.law import Law
from apmethod.move.motion import Motion
from apmethod.particles import Particles
from apmethod.perceive.core_radius import RadiusRule
from apmethod.perceive.domain import Domain
from apmethod.perceive.lattice import QuadLattice
from apmethod.procedure import Procedure
from apmethod.skills.skill import Skill
from apmethod.watch import Watch

if TYPE_CHECKING:
    from apmethod.move.obstacles.collection import Obstacles
    from apmethod.move.obstacles.shapes import Obstacle

#: Share of the largest stable step, by theory, that a step chosen by the model takes.
#: ``apmethod bench stability`` measures limits of 0.96 of the theory and more on lattices, and
#: 0.83 and more for agents at random or in clusters.  Where neighbours carry unlike masses it is
#: less, and so is the chosen step; see `apmethod.unevenness`.
MARGIN = 0.7


class ParticleModel(mesa.Model):
    """A model of agent-particles.

    A scene derives from it, calls this constructor with what it consists of, and adds
    agents; whatever is not named costs nothing.

    Args:
        agent_classes: classes of the agents to come.
        core_radius: distance up to which agents perceive each other, a length.
        domain: open if not given.
        kernel: smoothing kernel or its name; its smoothing length is
            core_radius / kernel.support.
        laws: what moves the agents; see `Diffusion`, `Flow` and `Law`.
        terms: sums to exchange besides those that laws and agent classes name.
        integrator: an `Integrator` or its name.
        dt: time step; None lets the model choose each one, inside the stability limit.
        radius_rule: makes the core radius follow something; None keeps it.
        skills: what the agents can do besides, such as `SignalField`.
        obstacles: what agents can neither pass nor feel each other through, an `Obstacles`
            or a list of them.
        level: p of the quad-lattice, 4^p sub-domains a cell; None takes the quicker of 0, 1.
        skin: share of the core radius by which a search reaches further, to serve several steps.
        evaluation: how compiled sums are taken: "gathered", "scattered", "stored" or "auto".
        tier: "compiled", or "agents" to run every step agent by agent in Python.
        rng: seed of the model's random streams; an integer gives the same on all versions.

    Raises:
        ValueError: for bad input, naming the argument, its value and what would be right.

    Attributes:
        elapsed: physical time since the start (Mesa keeps ``time`` for its own clock).
        until: physical time to end a run at, or None; steps are fitted to end there.
        particles: the columns behind the agents.
        space: the quad-lattice.
        bus: the message bus.
        motion: laws and integrator.
        obstacles: what agents cannot pass, or None.
        procedure: how the steps are run; its ``seconds`` tell the time by phase.
        watch: looks for signs that the run has become unstable.
    """

    until: float | None = None
    #: Share of the largest stable step that a step chosen by the model takes.
    margin = MARGIN

    def __init__(
        self,
        agent_classes: Sequence[type[AgentParticle]] | type[AgentParticle],
        *,
        core_radius: float,
        domain: Domain | None = None,
        kernel: str | Kernel = CUBIC,
        laws: Sequence[Law] = (),
        terms: Sequence[Term] = (),
        integrator: str | Integrator = "euler",
        dt: float | None = None,
        radius_rule: RadiusRule | None = None,
        skills: Sequence[Skill] = (),
        obstacles: Obstacles | Sequence[Obstacle] | None = None,
        level: int | None = None,
        skin: float = 0.0,
        evaluation: str = "auto",
        tier: str = "compiled",
        rng: int | None = None,
    ):
        super().__init__(rng=seed_checked(rng))
        classes = [agent_classes] if isinstance(agent_classes, type) else list(agent_classes)
        self.elapsed = 0.0
        self.kernel = kernel_named(kernel)
        self.particles = Particles()
        if level is None and tier == "agents":
            level = 1  # agents in Python gain by each candidate less
        self.space = QuadLattice(self.particles, core_radius, domain, level, skin)
        for cls in classes:
            self.particles.declare_class(cls)
        self.dt = None if dt is None else finite_number("dt", dt, above=0.0)
        self.skills = tuple(skills)
        for skill in self.skills:  # before the terms, which may read what skills fill
            skill.attach(self)
        for law in laws:
            law.check(self.kernel)
        self.motion = Motion(
            self.particles, self.space, laws, integrator_named(integrator), self.kernel, obstacles
        )
        self.obstacles = self.motion.obstacles
        wanted = _unique(
            [*(t for law in laws for t in law.terms), *terms, *_declared_terms(classes)]
        )
        self.radius_rule = radius_rule
        if radius_rule is not None:
            wanted = _unique([*wanted, *radius_rule.terms])
            radius_rule.attach(self.space, self.particles, [term.name for term in wanted])
        self.bus = MessageBus(self.particles, self.space, self.kernel, wanted, evaluation)
        self.procedure = Procedure(self, tier)
        self.watch = Watch(self)
        self._check_dt()

    # -- the procedure -----------------------------------------------------------------

    def step(self) -> None:
        """One step: all perceive, then contribute, message, and move (paper 2.2).

        An integrator of several stages has the agents perceive again from trial places.

        Raises:
            StepFailed: if a column is no longer finite.  The agents are put back to where
                the step began, unless some came or went in it; a note on the error says so.

        Warns:
            Unstable: once in a run that shows signs of it; see `apmethod.watch`.
        """
        if self.procedure.tidies:
            self.space.tidy()
        with whole_or_not_at_all(self):
            if self.radius_rule is not None:
                self.radius_rule.adapt(self.space, self.particles)
            dt = self.next_dt()
            self.motion.begin(self.elapsed, dt)
            self.procedure.take_turns("begin", dt)
            for stage in self.motion.stages():
                self.motion.enter(stage, self.bus.smoothing_length)
                if stage.interacts:
                    self.perceive()
                    self.procedure.take_turns("perceived")
                    for number in range(len(self.bus.rounds)):
                        self.contribute(number)
                        self.message()
                self.advance(stage)
            self.motion.arrived()
            self.finish(dt)
            check_finite(self)
            self.watch.look()
            self.procedure.take_turns("end", dt)
            time = self._landed(dt)
            if self.obstacles is not None:
                self.obstacles.end(time, self.steps)
            self.elapsed = time
            # What Mesa's batch runs and browser page go by.
            self.running = self.until is None or self.elapsed < self.until

    def perceive(self) -> None:
        """All agents find their neighbours; skipped where nobody asks for them."""
        if self.procedure.perceives:
            check_places(self)
            self.procedure.perceive()

    def contribute(self, number: int) -> None:
        """All agents compute their pairs, once each."""
        self.procedure.contribute(number)

    def message(self) -> None:
        """All agents take in what they have been sent."""
        self.procedure.message()
        self.motion.received(self.bus.smoothing_length)

    def advance(self, stage: Stage) -> None:
        """All agents go to a trial place, or move."""
        self.procedure.advance(stage)

    def finish(self, dt: float) -> None:
        """What a scene does in a step of length ``dt`` once all have moved; nothing here."""

    # -- time --------------------------------------------------------------------------

    def next_dt(self) -> float:
        """The next time step: ``dt``, or one within the limits; fitted to end at ``until``."""
        limit = self.dt if self.dt is not None else self._chosen_dt()
        if self.until is None or self.elapsed >= self.until:
            return limit
        left = self.until - self.elapsed
        if self.dt is not None:
            return left if left < limit * (1.0 + 1e-9) else limit
        return left / np.ceil(left / limit * (1.0 - 1e-12))

    def largest_dt(self) -> float:
        """The largest stable time step now, infinite where nothing limits it."""
        reach, h = self.motion.integrator.reach, self.bus.shortest_length
        limits = (law.largest_step(self.kernel, h, reach) for law in self.motion.laws)
        return min(limits, default=np.inf)

    def _chosen_dt(self) -> float:
        limit = self.margin * self.watch.share_left() * self.largest_dt()
        integrator, positions = self.motion.integrator, self.particles.array("position")
        for law in self.motion.laws:
            rate_at = law.deforming if integrator.splits else law.turning
            # A flow may change within a step that nothing else keeps short.
            for share in (0.0, 0.5, 1.0) if np.isfinite(limit) else (0.0,):
                rate = rate_at(positions, self.elapsed + share * limit)
                if rate > 0.0:
                    limit = min(limit, integrator.turn / rate)
        if not np.isfinite(limit):
            limit = self._limit_of_turning(positions)
        return float(limit)

    def _limit_of_turning(self, positions: np.ndarray) -> float:
        """A radian a step, where a flow only turns the agents and nothing else limits it."""
        rates = [law.turning(positions, self.elapsed) for law in self.motion.laws]
        if not rates or max(rates) == 0.0:
            raise ValueError("dt is None and no law limits it; give dt")
        return 1.0 / max(rates)

    def _check_dt(self) -> None:
        limit = self.largest_dt()
        if limit == 0.0:
            raise ValueError(
                f"integrator is {self.motion.integrator.name!r}, which carries accelerations "
                "through time and is unstable at every dt with a law that gives a velocity, as "
                "diffusion does; take one for velocities, such as 'midpoint'"
            )
        if self.motion.integrator.of == "acceleration" and self.dt is None:
            raise ValueError("dt is None; a second-order law needs one given")
        if self.dt is not None and self.dt > limit:
            raise ValueError(
                f"dt is {self.dt:.6g}, which is unstable: with this core radius, kernel, form "
                f"and integrator it must be at most {limit:.6g}; give a smaller one, or None"
            )

    def _landed(self, dt: float) -> float:
        """Time after the step, without the rounding of the last one."""
        time = self.elapsed + dt
        if self.until is not None and abs(time - self.until) <= 1e-12 * abs(self.until):
            return self.until
        return time

    # -- in numbers --------------------------------------------------------------------

    def diagnostics(self) -> dict[str, float]:
        """Numbers that tell how a run is doing, for one row of a series."""
        mass = self.particles.array("mass")
        position = self.particles.array("position")
        total = float(mass.sum())
        centroid = (mass @ position) / total if total else np.full(2, np.nan)
        numbers = {
            "step": self.steps,
            "time": self.elapsed,
            "agents": len(self.particles),
            "mass": total,
            "centroid_x": float(centroid[0]),
            "centroid_y": float(centroid[1]),
            "core_radius": self.space.core_radius,
        }
        if self.obstacles is not None:
            numbers |= self.obstacles.diagnostics()
        for skill in self.skills:
            numbers |= skill.diagnostics()
        return numbers


def _declared_terms(classes: Sequence[type]) -> list[Term]:
    """Terms that agent classes, or what they derive from, declare."""
    return [
        value
        for cls in classes
        for owner in reversed(cls.__mro__)
        for value in vars(owner).values()
        if isinstance(value, Term)
    ]


def _unique(terms: Sequence[Term]) -> list[Term]:
    """The terms without repetition; two different ones of one name are an error."""
    found: dict[str, Term] = {}
    for term in terms:
        if found.setdefault(term.name, term) is not term:
            raise ValueError(f"there are two terms named {term.name!r}; rename one of them")
    return list(found.values())
