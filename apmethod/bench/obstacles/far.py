"""What obstacles cost that are far from all agents: a step with them, and one without."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from apmethod import DiffusingParticle, Diffusion, Obstacles, ParticleModel, Polygon, disc
from apmethod.bench.cloud import Cloud, core_radius_for
from apmethod.bench.results import Disagreement
from apmethod.bench.timing import alternate, stopwatch

#: How many obstacles there are, and how many of them move where some do.
FAR, MOVERS = 1000, 10
#: Share of the largest stable step: agents shall stay where they are, more or less.
_SHARE = 0.05


def far(agents: int, rounds: int, seed: int) -> list[dict[str, Any]]:
    """Steps of diffusion, Euler and the cubic kernel: the cheapest that move every agent.

    Args:
        agents: all over the unit square.
        rounds: of a step of each.
        seed: of places.

    Raises:
        Disagreement: if far obstacles have changed where any agent is.
    """
    scenes = {"none": [], "far": _ring(seed, 0), "some moving": _ring(seed, MOVERS)}
    models = {name: _model(agents, obstacles, seed) for name, obstacles in scenes.items()}
    steps = {name: partial(stopwatch, model.step) for name, model in models.items()}
    alternate(steps, 3)  # compiles
    times = alternate(steps, rounds, warm=1)
    places = models["none"].particles.position
    rows = []
    for name in ("far", "some moving"):
        if (models[name].particles.position != places).any():
            raise Disagreement(f"{agents} agents: far obstacles ({name}) have changed a place")
        rows.append(
            {
                "agents": agents,
                "obstacles": len(models[name].obstacles),
                "moving": MOVERS if name == "some moving" else 0,
                "step_median_seconds": times["none"].median,
                "with_median_seconds": times[name].median,
                "ratio_of_medians": times[name].median / times["none"].median,
                "ratio_of_minima": times[name].minimum / times["none"].minimum,
            }
        )
    return rows


def _model(agents: int, obstacles: list[Polygon], seed: int) -> ParticleModel:
    diffusion = Diffusion(1e-3, form="paper")
    core_radius = core_radius_for(agents)
    model = ParticleModel(
        DiffusingParticle, core_radius=core_radius, laws=[diffusion], integrator="euler",
        obstacles=Obstacles(obstacles) if obstacles else None, rng=0,
    )  # fmt: skip
    model.dt = _SHARE * model.largest_dt()
    places = Cloud(agents, 0.0, periodic=True, seed=seed).positions
    DiffusingParticle.create_agents(model, agents, position=places, mass=1.0 / agents)
    return model


def _ring(seed: int, moving: int) -> list[Polygon]:
    """Octagons on all sides, 3 to 12 from the middle, of which some move round about."""
    draw = np.random.default_rng(seed)
    angles, reach = draw.uniform(0.0, 2.0 * np.pi, FAR), draw.uniform(3.0, 12.0, FAR)
    places = reach[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    return [
        disc(place, 0.1, corners=8, velocity=(0.0, 0.01) if number < moving else (0.0, 0.0))
        for number, place in enumerate(places)
    ]
