"""Scenes whose agents carry a field that diffuses and flows (paper 3.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.agent import AgentParticle, DiffusingParticle
from apmethod.checks import finite_number, seed_checked, whole_number
from apmethod.contribute.reconstruct import reconstruct
from apmethod.contribute.smoothing import Kernel
from apmethod.field.accuracy import accuracy_with
from apmethod.field.start import Start, lay
from apmethod.model import ParticleModel
from apmethod.move.diffusion import Diffusion
from apmethod.move.flow import Flow
from apmethod.move.integrate import Integrator
from apmethod.move.motion import CARRY_TOLERANCE
from apmethod.perceive.core_radius import FollowDensity
from apmethod.perceive.domain import Domain, Open

if TYPE_CHECKING:
    from apmethod.move.obstacles.collection import Obstacles
    from apmethod.move.obstacles.shapes import Obstacle

#: Points along each side of the grid on which errors are taken.
_GRID = 160
#: Smoothing length of the reconstruction, in spacings.  More smooths more; less sees the
#: single agents where their lattice is deformed.
_READ_OUT = 1.8


class FieldModel(ParticleModel):
    """Agents on a lattice that carry a field u (paper eq 3.3, and a reaction)

        du/dt + div(V u) - D lap u = growth u.

    A scene derives from it and, where it knows the solution, defines ``exact``.

    An ``accuracy`` names a scheme whose parts go together (see `apmethod.field.accuracy`);
    each part can also be set by hand, None takes it from there.

    Args:
        start: u(x, y) at time 0, on arrays.
        box: (x_min, x_max, y_min, y_max) that the field stays in; errors are taken there.
        particles: number of agents.
        diffusivity: D, length^2/time.
        flow: V(x, y, t) giving (x, y), or None.
        growth: rate of growth, or of decay if negative, 1/time.
        accuracy: "paper", "conservative" or "accurate".
        form: diffusion form, "paper", "plain" or "blob".
        kernel: smoothing kernel or its name; it brings the spacings that suit it.
        spacings: smoothing length at the start, in spacings of the agents' lattice.
        integrator: see `ParticleModel`.
        remesh: strain of the agents' lattice at which they are laid on a new one, see
            `apmethod.field.remesh`; 0 for never.
        smooth: spacings by which a start with jumps is smoothed, see
            `apmethod.field.start`; the scene's clock then begins later than 0.
        follow_density: whether the core radius grows as the field thins out.
        dt, level, evaluation, tier, domain, rng: see `ParticleModel`.
        obstacles: see `ParticleModel`; the field is that outside of them.  Agents are not
            laid anew among obstacles, and jumps of the start are left in.  At walls that
            absorb u = 0: they take mass, unless ``Obstacles(absorbing="agents")``.
        agent_class: class of the agents.

    Raises:
        ValueError: for bad input, naming the argument, its value and what would be right.

    Attributes:
        accuracy: the scheme, an `apmethod.field.accuracy.Accuracy`.
        remesh: what lays the agents anew, or None.
    """

    def __init__(
        self,
        start: Callable[[np.ndarray, np.ndarray], np.ndarray],
        box: Sequence[float],
        *,
        particles: int = 4000,
        diffusivity: float = 1e-3,
        flow: Callable | None = None,
        growth: float = 0.0,
        accuracy: str = "conservative",
        form: str | None = None,
        kernel: str | Kernel | None = None,
        spacings: float | None = None,
        integrator: str | Integrator | None = None,
        remesh: float | None = None,
        smooth: float | None = None,
        follow_density: bool = True,
        dt: float | None = None,
        level: int | None = None,
        evaluation: str = "auto",
        tier: str = "compiled",
        domain: Domain | None = None,
        obstacles: Obstacles | Sequence[Obstacle] | None = None,
        rng: int | None = None,
        agent_class: type[AgentParticle] = DiffusingParticle,
    ):
        if obstacles is not None:
            from apmethod.move.obstacles.collection import collected  # loaded where there are some

            obstacles = collected(obstacles)
            obstacles.absorbing = obstacles.absorbing or "mass"
            if remesh or smooth:
                raise ValueError(
                    f"remesh is {remesh} and smooth is {smooth}; among obstacles agents cannot be "
                    "laid anew, nor jumps smoothed: leave both out"
                )
            remesh = smooth = 0.0
        particles = whole_number("particles", particles, least=1)
        scheme = self.accuracy = accuracy_with(
            accuracy, form=form, kernel=kernel, spacings=spacings, integrator=integrator,
            remesh=remesh, smooth=smooth,
        ).for_agents(particles)  # fmt: skip
        self.agent_class = agent_class
        self.growth = finite_number("growth", growth)
        self.box = tuple(box)
        diffusion = Diffusion(diffusivity, scheme.form)
        laws = [diffusion, *([Flow(flow)] if flow else [])]
        begun = lay(
            start,
            particles,
            self.box,
            least=scheme.least(particles),
            # Each seed has a lattice of its own place, so that seeds show what it matters.
            offset=np.random.default_rng(seed_checked(rng)).random(2),
            domain=domain or Open(),
            smooth=scheme.smooth,
            diffusivity=diffusion.diffusivity,
            settled=self._settled(laws[1:]),
            latest=0.5 * (self.until or np.inf),
            obstacles=obstacles,
        )
        super().__init__(
            agent_class,
            core_radius=scheme.spacings * begun.spacing * scheme.kernel.support,
            domain=domain,
            kernel=scheme.kernel,
            laws=laws,
            integrator=scheme.integrator,
            dt=dt,
            radius_rule=FollowDensity() if follow_density else None,
            level=level,
            evaluation=evaluation,
            tier=tier,
            obstacles=obstacles,
            rng=rng,
        )
        self.remesh = self._remesh_at(scheme.remesh)
        self._create(begun)

    def _settled(self, flows: Sequence[Flow]) -> float:
        """A quarter of the run, or as long as no flow deforms the field by 0.05."""
        if self.until is None:
            return 0.0
        places = np.column_stack([part.ravel() for part in self.grid()])
        rate = max((flow.deforming(places, 0.0) for flow in flows), default=0.0)
        return min(0.25 * self.until, 0.05 / rate if rate else np.inf)

    def _remesh_at(self, strain: float):
        if strain == 0.0:
            return None
        from apmethod.field.remesh import Remesh  # what a scene does not use is not loaded

        return Remesh(self, strain)

    def _create(self, begun: Start) -> None:
        """Create the agents, where and when the start says."""
        masses = begun.masses * np.exp(self.growth * begun.time)
        self.agent_class.create_agents(self, len(masses), position=begun.positions, mass=masses)
        if self.remesh is not None:
            self.remesh.take_down(begun.spacing)
        self.watch.unevenness = 1.0  # agents of a smooth field on a lattice
        if begun.time:
            self.elapsed = begun.time
            self._flow_until(begun.time)

    def _flow_until(self, time: float) -> None:
        """Carry the agents by the flow from time 0 on, as they have diffused since then."""
        places = self.particles.array("position").copy()
        for flow in (law for law in self.motion.laws if isinstance(law, Flow)):
            flow.carry(
                places, places, np.arange(len(places)), 0.0, time, flow.turning(places, 0.0),
                CARRY_TOLERANCE * self.bus.smoothing_length,
            )  # fmt: skip
        if not self.space.domain.is_open:
            places = [self.space.domain.place(x, y) for x, y in places.tolist()]
        self.particles.assign("position", places)

    # -- a step ------------------------------------------------------------------------

    def step(self) -> None:
        """One step; agents whose lattice has been strained too far are laid anew before it."""
        if self.remesh is not None:
            self.remesh.where_strained()
        super().step()

    def finish(self, dt: float) -> None:
        """Let each agent's mass grow, exactly: growth commutes with diffusion and flow."""
        if self.growth == 0.0:
            return
        factor = float(np.exp(self.growth * dt))
        if self.procedure.tier == "agents":
            for agent in self.particles.agents:
                agent.mass = factor * agent.mass
        else:
            self.particles.array("mass")[:] *= factor
        self.particles.array("density")[:] *= factor  # what was received of those masses
        if self.radius_rule is not None:
            self.radius_rule.grown(factor)

    # -- the field ---------------------------------------------------------------------

    @property
    def spacing(self) -> float:
        """The typical distance of agents now: it grows with the core radius."""
        return self.bus.smoothing_length / self.accuracy.spacings

    def exact(self, x: np.ndarray, y: np.ndarray, time: float) -> np.ndarray | None:
        """The solution at points and a time, or None where it is not known."""
        return None

    def field(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """u at points, x and y of one shape, from the agents as they stand.

        By the sixth-order `reconstruct`: an agent's own ``density`` is smoothed by the
        scheme's kernel and is no estimate of u to the scheme's order.
        """
        table = self.particles
        points = np.column_stack([np.ravel(x), np.ravel(y)])
        values = reconstruct(
            points, table.position, table.mass, _READ_OUT * self.spacing,
            domain=self.space.domain, obstacles=self.obstacles,
        )  # fmt: skip
        return values.reshape(np.shape(x))

    def field_on_agents(self) -> np.ndarray:
        """u where the agents are, in the order of their rows."""
        return self.field(*self.particles.position.T)

    def grid(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y of a regular grid over the box, each of shape (160, 160)."""
        x_min, x_max, y_min, y_max = self.box
        return np.meshgrid(np.linspace(x_min, x_max, _GRID), np.linspace(y_min, y_max, _GRID))

    def errors(self) -> dict[str, float]:
        """Relative L2 and L-infinity error on the grid; empty without an exact solution.

        Points of the grid in obstacles, or at their edge, do not count.
        """
        x, y = self.grid()
        if self.obstacles is not None:
            free = ~self.obstacles.occupied(np.column_stack([x.ravel(), y.ravel()]))
            x, y = x.ravel()[free], y.ravel()[free]
        exact = self.exact(x, y, self.elapsed)
        if exact is None:
            return {}
        off = self.field(x, y) - exact
        return {
            "l2_error": float(np.sqrt((off**2).sum() / (exact**2).sum())),
            "linf_error": float(np.abs(off).max() / np.abs(exact).max()),
        }

    def explained(self) -> list[tuple[str, str]]:
        """Rows that `explain` shows of this kind of scene."""
        rows = [("accuracy", str(self.accuracy))]
        if self.growth:
            rows.append(("growth", f"masses grow by exp({self.growth:g} dt), exactly"))
        return rows
