"""Crowds, core radii of agents' own, and searches kept for several steps: what each costs."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from apmethod import AgentParticle, KeepNeighbours, ParticleModel
from apmethod.bench.cloud import core_radius_for
from apmethod.bench.population import candidates, exchange
from apmethod.bench.timing import AWAKE, Times, alternate, stopwatch
from apmethod.contribute.terms import density, density_gradient

#: Density of the crowds over that around them.
CONTRAST = 100.0
_CROWDS = 20
_SKINS = (0.0, 0.1, 0.2)


def crowded(agents: int, contrast: float, seed: int) -> np.ndarray:
    """Places in the unit square: half of the agents in discs ``contrast`` times as dense."""
    draw = np.random.default_rng(seed)
    positions = draw.random((agents, 2))
    inside = agents // 2 if contrast > 1.0 else 0
    radius = np.sqrt(1.0 / (1.0 + contrast) / _CROWDS / np.pi)
    centres = draw.uniform(0.1, 0.9, (_CROWDS, 2))
    angle, share = 2.0 * np.pi * draw.random(inside), np.sqrt(draw.random(inside))
    around = radius * share * np.array([np.cos(angle), np.sin(angle)])
    positions[:inside] = centres[draw.integers(_CROWDS, size=inside)] + around.T
    return positions


def radii(size: int, rounds: int, seed: int) -> list[dict[str, Any]]:
    """Uniform agents with one core radius and with their own, and crowds with their own."""
    scenes = {
        "uniform, one radius": (1.0, None),
        "uniform, radii of their own": (1.0, KeepNeighbours()),
        f"crowds of {CONTRAST:g} times the density, radii of their own": (
            CONTRAST, KeepNeighbours(),
        ),
    }  # fmt: skip
    models = {
        name: _model(crowded(size, contrast, seed), radius_rule=rule)
        for name, (contrast, rule) in scenes.items()
    }
    times = _timed(models, rounds)
    rows = []
    for name, model in models.items():
        neighbours = float(model.space.neighbour_counts().mean())
        seconds = times[name].median
        rows.append(
            {
                "agents": size,
                "scene": name,
                "neighbours": neighbours,
                "candidates": candidates(model) / size,
                "median_seconds": seconds,
                "nanoseconds_a_neighbour": 1e9 * seconds / (size * neighbours),
            }
        )
    return rows


def skins(size: int, rounds: int, seed: int) -> list[dict[str, Any]]:
    """Agents at rest, so that a skin spares every search but the first: the best case."""
    positions = crowded(size, 1.0, seed)
    settings = {
        (evaluation, skin): _model(positions, evaluation=evaluation, skin=skin)
        for evaluation in ("scattered", "gathered", "stored")
        for skin in _SKINS
    }
    times = _timed(settings, rounds)
    first = times["scattered", 0.0].median
    return [
        {
            "agents": size,
            "evaluation": evaluation,
            "skin": skin,
            "median_seconds": times[evaluation, skin].median,
            "times_default": times[evaluation, skin].median / first,
        }
        for evaluation, skin in settings
    ]


def _model(positions: np.ndarray, **options: Any) -> ParticleModel:
    count = len(positions)
    model = ParticleModel(
        AgentParticle, core_radius=core_radius_for(count), kernel="cubic", dt=1.0, rng=0,
        terms=[density, density_gradient], **options,
    )  # fmt: skip
    AgentParticle.create_agents(model, count, position=positions, mass=1.0 / count)
    if model.radius_rule is not None:
        model.radius_rule.adapt(model.space, model.particles)
    model.space.tidy()
    exchange(model)
    return model


def _timed(models: dict[Any, ParticleModel], rounds: int) -> dict[Any, Times]:
    """A search and a sum of each model, in turn."""

    def once(model: ParticleModel) -> None:
        model.space.forget()
        exchange(model)

    runs = {name: partial(stopwatch, partial(once, model)) for name, model in models.items()}
    return alternate(runs, rounds, warm=2, awake=AWAKE)
