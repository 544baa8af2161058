"""What the runs of the study say: fitted orders, and times at equal error."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

Run = dict[str, Any]
#: Errors at which times are compared, besides the smallest that finite elements reach in
#: `_LONGEST` seconds.
LEVELS = (1e-3, 2e-4)
_LONGEST = 10.0


def orders(rows: Sequence[Run]) -> list[dict[str, Any]]:
    """Order in the agents' spacing, N^(-1/2), fitted to each scheme's errors."""
    found = []
    for problem, contender in dict.fromkeys((row["problem"], row["contender"]) for row in rows):
        runs = [row for row in _of(rows, problem) if row["contender"] == contender]
        if runs[0]["kind"] == "agents" and len(runs) > 1:
            spacing = -0.5 * np.log([row["size"] for row in runs])
            fitted = np.polyfit(spacing, np.log([row["error"] for row in runs]), 1)[0]
            found.append({"problem": problem, "contender": contender, "order": float(fitted)})
    return found


def comparisons(rows: Sequence[Run], problems: Sequence[str]) -> list[dict[str, Any]]:
    """Times at equal error: the best agents against the best finite elements."""
    found = []
    for problem in problems:
        runs = _of(rows, problem)
        agents = front([row for row in runs if row["kind"] == "agents"])
        elements = front([row for row in runs if row["kind"] == "elements"])
        if not agents or not elements:
            continue
        soon = [row for row in elements if row["seconds"] <= _LONGEST]
        smallest = [min(row["error"] for row in soon)] if soon else []
        for level in [*LEVELS, *smallest]:
            ours, theirs = seconds_at(agents, level), seconds_at(elements, level)
            found.append({
                "problem": problem, "error": level, "agents_seconds": ours,
                "elements_seconds": theirs,
                "times_less": theirs / ours if ours and theirs else None,
            })  # fmt: skip
    return found


def front(rows: Sequence[Run]) -> list[Run]:
    """The runs that no other one beats in both time and error, quickest first."""
    best: list[Run] = []
    for row in sorted(rows, key=lambda row: (row["seconds"], row["error"])):
        if not best or row["error"] < best[-1]["error"]:
            best.append(row)
    return best


def seconds_at(runs: Sequence[Run], error: float) -> float | None:
    """Time that a front takes for an error, between its runs by a power law.

    An error larger than that of its quickest run takes as long as that run; one that the
    front does not reach takes None.
    """
    if error >= runs[0]["error"]:
        return runs[0]["seconds"]
    for worse, better in pairwise(runs):
        if better["error"] <= error:
            share = np.log(worse["error"] / error) / np.log(worse["error"] / better["error"])
            return float(worse["seconds"] * (better["seconds"] / worse["seconds"]) ** share)
    return None


def _of(rows: Sequence[Run], problem: str) -> list[Run]:
    return [row for row in rows if row["problem"] == problem]
