"""A paddle goes to and fro and turns, through matter that diffuses (paper 2.5.3)."""

import numpy as np

from apmethod import (
    KERNELS,
    Bounded,
    Diffusion,
    Obstacles,
    ParticleModel,
    Polygon,
    Polyline,
    disc,
)

from .agents import Stirred


class MovingObstacle(ParticleModel):
    """A paddle, a turning blade and two pillars in a basin of evenly spread matter.

    Args:
        particles: number of agents.
        diffusivity: D.
        speed: angular frequency of the paddle's way, which is 0.25 to each side.
        spin: of the blade, radians/time.
        behaviour: what an agent does at a wall: "repulse", "bounce", "slide", "stick" or
            "absorb".
        dt: time step, None for the model's choice.
        tier: "compiled" or "agents".
        rng: seed.
    """

    until = 12.0
    box = (0.0, 1.0, 0.0, 1.0)

    def __init__(
        self,
        particles: int = 2000,
        diffusivity: float = 2e-4,
        speed: float = 0.5,
        spin: float = 0.8,
        behaviour: str = "bounce",
        dt: float | None = 0.1,
        tier: str = "compiled",
        rng: int | None = None,
    ):
        def to_and_fro(t):
            return 0.25 * np.sin(speed * t), 0.0, 0.4 * np.sin(0.7 * speed * t)

        paddle = [(0.46, 0.12), (0.54, 0.12), (0.54, 0.42), (0.46, 0.42)]
        obstacles = Obstacles(
            [
                Polygon(paddle, name="paddle", behaviour=behaviour, path=to_and_fro),
                Polyline(
                    [(0.35, 0.72), (0.65, 0.72)], name="blade", behaviour=behaviour, spin=spin
                ),
                disc((0.12, 0.88), 0.05, name="west pillar", behaviour=behaviour),
                disc((0.88, 0.88), 0.05, name="east pillar", behaviour=behaviour),
            ],
            squeezed="remove",
        )
        spacing = particles**-0.5
        super().__init__(
            Stirred,
            core_radius=1.4 * spacing * KERNELS["gaussian"].support,
            kernel="gaussian",
            domain=Bounded((0.0, 0.0), (1.0, 1.0)),
            laws=[Diffusion(diffusivity, "blob")],
            integrator="midpoint",
            dt=dt,
            obstacles=obstacles,
            tier=tier,
            rng=rng,
        )
        positions = np.random.default_rng(rng).random((particles, 2))
        free = ~obstacles.occupied(positions)
        Stirred.create_agents(self, int(free.sum()), position=positions[free], mass=1.0 / particles)
