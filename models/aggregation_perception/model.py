"""Aggregation whose animals never perceive less than a floor (paper 3.2, Figure 10)."""

from apmethod import AnimalModel

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
        dt: float = 0.25,
        tier: str = "compiled",
        rng: int | None = None,
    ):
        super().__init__(
            particles=particles,
            diffusivity=diffusivity,
            sensitivity=sensitivity,
            side=SIDE,
            core_radius=core_radius,
            floor=floor * SIDE,
            sensing=sensing,
            dt=dt,
            tier=tier,
            rng=rng,
            agent_class=FarSightedAnimal,
        )
