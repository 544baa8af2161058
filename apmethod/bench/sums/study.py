"""One perceive, contribute and message against the peers that are installed.

Density and its gradient by the cubic B-spline in double precision, over uniform random
agents in an open square, 28 neighbours each away from the sides.  Every round all agents
move at random, by up to a quarter of the core radius along each axis, and then each
contender in turn searches and sums (or only searches, if that is all it does) three times.
The third time counts: as in a simulation, where step follows step, it finds its data in the
caches and its threads awake.
Before that, all sums and all numbers of pairs must agree.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np

from apmethod import KERNELS, brute_force_pairs
from apmethod.bench.cloud import Cloud, core_radius_for
from apmethod.bench.population import candidates, population
from apmethod.bench.results import Disagreement, machine
from apmethod.bench.sums import variants
from apmethod.bench.sums.peers import Ours, installed_searches
from apmethod.bench.sums.pysph_peer import PySPH
from apmethod.bench.sums.roofline import roofline
from apmethod.bench.timing import AWAKE, Progress, Report, Times, alternate
from apmethod.compile import set_threads, threads
from apmethod.contribute.terms import density, density_gradient

SIZES = (1000, 16_000, 64_000, 256_000, 1_000_000)
#: Largest relative difference of two contenders' sums.
TOLERANCE = 1e-10
#: All pairs are tried up to this many agents, to check the sums.
_TRIED = 2000
#: Crowds, radii and skins are tried with this many agents at the most.
_VARIED = 64_000


def study(
    sizes: Sequence[int] = SIZES,
    rounds: int = 7,
    pysph: str | None = None,
    seed: int = 0,
    report: Report | None = None,
) -> dict[str, Any]:
    """Check and time all contenders at each size.

    Args:
        sizes: numbers of agents.
        rounds: runs of each contender at each size.
        pysph: path of a Python interpreter that has PySPH; ``apmethod bench sums --help``
            says how to set one up.
        seed: of places and moves.
        report: called with the share done and the rounds made.

    Returns:
        A dictionary with ``rows``, one for each size and contender, ``roofline``, and the
        costs of ``radii`` and ``skins``.

    Raises:
        Disagreement: if a contender's sums or number of pairs differ.
        ValueError: if ``pysph`` cannot be run.
    """
    most = threads()
    progress = Progress(report, [size for size in sizes for _ in range(rounds)])
    ceilings = roofline(most)
    rows = []
    try:
        for size in sizes:
            rows += _at_size(size, rounds, pysph, seed, most, progress, ceilings)
    finally:
        set_threads(most)
    size = min(sizes[-1], _VARIED)
    return {
        "benchmark": "sums",
        "machine": machine(),
        "settings": {"sizes": list(sizes), "rounds": rounds, "pysph": pysph, "seed": seed},
        "checked": f"sums agree to {TOLERANCE:g} relative, numbers of pairs exactly (in single "
        f"precision to 1e-5); those of up to {_TRIED} agents with trying all pairs",
        "roofline": ceilings,
        "radii": variants.radii(size, rounds, seed),
        "skins": variants.skins(size, rounds, seed),
        "rows": rows,
    }


def brute_force_sums(positions: np.ndarray, core_radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Density and gradient of agents of equal mass, together 1, from all pairs tried."""
    kernel, h = KERNELS["cubic"], 0.5 * core_radius
    i, j = brute_force_pairs(positions, core_radius).T
    apart = positions[i] - positions[j]
    distance = np.hypot(*apart.T)
    w = kernel.w(distance, h)
    grad = (kernel.dw(distance, h) / distance)[:, None] * apart
    total = np.full(len(positions), float(kernel.w(0.0, h)))
    gradient = np.zeros_like(positions)
    for here, sign in ((i, 1.0), (j, -1.0)):
        np.add.at(total, here, w)
        np.add.at(gradient, here, sign * grad)
    return total / len(positions), gradient / len(positions)


def difference(sums: tuple, expected: tuple) -> float:
    """Largest difference of any sum, relative to the largest sum of its kind."""
    return max(
        float(np.abs(got - wanted).max() / np.abs(wanted).max())
        for got, wanted in zip(sums, expected, strict=True)
    )


def check_same_sums(
    contenders: Mapping[str, Any], expected: tuple, pairs: int
) -> dict[str, float | None]:
    """Hold what contenders have found in a run against what is expected.

    Args:
        contenders: by name.
        expected: density and gradient.
        pairs: number of pairs.

    Returns:
        The relative difference of each one's sums, None for those that have none.

    Raises:
        Disagreement: naming the contender.
    """
    differences = {}
    for name, contender in contenders.items():
        sums, found = contender.sums(), contender.pairs()
        differences[name] = None if sums is None else difference(sums, expected)
        if sums is not None and not differences[name] <= TOLERANCE:
            raise Disagreement(
                f"sums of {name} differ by {differences[name]:.3g} relative; "
                f"at most {TOLERANCE:g} is rounding"
            )
        tolerance = getattr(contender, "tolerance", 0.0)
        if found is not None and abs(found - pairs) > tolerance * pairs:
            raise Disagreement(f"{name} finds {found} pairs, and not {pairs}")
    return differences


def _contenders(
    cloud: Cloud, core_radius: float, most: int, pysph: str | None, stack: ExitStack
) -> dict[str, Any]:
    """All contenders for a cloud, ours first, the others within their limits."""
    model = population(cloud.positions, core_radius, [density, density_gradient])
    found: dict[str, Any] = {
        f"apmethod, {count} thread{'s' * (count > 1)}": Ours(model, count)
        for count in sorted({1, most}, reverse=True)
    }
    if pysph is not None:
        for name, ordered in (("PySPH", False), ("PySPH, put in order before", True)):
            found[name] = PySPH(pysph, cloud.positions, core_radius, most, ordered)
    found |= installed_searches(core_radius, most)
    for contender in found.values():
        stack.callback(contender.close)
    size = len(cloud.positions)
    return {name: peer for name, peer in found.items() if peer.limit is None or size <= peer.limit}


def _at_size(
    size: int,
    rounds: int,
    pysph: str | None,
    seed: int,
    most: int,
    progress: Progress,
    ceilings: dict[str, Any],
) -> list[dict[str, Any]]:
    core_radius = core_radius_for(size)
    cloud = Cloud(size, 0.25 * core_radius, periodic=False, seed=seed)
    with ExitStack() as stack:
        contenders = _contenders(cloud, core_radius, most, pysph, stack)

        def prepare() -> None:
            for contender in contenders.values():
                contender.prepare(cloud.positions)

        def move() -> None:
            cloud.move()
            prepare()

        prepare()
        for contender in contenders.values():
            contender.seconds()
        ours = next(iter(contenders.values()))
        tried = size <= _TRIED
        expected = brute_force_sums(cloud.positions, core_radius) if tried else ours.sums()
        # A message serves both ends, so that a candidate is tried from one of them only.
        tested = candidates(ours.model) // 2
        work = {"pairs": len(ours.model.space.pairs()), "candidates": tested}
        differences = check_same_sums(contenders, expected, work["pairs"])
        runs = {name: contender.seconds for name, contender in contenders.items()}
        times = alternate(
            runs, rounds, warm=2, awake=AWAKE, before=move, after=lambda: progress.made(size)
        )
        return [
            {
                "agents": size,
                "contender": name,
                "threads": contender.threads,
                "median_seconds": times[name].median,
                "minimum_seconds": times[name].minimum,
                **_ratios(name, contender, times, work, ceilings),
                "relative_difference": differences[name],
                "work": contender.note,
            }
            for name, contender in contenders.items()
        ]


def _ratios(
    name: str, contender: Any, times: dict[str, Times], work: dict[str, int], ceilings: dict
) -> dict[str, float | None]:
    """Against our time on all threads; and, for ours, what is left to the ceilings."""
    seconds, first = times[name].median, next(iter(times.values())).median
    numbers: dict[str, float | None] = {
        "times_ours": seconds / first,
        "pairs_per_second": work["pairs"] / seconds,
        "candidates_per_second": None,
        "factor_to_arithmetic": None,
        "factor_to_peak": None,
    }
    if isinstance(contender, Ours) and contender.threads == ceilings["threads"]:
        rate = work["candidates"] / seconds
        numbers["candidates_per_second"] = rate
        numbers["factor_to_arithmetic"] = ceilings["arithmetic_candidates_per_second"] / rate
        numbers["factor_to_peak"] = ceilings["peak_candidates_per_second"] / rate
    return numbers
