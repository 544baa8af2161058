"""Tables and plot of first walls against peers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from apmethod.bench.plots import groups, label, line, panels, save
from apmethod.bench.tables import Table, ms, times


def tables(results: dict[str, Any]) -> list[Table]:
    """First walls by contender, and one obstacle that moves."""
    head = ("walls", "rays", "contender", "ms", "least", "times ours", "skipped", "other hits")
    rows = [
        (
            row["walls"],
            row["rays"],
            row["contender"],
            ms(row["median_seconds"]),
            ms(row["minimum_seconds"]),
            times(row["times_ours"]),
            "-" if row["skipped"] is None else f"{row['skipped']:.1%}",
            row["other_hits"],
        )
        for row in results["rows"]
    ]
    moving_head = ("walls", "follow, ms", "build, ms", "follow / build", "steps", "rebuilds")
    moving = [
        (
            row["walls"],
            ms(row["follow_seconds"]),
            ms(row["build_seconds"]),
            f"{row['follow_over_build']:.3f}",
            row["steps"],
            row["rebuilds"],
        )
        for row in results["moving"]
    ]
    count = results["settings"]["rays"]
    return [
        (f"first walls on {count} rays, medians; skipped: tried no wall", head, rows),
        ("one moving octagon: planes that follow, or a new tree", moving_head, moving),
    ]


def draw(results: dict[str, Any], path: Path) -> None:
    """Rays a second against the number of walls, for short and for long rays."""
    figure, axes = panels(2)
    for ax, length in zip(axes, ("short", "long"), strict=True):
        rows = [row for row in results["rows"] if row["rays"] == length]
        for name, ours in groups(rows, "contender").items():
            line(ax, ours, "walls", "rays_per_second", name)
        label(ax, f"{length} rays", "walls", "rays a second", log=True)
    save(figure, path)
