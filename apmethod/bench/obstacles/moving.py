"""The index of obstacles of which some move: planes that follow them, or all built anew."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from statistics import fmean
from typing import Any

import numpy as np

from apmethod import AgentParticle, Obstacles, ParticleModel
from apmethod.bench.obstacles.finders import Finder, embree_finder, shapely_finder
from apmethod.bench.obstacles.octagons import octagons, rays
from apmethod.bench.timing import stopwatch

#: Steps for each round of building all anew; an octagon moves a tenth of its radius a step.
_STEPS = 10


def moving(size: int, movers: int, rounds: int, seed: int) -> dict[str, Any]:
    """What a step's index work costs, beside building it anew, by ours and by the peers.

    Args:
        size: number of walls.
        movers: how many of the octagons move.
        rounds: of building; there are ten steps in each.
        seed: of places.
    """
    obstacles = Obstacles(octagons(size, seed, movers))
    ParticleModel(AgentParticle, core_radius=0.1, dt=1.0, obstacles=obstacles)
    starts, ends = rays(size, 1, "short", seed)
    peers = {"shapely": shapely_finder, "embree": embree_finder}
    installed = {name: f for name, f in peers.items() if f(obstacles.walls.ends[0]) is not None}
    seconds: dict[str, list[float]] = {name: [] for name in ("follow", "build", *installed)}
    for step in range(_STEPS * rounds):
        seconds["follow"].append(stopwatch(partial(_follow, obstacles, float(step))))
        obstacles.end(step + 1.0)
        if step % _STEPS == 0:
            seconds["build"].append(stopwatch(obstacles.new_tree))
            for name, finder in installed.items():
                build = partial(_build_and_ask, finder, obstacles.walls.ends[0], starts, ends)
                seconds[name].append(stopwatch(build))
    seconds["follow"].pop(0)  # the first step has had passes compiled
    return {
        "walls": size,
        "moving": movers,
        "follow_mean_seconds": fmean(seconds["follow"]),
        "follow_over_build": fmean(seconds["follow"]) / fmean(seconds["build"]),
        "steps": _STEPS * rounds,
        "rebuilds": obstacles.rebuilds,
    } | {f"{name}_minimum_seconds": min(values) for name, values in seconds.items()}


def _follow(obstacles: Obstacles, time: float) -> None:
    """Begin a step; planes follow when they are asked for."""
    obstacles.begin(time, 1.0)
    _ = obstacles.tree


def _build_and_ask(
    finder: Callable[[np.ndarray], Finder | None],
    walls: np.ndarray,
    starts: np.ndarray,
    ends: np.ndarray,
) -> None:
    """Build a peer's index; some do at the first ray only."""
    finder(walls)(starts, ends)
