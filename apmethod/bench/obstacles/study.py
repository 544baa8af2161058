"""First walls on agents' displacements: kd-tree-domains against peers (paper 2.5).

Every contender is given coordinates and must tell the first wall on each ray.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from apmethod import Obstacles
from apmethod.bench.obstacles.far import far
from apmethod.bench.obstacles.finders import (
    Finder,
    Ours,
    embree_finder,
    shapely_finder,
    try_all,
)
from apmethod.bench.obstacles.moving import moving
from apmethod.bench.obstacles.octagons import octagons, rays
from apmethod.bench.results import Disagreement, machine
from apmethod.bench.timing import Progress, Report, alternate, stopwatch

#: Numbers of walls, eight to an octagon.
SIZES = (104, 1000, 8000, 100_000)
RAYS = 100_000
#: Numbers of agents far from obstacles, and rounds for each that is asked for.
FAR_AGENTS = (2000, 16_000)
_FAR_ROUNDS = 10
#: A contender that would take longer than so many seconds for all rays is given fewer.
_LONGEST = 0.5
_FEWEST = 300


def study(
    sizes: Sequence[int] = SIZES,
    rounds: int = 7,
    count: int = RAYS,
    seed: int = 0,
    report: Report | None = None,
    agents: Sequence[int] = FAR_AGENTS,
) -> dict[str, Any]:
    """Check and time all contenders that are installed.

    Args:
        sizes: numbers of walls.
        rounds: runs of each contender.
        count: rays a run.
        seed: of places.
        report: called with the share done and the rounds made.
        agents: numbers of agents whose steps are timed with obstacles far away.

    Raises:
        Disagreement: if ours finds another first wall than trying all of them on any ray that
            is tried so, or a peer does on more than one ray in a thousand (Embree rounds to
            single).
    """
    progress = Progress(report, [count for _ in sizes for _ in range(2 * rounds)])
    rows, movers = [], []
    for size in sizes:
        for length in ("short", "long"):
            rows += _at_size(size, length, rounds, count, seed, progress)
        one_and_a_hundredth = sorted({1, max(1, size // 800)})
        movers += [moving(size, number, rounds, seed) for number in one_and_a_hundredth]
    return {
        "benchmark": "obstacles",
        "machine": machine(),
        "settings": {
            "sizes": list(sizes),
            "rounds": rounds,
            "rays": count,
            "seed": seed,
            "agents": list(agents),
        },
        "checked": "each contender finds the same first walls on all rays that it is given",
        "rows": rows,
        "moving": movers,
        "far": [row for number in agents for row in far(number, _FAR_ROUNDS * rounds, seed)],
    }


def _at_size(
    size: int, length: str, rounds: int, count: int, seed: int, progress: Progress
) -> list[dict[str, Any]]:
    starts, ends = rays(size, count, length, seed)
    ours = {
        name: Ours(Obstacles(octagons(size, seed), rule=rule), count)
        for name, rule in (("surface area", "surface_area"), ("median split", "median"))
    }
    obstacles = ours["surface area"].obstacles
    walls = obstacles.walls.ends[0]
    finders: dict[str, Finder | None] = {
        **ours,
        "shapely STRtree": shapely_finder(walls),
        "Embree": embree_finder(walls),
        "no tree": partial(try_all, obstacles),
    }
    expected = ours["surface area"](starts, ends)
    contenders, given, other_hits = {}, {}, {}
    for name, finder in finders.items():
        if finder is None:
            continue
        given[name] = count if name in ours else _affordable(finder, starts, ends)
        part = slice(given[name])
        other_hits[name] = int((finder(starts[part], ends[part]) != expected[part]).sum())
        allowed = 1e-3 * given[name] if name in ("shapely STRtree", "Embree") else 0
        if other_hits[name] > allowed:
            found = f"{other_hits[name]} other first walls than ours"
            raise Disagreement(f"{size} walls, {length} rays, {name}: {found}")
        contenders[name] = partial(stopwatch, partial(finder, starts[part], ends[part]))
    times = alternate(contenders, rounds, after=lambda: progress.made(count))
    rates = {name: given[name] / found.minimum for name, found in times.items()}
    return [
        {
            "walls": size,
            "rays": length,
            "contender": name,
            "given": given[name],
            "median_seconds": found.median,
            "minimum_seconds": found.minimum,
            "rays_per_second": rates[name],
            "times_ours": rates["surface area"] / rates[name],
            "other_hits": other_hits[name],
            "skipped": float((ours[name].tried == 0).mean()) if name in ours else None,
            "walls_tried": float(ours[name].tried.mean()) if name in ours else None,
        }
        for name, found in times.items()
    ]


def _affordable(finder: Finder, starts: np.ndarray, ends: np.ndarray) -> int:
    """How many of the rays a contender is given, so that it does not take too long."""
    finder(starts[:1], ends[:1])  # some build at the first ray
    fewest = min(_FEWEST, len(starts))
    seconds = stopwatch(lambda: finder(starts[:fewest], ends[:fewest]))
    return int(np.clip(fewest * _LONGEST / seconds, fewest, len(starts)))
