"""Diffusion among squares: a hump of matter spreads between obstacles (paper 3.1, Figure 8)."""

import numpy as np

from apmethod import (
    KERNELS,
    Bounded,
    Diffusion,
    FollowDensity,
    Obstacles,
    ParticleModel,
    sample,
    square,
)

from .agents import Spreading

STEEPNESS = 120.0
CENTRE = (0.48, 0.52)
#: Middle and side of the squares, after the paper's Figure 6.
SQUARES = (
    ((0.22, 0.78), 0.16),
    ((0.56, 0.84), 0.12),
    ((0.82, 0.66), 0.18),
    ((0.70, 0.36), 0.14),
    ((0.24, 0.42), 0.18),
    ((0.46, 0.16), 0.16),
    ((0.86, 0.12), 0.10),
)


def hump(x, y):
    """Where the matter is at the start."""
    return np.exp(-STEEPNESS * ((x - CENTRE[0]) ** 2 + (y - CENTRE[1]) ** 2))


class DiffusionAmongObstacles(ParticleModel):
    """exp(-120 |x - c|^2) spreads in the unit square between seven squares.

    Args:
        particles: number of agents; those that would start in an obstacle are left out.
        diffusivity: D.
        behaviour: what an agent does at a wall: "repulse", "bounce", "slide", "stick" or
            "absorb".
        contributions: what agents feel of each other where walls are: "mirrored", "blocked" or
            "through".
        form: diffusion form, "paper", "plain" or "blob".
        integrator: time integration.
        dt: time step, None for the model's choice.
        tier: "compiled" or "agents".
        rng: seed.
    """

    until = 6.0
    box = (0.0, 1.0, 0.0, 1.0)

    def __init__(
        self,
        particles: int = 2000,
        diffusivity: float = 1e-3,
        behaviour: str = "bounce",
        contributions: str = "mirrored",
        form: str = "blob",
        integrator: str = "midpoint",
        dt: float | None = None,
        tier: str = "compiled",
        rng: int | None = None,
    ):
        positions, masses, spacing = sample(hump, particles, (0.25, 0.25), (0.75, 0.75))
        obstacles = Obstacles(
            [
                square(middle, side, behaviour=behaviour, name=f"square {number}")
                for number, (middle, side) in enumerate(SQUARES, 1)
            ],
            contributions=contributions,
        )
        super().__init__(
            Spreading,
            core_radius=1.4 * spacing * KERNELS["gaussian"].support,
            radius_rule=FollowDensity(),
            kernel="gaussian",
            domain=Bounded((0.0, 0.0), (1.0, 1.0)),
            laws=[Diffusion(diffusivity, form)],
            integrator=integrator,
            dt=dt,
            obstacles=obstacles,
            tier=tier,
            rng=rng,
        )
        free = ~obstacles.occupied(positions)
        Spreading.create_agents(self, int(free.sum()), position=positions[free], mass=masses[free])
