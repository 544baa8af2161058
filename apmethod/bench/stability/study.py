"""The stability study: limits, maps, disorder, mass ratios, units, Peclet numbers, long runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from apmethod.bench.results import machine
from apmethod.bench.stability import limits, long_runs, scales, starts
from apmethod.bench.timing import Progress, Report
from apmethod.model import MARGIN
from apmethod.run.scenes import shipped_scenes

#: Smoothing lengths over spacing, and shares of the theory's limit, of the maps.
_SPACINGS = (0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.4)
_SHARES = (0.3, 0.5, 0.7, 0.8, 0.9, 1.0, 1.1, 1.3, 1.6, 2.0)

Part = Callable[[], list[dict[str, Any]]]


def study(quick: bool = False, report: Report | None = None) -> dict[str, Any]:
    """Make the whole study.

    Args:
        quick: fewer schemes, sizes and steps, and no scenes.
        report: called with the share done and the parts made.

    Returns:
        A dictionary with ``rows``, each of which says its ``study``: limit, map, start,
        units, peclet, long or scene; and ``margin``.
    """
    parts = _quick() if quick else _full()
    progress = Progress(report, [1] * len(parts))
    rows: list[dict[str, Any]] = []
    for part in parts:
        rows += part()
        progress.made(1)
    return {
        "benchmark": "stability",
        "machine": machine(),
        "settings": {"quick": quick},
        "margin": margin(rows),
        "bounds": long_runs.BOUNDS,
        "rows": rows,
    }


def margin(rows: list[dict[str, Any]]) -> dict[str, float]:
    """Share of its limit that a chosen step takes, and the least limit measured over theory."""
    off_lattice = [row for row in rows if row["study"] == "start"]

    def least(uneven: bool) -> float:
        return min(r["share_of_limit"] for r in off_lattice if (r["mass_ratio"] > 1.0) == uneven)

    return {
        "chosen": MARGIN,
        "on a lattice": min(r["measured_over_theory"] for r in rows if r["study"] == "limit"),
        "in disorder": least(uneven=False),
        "with uneven masses": least(uneven=True),
    }


def _full() -> list[Part]:
    schemes = starts.SCHEMES
    return [
        *((lambda each=each: [limits.limit(each)]) for each in limits.SCHEMES),
        *(
            (lambda each=each, h=h: limits.growths(each, [h], _SHARES))
            for each, _ in schemes.values()
            for h in _SPACINGS
        ),
        *((lambda name=name: starts.disorder(name, 7)) for name in schemes),
        *((lambda name=name: starts.mass_ratios(name, range(1, 9), 7)) for name in schemes),
        *((lambda name=name: scales.units(name, (0, *range(-9, 0), *range(1, 4)), 1000))
          for name in schemes),
        *((lambda name=name: scales.peclet(name, [10.0**-k for k in range(1, 11)], 1000))
          for name in schemes),
        lambda: [long_runs.at_rest(100_000)],
        *((lambda name=name: [long_runs.turning(name, 100_000)])
          for name in ("conservative", "accurate")),
        *((lambda name=name: [long_runs.scene(name)]) for name in shipped_scenes()),
    ]  # fmt: skip


def _quick() -> list[Part]:
    names = ("conservative", "accurate")
    return [
        *((lambda each=each: [limits.limit(each)]) for each in limits.QUICK),
        *(
            (lambda name=name, h=h: limits.growths(starts.SCHEMES[name][0], [h], _SHARES[::3]))
            for name in names
            for h in _SPACINGS[1::2]
        ),
        lambda: starts.disorder("conservative", 5),
        *((lambda name=name: starts.mass_ratios(name, (8,), 5)) for name in names),
        *((lambda name=name: scales.units(name, (0, -9, -6, -3, 3), 500)) for name in names),
        *((lambda name=name: scales.peclet(name, (1e-2, 1e-4, 1e-6, 1e-9), 500))
          for name in names),
        lambda: [long_runs.at_rest(2000)],
        lambda: [long_runs.turning("conservative", 1000)],
    ]  # fmt: skip
