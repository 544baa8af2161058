"""Tables and plot of error against run time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from apmethod.bench.error.compare import front
from apmethod.bench.plots import groups, label, line, panels, save
from apmethod.bench.tables import Table, times


def tables(results: dict[str, Any]) -> list[Table]:
    """All runs with their orders, and the times at equal error."""
    orders = {
        (found["problem"], found["contender"]): f"{found['order']:.2f}"
        for found in results["orders"]
    }
    runs = [
        (
            row["problem"],
            row["contender"],
            row["size"],
            row["steps"],
            f"{row['error']:.2e}",
            f"{row['seconds']:.3g}",
            f"{row['build_seconds']:.2g}" if "build_seconds" in row else "-",
            orders.get((row["problem"], row["contender"]), "-"),
        )
        for row in results["rows"]
    ]
    compared = [
        (
            row["problem"],
            f"{row['error']:.1e}",
            *("not reached" if row[name] is None else f"{row[name]:.3g}"
              for name in ("agents_seconds", "elements_seconds")),
            times(row["times_less"]),
        )
        for row in results["comparisons"]
    ]  # fmt: skip
    return [
        (
            "error and run time; order in the agents' spacing, fitted to all sizes",
            ("problem", "contender", "agents or unknowns", "steps", "error", "seconds",
             "building, s", "order"),
            runs,
        ),
        (
            "seconds at equal error, the best of each kind",
            ("problem", "error", "agents", "finite elements", "ratio"),
            compared,
        ),
    ]  # fmt: skip


def draw(results: dict[str, Any], path: Path) -> None:
    """Error against run time, one panel a problem; finite elements dashed, by mesh and step."""
    problems = groups(results["rows"], "problem")
    figure, axes = panels(len(problems))
    for ax, (name, rows) in zip(np.atleast_1d(axes), problems.items(), strict=True):
        for contender, ours in groups(rows, "contender").items():
            if ours[0]["kind"] == "agents":
                line(ax, ours, "seconds", "error", contender)
            else:
                ours = front(ours)
                ax.plot(
                    [row["seconds"] for row in ours], [row["error"] for row in ours],
                    linestyle="--", marker="s", markersize=4, label=contender,
                )  # fmt: skip
        label(ax, name, "run time, s", "relative L2 error", log=True)
    save(figure, path)
