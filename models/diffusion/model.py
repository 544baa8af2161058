"""Diffusion of a density by velocity alone (paper 3.1, Figure 7 a and b): 200 steps."""

import numpy as np

from apmethod import FieldModel

from .agents import Parcel

#: Height, variance and centre of the humps that make up the density at the start.
HUMPS = (
    (1.0, 0.020, -0.25, 0.10),
    (0.6, 0.008, 0.20, 0.25),
    (0.8, 0.012, 0.10, -0.30),
)


class DensityDiffusion(FieldModel):
    """Three overlapping Gaussian humps of different height and width spread out.

    A single Gaussian would flatter every scheme: the logarithm of its density is a
    parabola, so its diffusion velocity is linear and the agents' lattice only dilates.

    Args:
        particles: number of agents.
        diffusivity: D.
        accuracy: the scheme, "paper", "conservative" or "accurate".
        form, kernel, spacings, integrator, remesh: parts of it; None takes the accuracy's.
        dt: time step; the run makes 200 of the default one. None for the model's choice.
        level: p of the quad-lattice.
        evaluation: how compiled sums are taken.
        tier: "compiled" or "agents".
        rng: seed.
    """

    until = 2.0

    def __init__(
        self,
        particles: int = 4000,
        diffusivity: float = 5e-3,
        accuracy: str = "conservative",
        form: str | None = None,
        kernel: str | None = None,
        spacings: float | None = None,
        integrator: str | None = None,
        remesh: float | None = None,
        dt: float | None = 0.01,
        level: int | None = None,
        evaluation: str = "auto",
        tier: str = "compiled",
        rng: int | None = None,
    ):
        self.diffusivity = diffusivity
        super().__init__(
            lambda x, y: self.exact(x, y, 0.0),
            (-1.0, 1.0, -1.0, 1.0),
            particles=particles,
            diffusivity=diffusivity,
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
            agent_class=Parcel,
        )

    def exact(self, x, y, time):
        """Each hump stays a Gaussian, its variance grows by 2 D t."""
        total = np.zeros_like(x)
        for height, variance, x_c, y_c in HUMPS:
            wider = variance + 2.0 * self.diffusivity * time
            distance_2 = (x - x_c) ** 2 + (y - y_c) ** 2
            total += height * variance / wider * np.exp(-0.5 * distance_2 / wider)
        return total

    def exact_centroid(self, time):
        """Diffusion leaves the centre of mass where it is."""
        weights = np.array([height * variance for height, variance, _, _ in HUMPS])
        return weights @ np.array([hump[2:] for hump in HUMPS]) / weights.sum()
