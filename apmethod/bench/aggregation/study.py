"""Animal aggregation measured: linear stability, the paper's Figures 9 and 10, and costs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from apmethod.bench.aggregation import costs, dispersion, gatherings
from apmethod.bench.results import machine
from apmethod.bench.timing import Report

#: Animals, and leaders with a strategy in Python among them.
_LEADERS = 10_000, 50
#: Seeds from here on have had no part in choosing the scenes' parameters or what is compared.
_FIRST_SEED = 200
#: What is compared in each figure.
_STABLE = (
    "born", "unaltered_since", "settling_time", "last_event", "events", "groups",
    "share_in_groups",
)  # fmt: skip
_COMPARED = {
    "figure 9": ("groups", "share_in_groups"),
    "figure 10": _STABLE,
    "figure 10, low diffusivity": _STABLE,
}


def study(
    folder: Path, seeds: int = 20, size: int = 100_000, rounds: int = 7, *,
    until: float | None = None, report: Report | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Run it all, and draw the figures into a folder.

    Args:
        folder: for the figures' pictures.
        seeds: number of seeds of each setting of a figure.
        size: number of animals whose steps and groups are timed.
        rounds: timed rounds.
        until: end of the figures' runs where that is before their own.
        report: called with the share done and the runs made.

    Returns:
        A dictionary with ``rows``, one for each run of a figure.
    """
    folder.mkdir(parents=True, exist_ok=True)
    results: dict[str, Any] = {
        "benchmark": "aggregation",
        "machine": machine(),
        "settings": {"seeds": seeds, "size": size, "rounds": rounds, "until": until},
        "waves": dispersion.waves(dispersion.WAVES, dispersion.ALONG),
        "threshold": dispersion.threshold(along=dispersion.ALONG),
        "costs": {
            "a step": costs.steps(size, rounds),
            "leaders": costs.leaders(*_LEADERS, rounds),
            "groups": costs.groups(size, rounds),
        },
        "rows": [],
        "compared": [],
        "pictures": {},
    }
    for number, (figure, compared) in enumerate(_COMPARED.items()):
        share = _share(report, number / len(_COMPARED), 1.0 / len(_COMPARED))
        rows, models = gatherings.runs(
            figure, range(_FIRST_SEED, _FIRST_SEED + seeds), until, share
        )
        results["rows"] += rows
        results["compared"] += [gatherings.compared(rows, figure, what) for what in compared]
        path = folder / f"{figure.replace(',', '').replace(' ', '_')}.png"
        gatherings.draw(models, figure, path)
        results["pictures"][figure] = str(path)
    return results


def _share(report: Report | None, begin: float, part: float) -> Report | None:
    """The progress of a part of the whole."""
    return None if report is None else lambda done, made: report(begin + part * done, made)
