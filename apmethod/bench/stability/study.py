"""The stability study: limits, maps, disorder, mass ratios, units, Peclet numbers, long runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from apmethod.bench.kept import Kept
from apmethod.bench.results import machine
from apmethod.bench.stability import limits, long_runs, scales, starts
from apmethod.bench.timing import Progress, Report
from apmethod.model import MARGIN
from apmethod.run.scenes import shipped_scenes

#: Smoothing lengths over spacing, and shares of the theory's limit, of the maps.
_SPACINGS = (0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.4)
_SHARES = (0.3, 0.5, 0.7, 0.8, 0.9, 1.0, 1.1, 1.3, 1.6, 2.0)

Row = dict[str, Any]


class Part(NamedTuple):
    """What makes a row of the study, or several, and its settings."""

    make: Callable[..., Row | list[Row]]
    settings: dict[str, Any]

    def rows(self, kept: Kept) -> list[Row]:
        """The rows, made if they are not kept."""
        key = {"part": self.make.__name__, **self.settings}
        rows = kept.or_made(key, lambda: self.make(**self.settings))
        return rows if isinstance(rows, list) else [rows]


def study(
    quick: bool = False, folder: Path | None = None, report: Report | None = None
) -> dict[str, Any]:
    """Make the whole study.

    Args:
        quick: fewer schemes, sizes and steps, and no scenes.
        folder: where finished parts are kept; None for nowhere.
        report: called with the share done and the parts made.

    Returns:
        A dictionary with ``rows``, each of which says its ``study``: limit, map, start,
        units, peclet, long or scene; and ``margin``.
    """
    parts = _quick() if quick else _full()
    progress = Progress(report, [1] * len(parts))
    kept = Kept(folder)
    rows: list[Row] = []
    for part in parts:
        rows += part.rows(kept)
        progress.made(1)
    return {
        "benchmark": "stability",
        "machine": machine(),
        "settings": {"quick": quick},
        "margin": margin(rows),
        "bounds": long_runs.BOUNDS,
        "rows": rows,
    }


def margin(rows: list[Row]) -> dict[str, tuple[float, float]]:
    """Chosen step and measured limit, over the theory's, where they are closest to each other.

    Of starts at which any step is stable; the model warns at the others.
    """
    stable = [row for row in rows if row["study"] == "start" and row["share_of_limit"] > 0.0]
    groups = {
        "on a lattice": [
            (MARGIN, r["measured_over_theory"]) for r in rows if r["study"] == "limit"
        ],
        "in disorder": [_steps(row) for row in stable if row["mass_ratio"] == 1.0],
        "with uneven masses": [_steps(row) for row in stable if row["mass_ratio"] > 1.0],
    }
    return {name: max(steps, key=lambda s: s[0] / s[1]) for name, steps in groups.items()}


def _steps(row: Row) -> tuple[float, float]:
    return row["chosen"], row["share_of_limit"]


def _full() -> list[Part]:
    schemes = starts.SCHEMES
    return [
        *(Part(limits.limit, {"scheme": each}) for each in limits.SCHEMES),
        *_maps(schemes, _SPACINGS, _SHARES),
        *(Part(starts.disorder, {"name": name, "halvings": 7}) for name in schemes),
        *(Part(starts.mass_ratios, {"name": name, "decades": [*range(1, 9)], "halvings": 7})
          for name in schemes),
        *_scales(schemes, [0, *range(-9, 0), *range(1, 4)], [10.0**-k for k in range(1, 11)], 1000),
        Part(long_runs.at_rest, {"steps": 100_000}),
        *(Part(long_runs.turning, {"accuracy": name, "steps": 100_000})
          for name in ("conservative", "accurate")),
        *(Part(long_runs.scene, {"name": name}) for name in shipped_scenes()),
    ]  # fmt: skip


def _quick() -> list[Part]:
    names = ("conservative", "accurate")
    return [
        *(Part(limits.limit, {"scheme": each}) for each in limits.QUICK),
        *_maps(names, _SPACINGS[1::2], _SHARES[::3]),
        Part(starts.disorder, {"name": "conservative", "halvings": 5}),
        *(Part(starts.mass_ratios, {"name": name, "decades": [8], "halvings": 5})
          for name in names),
        *_scales(names, [0, -9, -6, -3, 3], [1e-2, 1e-4, 1e-6, 1e-9], 500),
        Part(long_runs.at_rest, {"steps": 2000}),
        Part(long_runs.turning, {"accuracy": "conservative", "steps": 1000}),
    ]  # fmt: skip


def _maps(names: Iterable[str], spacings: Sequence[float], shares: Sequence[float]) -> list[Part]:
    return [
        Part(limits.growths, {"scheme": starts.SCHEMES[name][0], "spacings": [h], "shares": shares})
        for name in names
        for h in spacings
    ]


def _scales(
    names: Iterable[str], decades: Sequence[int], diffusivities: Sequence[float], particles: int
) -> list[Part]:
    return [
        Part(make, {"accuracy": name, **settings, "particles": particles})
        for make, settings in (
            (scales.units, {"decades": decades}),
            (scales.peclet, {"diffusivities": diffusivities}),
        )
        for name in names
    ]
