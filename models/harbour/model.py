"""Oil spreads in a harbour: a real-life shape, read from a GeoJSON file (paper 2.5)."""

from pathlib import Path

import numpy as np

from apmethod import (
    KERNELS,
    Bounded,
    Diffusion,
    Flow,
    FollowDensity,
    Obstacles,
    ParticleModel,
    from_geojson,
)

from .agents import Oil

MAP = Path(__file__).parent / "harbour.geojson"
SPILL = (650.0, 270.0)


def ebb(x, y, t):
    """The tide goes out, to the west, faster towards the entrance: metres a second."""
    return -0.1 - 0.2 * np.exp(-(((x - 300.0) / 200.0) ** 2)), 0.0002 * (365.0 - y)


class Harbour(ParticleModel):
    """A spill of 30 m spreads for half an hour; a boom takes oil out, a ferry goes through it.

    The map tells what the boom does, and how the ferry moves: see ``harbour.geojson``.

    Args:
        particles: number of agents.
        diffusivity: D, m^2/s.
        behaviour: what oil does at the coast: "repulse", "bounce", "slide", "stick" or
            "absorb".
        dt: time step, None for the model's choice.
        tier: "compiled" or "agents".
        rng: seed.
    """

    until = 1800.0
    box = (0.0, 1000.0, 0.0, 700.0)

    def __init__(
        self,
        particles: int = 1500,
        diffusivity: float = 2.0,
        behaviour: str = "slide",
        dt: float | None = None,
        tier: str = "compiled",
        rng: int | None = None,
    ):
        obstacles = Obstacles(from_geojson(MAP, behaviour=behaviour), squeezed="remove")
        spread = 30.0
        spacing = spread * np.sqrt(4.0 * np.pi / particles)  # on average, by mass
        super().__init__(
            Oil,
            core_radius=2.2 * spacing * KERNELS["gaussian"].support,
            radius_rule=FollowDensity(),
            kernel="gaussian",
            domain=Bounded((0.0, 0.0), (1000.0, 700.0)),
            laws=[Diffusion(diffusivity, "blob"), Flow(ebb, "ebb")],
            integrator="midpoint",
            dt=dt,
            obstacles=obstacles,
            tier=tier,
            rng=rng,
        )
        draw = np.random.default_rng(rng)
        positions = SPILL + spread * draw.normal(size=(4 * particles, 2)).clip(-2.5, 2.5)
        positions = positions[~obstacles.occupied(positions)][:particles]
        Oil.create_agents(self, len(positions), position=positions, mass=1.0 / particles)
