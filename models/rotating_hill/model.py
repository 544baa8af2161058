"""The rotating hill: convection and diffusion of a Gaussian hump (paper 3.1, Figure 7)."""

import numpy as np

from apmethod import FieldModel

from .agents import HillParticle

STEEPNESS = 40.0
CENTRE = (0.3, 0.3)


def rotation(x, y, t):
    """V = (y, -x): one turn, clockwise, in 2 pi."""
    return y, -x


class RotatingHill(FieldModel):
    """u = exp(-40 |x - c|^2) at the start, with c = (0.3, 0.3), turned by V = (y, -x).

    Args:
        particles: number of agents.
        diffusivity: D.
        accuracy: the scheme, "paper", "conservative" or "accurate".
        form, kernel, spacings, integrator, remesh: parts of it; None takes the accuracy's.
        dt: time step, None for the model's choice.
        level: p of the quad-lattice.
        evaluation: how compiled sums are taken.
        tier: "compiled" or "agents".
        rng: seed.
    """

    until = 2.0 * np.pi

    def __init__(
        self,
        particles: int = 4000,
        diffusivity: float = 1e-3,
        accuracy: str = "conservative",
        form: str | None = None,
        kernel: str | None = None,
        spacings: float | None = None,
        integrator: str | None = None,
        remesh: float | None = None,
        dt: float | None = None,
        level: int | None = None,
        evaluation: str = "auto",
        tier: str = "compiled",
        rng: int | None = None,
    ):
        self.diffusivity = diffusivity
        super().__init__(
            lambda x, y: self.exact(x, y, 0.0),
            (-1.25, 1.25, -1.25, 1.25),
            particles=particles,
            diffusivity=diffusivity,
            flow=rotation,
            accuracy=accuracy,
            form=form,
            kernel=kernel,
            spacings=spacings,
            integrator=integrator,
            remesh=remesh,
            dt=dt,
            level=level,
            evaluation=evaluation,
            tier=tier,
            rng=rng,
            agent_class=HillParticle,
        )

    def exact(self, x, y, time):
        """A Gaussian stays one: its centre turns, 1/(4 steepness) grows by D t."""
        spread = 1.0 + 4.0 * STEEPNESS * self.diffusivity * time
        x_c, y_c = self.exact_centroid(time)
        return np.exp(-STEEPNESS * ((x - x_c) ** 2 + (y - y_c) ** 2) / spread) / spread

    def exact_centroid(self, time):
        """Where the hill's centre is."""
        c, s = np.cos(time), np.sin(time)
        return c * CENTRE[0] + s * CENTRE[1], c * CENTRE[1] - s * CENTRE[0]
