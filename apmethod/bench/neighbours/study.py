"""The paper's study of its quad-lattice, repeated (paper 2.4.3, Tables 2 and Figure 3).

Uniform random agents in ]-1/2, 1/2[^2 make random moves, and in every step each agent
finds its neighbours by A1 (level p = 0), A2 (p = 1) and p = 2.  The square is periodic
here: every agent has all of its surrounding then, as Table 2 supposes, and the moves keep
the agents uniform.  The core radius holds 28 neighbours at every number of agents.

Two tiers are timed, each with the sorting: ``agents``, in which every agent asks the
lattice for its neighbours in plain Python, and ``compiled``, the message bus counting the
neighbours of all agents.  Each searches twice and the second time counts: as in a simulation,
where step follows step, it finds its data in the caches and its threads awake.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from apmethod import ParticleModel, Periodic, brute_force_pairs, term
from apmethod.bench.cloud import Cloud, core_radius_for
from apmethod.bench.population import candidates, exchange, pairs, population, put, take
from apmethod.bench.results import Disagreement, machine
from apmethod.bench.timing import Progress, Report, Times, alternate, stopwatch

LEVELS = {"A1": 0, "A2": 1, "p=2": 2}
TIERS = ("agents", "compiled")
#: The numbers of agents of the paper's Figure 3.
SIZES = (1000, 2000, 8000, 16000)
#: All pairs are tried up to this many agents, to check the lattice.
_TRIED = 2000

DOMAIN = Periodic((-0.5, -0.5), (0.5, 0.5))


@term("even")
def near(pair, i, j):
    """How many agents are within the core radius."""
    return 1.0


def predicted_candidates(agents: int, core_radius: float, level: int) -> float:
    """Table 2: (2*2^p + 1)^2 (anpc / 4^p) N, anpc the agents per cell of the unit square."""
    agents_per_cell = agents * core_radius**2
    return (2 * 2**level + 1) ** 2 * agents_per_cell / 4**level * agents


def study(
    sizes: Sequence[int] = SIZES, steps: int = 20, seed: int = 0, report: Report | None = None
) -> dict[str, Any]:
    """Check, count and time the three levels in both tiers.

    Args:
        sizes: numbers of agents.
        steps: random moves, with a search by every level and tier after each.
        seed: of places and moves.
        report: called with the share done and the steps made.

    Returns:
        A dictionary with ``rows``, one for each size, tier and level.

    Raises:
        Disagreement: if two levels, two tiers or brute force find different neighbours.
    """
    progress = Progress(report, [size for size in sizes for _ in range(steps)])
    rows = []
    for size in sizes:
        rows += _at_size(size, steps, seed, progress)
    return {
        "benchmark": "neighbours",
        "machine": machine(),
        "settings": {"sizes": list(sizes), "steps": steps, "seed": seed, "domain": repr(DOMAIN)},
        "checked": "all levels and tiers found the same neighbours; those of up to "
        f"{_TRIED} agents are those found by trying all pairs",
        "rows": rows,
    }


def build_levels(positions: np.ndarray, core_radius: float) -> dict[str, ParticleModel]:
    """One model of the same agents for each algorithm."""
    return {
        name: population(positions, core_radius, [near], domain=DOMAIN, level=level)
        for name, level in LEVELS.items()
    }


def search_by_agents(model: ParticleModel) -> list[list]:
    """Every agent's neighbours, each agent asking in plain Python."""
    space = model.space
    space.take_down()
    return [space.neighbours_of(agent) for agent in model.particles.agents]


def check_same_neighbours(models: dict[str, ParticleModel], positions: np.ndarray) -> int:
    """Hold levels, tiers and brute force against each other.

    Returns:
        The number of pairs.

    Raises:
        Disagreement: naming the one that found other neighbours.
    """
    expected = pairs(models["A1"])
    if len(positions) <= _TRIED:
        core_radius = models["A1"].space.core_radius
        expected = brute_force_pairs(positions, core_radius, DOMAIN)
    for name, model in models.items():
        exchange(model)
        found = {
            f"{name}, pairs": pairs(model),
            f"{name}, agent by agent": _pairs_of_agents(model),
        }
        for who, got in found.items():
            if not np.array_equal(got, expected):
                raise Disagreement(f"{who}: {len(got)} pairs, not the expected {len(expected)}")
        counts = np.bincount(expected.ravel(), minlength=len(positions))
        if not np.array_equal(take(model, "near"), counts):
            raise Disagreement(f"{name}: the bus counted other neighbours than the pairs")
    return len(expected)


def _pairs_of_agents(model: ParticleModel) -> np.ndarray:
    """The pairs that agents find by themselves, those seen from one end only included."""
    agents, found = model.particles.agents, search_by_agents(model)
    seen = [
        (agent.unique_id - 1, other.unique_id - 1)
        for agent, others in zip(agents, found, strict=True)
        for other in others
    ]
    both = np.sort(np.array(seen, int).reshape(-1, 2), axis=1)
    rows, ends = np.unique(both, axis=0, return_counts=True)
    if (ends != 2).any():
        raise Disagreement(f"only one end of pair {rows[ends != 2][0].tolist()} sees the other")
    return rows


def _at_size(size: int, steps: int, seed: int, progress: Progress) -> list[dict[str, Any]]:
    core_radius = core_radius_for(size)
    cloud = Cloud(size, core_radius, periodic=True, seed=seed)
    # A model for each tier: what one leaves behind must not be cleared away at the other's cost.
    models = {tier: build_levels(cloud.positions, core_radius) for tier in TIERS}
    pair_count = check_same_neighbours(models["agents"], cloud.positions)
    counted: dict[str, list[int]] = {name: [] for name in LEVELS}

    def move() -> None:
        cloud.move()
        for name, model in models["agents"].items():
            put(model, cloud.positions)
            put(models["compiled"][name], cloud.positions)
            counted[name].append(candidates(model))

    search = {"agents": search_by_agents, "compiled": exchange}
    contenders = {
        f"{tier} {name}": partial(stopwatch, partial(search[tier], models[tier][name]))
        for tier in TIERS
        for name in LEVELS
    }
    times = alternate(contenders, steps, warm=1, before=move, after=lambda: progress.made(size))
    return [
        {
            "agents": size,
            "tier": tier,
            "algorithm": name,
            "level": level,
            "neighbours": 2.0 * pair_count / size,
            "predicted_candidates": predicted_candidates(size, core_radius, level),
            "counted_candidates": float(np.mean(counted[name])),
            "median_seconds": times[f"{tier} {name}"].median,
            "minimum_seconds": times[f"{tier} {name}"].minimum,
            **_gain(tier, name, times, counted),
        }
        for tier in TIERS
        for name, level in LEVELS.items()
    ]


def _gain(
    tier: str, name: str, times: dict[str, Times], counted: dict[str, list[int]]
) -> dict[str, float | None]:
    """How many times faster than the level before, and how many times fewer candidates."""
    names = list(LEVELS)
    if name == names[0]:
        return {"gain_in_time": None, "gain_in_candidates": None}
    before = names[names.index(name) - 1]
    return {
        "gain_in_time": times[f"{tier} {before}"].over(times[f"{tier} {name}"]),
        "gain_in_candidates": sum(counted[before]) / sum(counted[name]),
    }
