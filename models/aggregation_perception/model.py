"""Aggregation whose animals never perceive less than a floor (paper 3.2, Figure 10)."""

import numpy as np

from apmethod import AnimalModel, Life

from .agents import FarSightedAnimal

#: Side of the square, in patches.
SIDE = 50.0


class AggregationPerception(AnimalModel):
    """The core radius shrinks as animals crowd, but not below h_min.

    Args:
        particles: number of animals.
        floor: h_min, a share of the square's side as in the paper; 0 for none but the patch.
        diffusivity: D of the animals.
        sensitivity: lambda.
        core_radius: perception at first, in patches.
        sensing: "vicinity", "bilinear" or "nearest": how they sense the signal.
        view: angle in which they sense it, in degrees, half of it on either side of where
            they are heading; 360 is all round.  Less needs "vicinity".
        dt: longest time step.
        tier: "compiled" or "agents".
        rng: seed.
    """

    until = 300.0

    def __init__(
        self,
        particles: int = 2500,
        floor: float = 0.06,
        diffusivity: float = 0.1,
        sensitivity: float = 0.1,
        core_radius: float = 3.0,
        sensing: str = "vicinity",
        view: float = 360.0,
        dt: float = 0.25,
        tier: str = "compiled",
        rng: int | None = None,
    ):
        if not (isinstance(view, int | float) and 0.0 < view <= 360.0):
            raise ValueError(f"view is {view!r}; it must be above 0 and at most 360 degrees")
        ahead_only = view < 360.0
        super().__init__(
            particles=particles,
            diffusivity=diffusivity,
            sensitivity=sensitivity,
            side=SIDE,
            core_radius=core_radius,
            floor=floor * SIDE,
            sensing=sensing,
            view="view" if ahead_only else None,
            skills=[Life()] if ahead_only else [],
            dt=dt,
            tier=tier,
            rng=rng,
            agent_class=FarSightedAnimal,
        )
        self.particles.assign("view", np.cos(np.radians(0.5 * view)))
