"""Scenes whose agents carry a field that diffuses and flows (paper 3.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from apmethod.agent import AgentParticle, DiffusingParticle
from apmethod.checks import finite_number, seed_checked, whole_number
from apmethod.contribute.reconstruct import reconstruct
from apmethod.contribute.sample import sample
from apmethod.contribute.smoothing import kernel_named
from apmethod.model import ParticleModel
from apmethod.move.diffusion import Diffusion
from apmethod.move.law import Flow
from apmethod.perceive.core_radius import FollowDensity
from apmethod.perceive.domain import Domain

#: Points along each side of the grid on which errors are taken.
_GRID = 160


class FieldModel(ParticleModel):
    """Agents on a lattice that carry a field u, du/dt + div(V u) - D lap u = 0 (eq 3.3).

    A scene derives from it and, where it knows the solution, defines ``exact``.

    Args:
        start: u(x, y) at time 0, on arrays.
        box: (x_min, x_max, y_min, y_max) that the field stays in; errors are taken there.
        particles: number of agents.
        diffusivity: D, length^2/time.
        flow: V(x, y, t) giving (x, y), or None.
        form: diffusion form, "paper", "plain" or "blob".
        kernel: smoothing kernel or its name.
        spacings: smoothing length at the start, in spacings of the agents' lattice.
        follow_density: whether the core radius grows as the field thins out.
        integrator, dt, level, evaluation, tier, domain, rng: see `ParticleModel`.
        agent_class: class of the agents.
    """

    def __init__(
        self,
        start: Callable[[np.ndarray, np.ndarray], np.ndarray],
        box: Sequence[float],
        *,
        particles: int = 4000,
        diffusivity: float = 1e-3,
        flow: Callable | None = None,
        form: str = "blob",
        kernel: str = "gaussian",
        spacings: float = 1.7,
        follow_density: bool = True,
        integrator: str = "strang",
        dt: float | None = None,
        level: int = 1,
        evaluation: str = "auto",
        tier: str = "compiled",
        domain: Domain | None = None,
        rng: int | None = None,
        agent_class: type[AgentParticle] = DiffusingParticle,
    ):
        laws = [Diffusion(diffusivity, form), *([Flow(flow)] if flow else [])]
        self.box = tuple(box)
        self.spacings = finite_number("spacings", spacings, above=0.0)
        x_min, x_max, y_min, y_max = self.box
        # Each seed has a lattice of its own place, so that seeds show what it matters.
        offset = np.random.default_rng(seed_checked(rng)).random(2)
        positions, masses, spacing = sample(
            start,
            whole_number("particles", particles, least=1),
            (x_min, y_min),
            (x_max, y_max),
            offset=offset,
        )
        chosen = kernel_named(kernel)
        super().__init__(
            agent_class,
            core_radius=self.spacings * spacing * chosen.support,
            domain=domain,
            kernel=chosen,
            laws=laws,
            integrator=integrator,
            dt=dt,
            radius_rule=FollowDensity() if follow_density else None,
            level=level,
            evaluation=evaluation,
            tier=tier,
            rng=rng,
        )
        agent_class.create_agents(self, particles, position=positions, mass=masses)

    def exact(self, x: np.ndarray, y: np.ndarray, time: float) -> np.ndarray | None:
        """The solution at points and a time, or None where it is not known."""
        return None

    def field(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """u at points, x and y of one shape, from the agents as they stand."""
        spacing = self.bus.smoothing_length / self.spacings
        points = np.column_stack([np.ravel(x), np.ravel(y)])
        table = self.particles
        values = reconstruct(
            points, table.position, table.mass, 2.0 * spacing, domain=self.space.domain
        )
        return values.reshape(np.shape(x))

    def grid(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y of a regular grid over the box, each of shape (160, 160)."""
        x_min, x_max, y_min, y_max = self.box
        return np.meshgrid(np.linspace(x_min, x_max, _GRID), np.linspace(y_min, y_max, _GRID))

    def errors(self) -> dict[str, float]:
        """Relative L2 and L-infinity error on the grid; empty without an exact solution."""
        x, y = self.grid()
        exact = self.exact(x, y, self.elapsed)
        if exact is None:
            return {}
        off = self.field(x, y) - exact
        return {
            "l2_error": float(np.sqrt((off**2).sum() / (exact**2).sum())),
            "linf_error": float(np.abs(off).max() / np.abs(exact).max()),
        }
