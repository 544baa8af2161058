"""All neighbours of all agents, by the quad-lattice and by Mesa's continuous spaces."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from apmethod.bench.cloud import Cloud, core_radius_for
from apmethod.bench.mesa_spaces import SPACES, WHOLE
from apmethod.bench.neighbours.study import DOMAIN, near
from apmethod.bench.population import exchange, pairs, population
from apmethod.bench.results import Disagreement
from apmethod.bench.timing import alternate, stopwatch


def against_mesa(
    agents: int, rounds: int = 3, sample: int | None = None, seed: int = 0
) -> list[dict[str, Any]]:
    """Time the searches of one cloud in turn.

    Args:
        agents: how many.
        rounds: searches of each contender.
        sample: let only so many agents of Mesa search, and scale their time to all;
            None for all up to 20000 agents, and 1000 beyond, which would take minutes.
        seed: of the places.

    Returns:
        One row for each contender: its median and minimum, how many agents searched, and
        how many times as long it took as each of the two compiled searches.

    Raises:
        Disagreement: if a space finds other numbers of neighbours than the lattice.
    """
    core_radius = core_radius_for(agents)
    positions = Cloud(agents, core_radius, periodic=True, seed=seed).positions
    model = population(positions, core_radius, [near], domain=DOMAIN)
    searching = min(agents, sample or (agents if agents <= WHOLE else 1000))
    searches = {
        name: space(positions, core_radius, torus=True, sample=searching)
        for name, space in SPACES.items()
    }
    _check(searches, np.bincount(pairs(model).ravel(), minlength=agents)[:searching].sum())
    ours = {"counted": partial(exchange, model), "listed": partial(_list_pairs, model)}
    contenders = {name: partial(stopwatch, run) for name, run in (ours | searches).items()}
    times = alternate(contenders, rounds)
    scale = {name: agents / searching if name in searches else 1.0 for name in times}
    return [
        {
            "contender": f"apmethod, {name}" if name in ours else name,
            "agents": agents,
            "searching": agents if name in ours else searching,
            "median_seconds": scale[name] * found.median,
            "minimum_seconds": scale[name] * found.minimum,
            "against_counted": scale[name] * found.median / times["counted"].median,
            "against_listed": scale[name] * found.median / times["listed"].median,
        }
        for name, found in times.items()
    ]


def _list_pairs(model) -> None:
    """Sort and write down every pair."""
    model.space.take_down()
    model.space.pairs()


def _check(searches: dict, expected: int) -> None:
    for name, search in searches.items():
        found = search()
        if found != expected:
            raise Disagreement(f"{name} finds {found} neighbours; the lattice finds {expected}")
