"""Animal aggregation with the paper's parameters (paper 3.2, Figure 9)."""

from apmethod import AnimalModel, Trajectories

from .agents import GregariousAnimal


class Aggregation(AnimalModel):
    """Animals diffuse, leave a signal on patches and follow it: groups emerge.

    Args:
        particles: number of animals.
        diffusivity: D of the animals.
        sensitivity: lambda.
        production: alpha.
        evaporation: beta.
        signal_diffusivity: Ds.
        core_radius: how far animals perceive each other and the signal at first, in patches.
        floor: below what it never falls as they crowd, in patches; one at least.
        sensing: "vicinity", "bilinear" or "nearest": how they sense the signal.
        gather_after: how long a group lives before it becomes one agent; None for ever.
        followed: how many animals' trajectories to record.
        dt: longest time step.
        tier: "compiled" or "agents".
        rng: seed.
    """

    until = 100.0

    def __init__(
        self,
        particles: int = 2500,
        diffusivity: float = 0.1,
        sensitivity: float = 0.1,
        production: float = 0.3,
        evaporation: float = 0.1,
        signal_diffusivity: float = 0.2,
        core_radius: float = 3.0,
        floor: float = 0.0,
        sensing: str = "vicinity",
        gather_after: float | None = None,
        followed: int = 0,
        dt: float = 0.25,
        tier: str = "compiled",
        rng: int | None = None,
    ):
        if not isinstance(followed, int) or followed < 0:
            raise ValueError(f"followed is {followed!r}; it must be a whole number, 0 or more")
        paths = Trajectories(every=4)
        super().__init__(
            particles=particles,
            diffusivity=diffusivity,
            sensitivity=sensitivity,
            production=production,
            evaporation=evaporation,
            signal_diffusivity=signal_diffusivity,
            core_radius=core_radius,
            floor=floor,
            sensing=sensing,
            gather=None if gather_after is None else lambda group: group.age >= gather_after,
            skills=[paths] if followed else [],
            dt=dt,
            tier=tier,
            rng=rng,
            agent_class=GregariousAnimal,
        )
        if followed:
            paths.follow(self.particles.agents[:followed])
