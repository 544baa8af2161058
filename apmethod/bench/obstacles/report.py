"""Tables and plot of first walls against peers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from apmethod.bench.plots import groups, label, line, panels, save
from apmethod.bench.tables import Table, digits, ms

_PEERS = ("shapely_minimum_seconds", "embree_minimum_seconds")

_HITS = (
    "ms: least and median of all runs.  10^3/s: thousand rays a second, and x: how much faster "
    "ours by surface area is, both from the least.  no test: rays that tried no wall."
)
_MOVING = (
    "follow: planes go along with walls, least and mean of all steps.  anew: a new tree, as "
    "peers must.  share: of the means.  broken: steps in which a domain disappeared."
)
_FAR = (
    "diffusion, Euler, 28 neighbours, steps in turn: medians without and with obstacles on all "
    "sides that nobody is near, and the ratios of the medians and of the least."
)


def tables(results: dict[str, Any]) -> list[Table]:
    """First walls on short and on long rays, obstacles that move, and far ones."""
    rows = results["rows"]
    return [
        _hits("short rays, as long as an agent's step", groups(rows, "rays")["short"]),
        _hits("long rays, from anywhere to anywhere", groups(rows, "rays")["long"]),
        _moving(results["moving"]),
        _far(results["far"]),
    ]


def _hits(title: str, rows: list[dict[str, Any]]) -> Table:
    head = ("walls", "contender", "rays", "ms", "median", "10^3/s", "x", "no test")
    cells = [
        (
            row["walls"],
            row["contender"],
            row["given"],
            ms(row["minimum_seconds"]),
            ms(row["median_seconds"]),
            digits(1e-3 * row["rays_per_second"]),
            digits(row["times_ours"]),
            "-" if row["skipped"] is None else f"{row['skipped']:.1%}",
        )
        for row in rows
    ]
    return f"first walls on {title}\n{_HITS}", head, cells


def _moving(rows: list[dict[str, Any]]) -> Table:
    head = ("walls", "moving", "follow", "mean", "anew", "share", "broken", "shapely", "Embree")
    cells = [
        (
            row["walls"],
            row["moving"],
            ms(row["follow_minimum_seconds"]),
            ms(row["follow_mean_seconds"]),
            ms(row["build_minimum_seconds"]),
            f"{row['follow_over_build']:.3f}",
            f"{row['rebuilds']}/{row['steps']}",
            *(ms(row[key]) if key in row else "-" for key in _PEERS),
        )
        for row in rows
    ]
    return f"index work of a step in which octagons move, ms\n{_MOVING}", head, cells


def _far(rows: list[dict[str, Any]]) -> Table:
    head = ("agents", "obstacles", "moving", "without", "with", "ratio", "of least")
    cells = [
        (
            row["agents"],
            row["obstacles"],
            row["moving"],
            ms(row["step_median_seconds"]),
            ms(row["with_median_seconds"]),
            f"{row['ratio_of_medians']:.3f}",
            f"{row['ratio_of_minima']:.3f}",
        )
        for row in rows
    ]
    return f"a step with obstacles far from all agents, ms\n{_FAR}", head, cells


def draw(results: dict[str, Any], path: Path) -> None:
    """Rays a second against the number of walls, for short and for long rays."""
    figure, axes = panels(2)
    for ax, length in zip(axes, ("short", "long"), strict=True):
        rows = [row for row in results["rows"] if row["rays"] == length]
        for name, ours in groups(rows, "contender").items():
            line(ax, ours, "walls", "rays_per_second", name)
        label(ax, f"{length} rays", "walls", "rays a second", log=True)
    save(figure, path)
