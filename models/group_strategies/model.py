"""Animals that join the closest, farthest, oldest, youngest or largest group (paper 3.2)."""

import numpy as np

from apmethod import (
    AnimalModel,
    ClosestGroup,
    FarthestGroup,
    HighestGradient,
    Life,
    OldestGroup,
    YoungestGroup,
)

from .agents import LargestGroup, Leader, Wanderer

STRATEGIES = {
    "gradient": HighestGradient,
    "closest": ClosestGroup,
    "farthest": FarthestGroup,
    "oldest": OldestGroup,
    "youngest": YoungestGroup,
    "largest": LargestGroup,
}


class GroupStrategies(AnimalModel):
    """Each animal follows the signal, or joins the group that its strategy prefers.

    Args:
        particles: number of animals, without leaders.
        strategy: "gradient", "closest", "farthest", "oldest", "youngest", "largest", or
            "mixed", each for an equal share.
        leaders: animals with a way of their own, in Python.
        diffusivity: D of the animals.
        sensitivity: lambda.
        speed: of animals on the way to their group.
        dt: longest time step.
        tier: "compiled" or "agents".
        rng: seed.
    """

    until = 100.0

    def __init__(
        self,
        particles: int = 2500,
        strategy: str = "mixed",
        leaders: int = 0,
        diffusivity: float = 0.03,
        sensitivity: float = 0.1,
        speed: float = 0.3,
        dt: float = 0.25,
        tier: str = "compiled",
        rng: int | None = None,
    ):
        if strategy not in (*STRATEGIES, "mixed"):
            raise ValueError(
                f"strategy is {strategy!r}; it must be one of {', '.join(STRATEGIES)}, mixed"
            )
        if not isinstance(leaders, int) or leaders < 0:
            raise ValueError(f"leaders is {leaders!r}; it must be a whole number, 0 or more")
        super().__init__(
            particles=particles,
            diffusivity=diffusivity,
            sensitivity=sensitivity,
            strategies=list(STRATEGIES.values()),
            speed=speed,
            skills=[Life()],
            dt=dt,
            tier=tier,
            rng=rng,
            agent_class=Wanderer,
        )
        animals = self.particles.agents
        for number, choice in enumerate(STRATEGIES.values()):
            if strategy == "mixed":
                self.strategies.give(animals[number :: len(STRATEGIES)], choice)
            elif STRATEGIES[strategy] is choice:
                self.strategies.give(animals, choice)
        draw = np.random.default_rng(rng)
        x_min, x_max, y_min, y_max = self.space.bounds
        places = draw.uniform((x_min, y_min), (x_max, y_max), (leaders, 2))
        Leader.create_agents(self, leaders, position=places)
