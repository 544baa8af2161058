"""Tables and plot of sums against peers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from apmethod.bench.plots import groups, label, line, panels, save
from apmethod.bench.tables import Table, ms, times


def tables(results: dict[str, Any]) -> list[Table]:
    """Times of all contenders, and what this processor could do."""
    head = ("agents", "contender", "ms", "least", "times ours", "10^6 pairs/s", "difference")
    rows = [
        (
            row["agents"],
            row["contender"],
            ms(row["median_seconds"]),
            ms(row["minimum_seconds"]),
            times(row["times_ours"]),
            f"{row['pairs_per_second'] / 1e6:.1f}",
            "-" if row["relative_difference"] is None else f"{row['relative_difference']:.0e}",
        )
        for row in results["rows"]
    ]
    work = {
        row["contender"]: (row["contender"], row["threads"], row["work"]) for row in results["rows"]
    }
    return [
        ("one search and sum of all agents, medians", head, rows),
        ("what each does, at the largest size", ("contender", "threads", "work"), [*work.values()]),
        _roofline(results),
        _radii(results["radii"]),
        _skins(results["skins"]),
    ]


def _roofline(results: dict[str, Any]) -> Table:
    ceilings = results["roofline"]
    arithmetic = ceilings["arithmetic_candidates_per_second"] / 1e6
    peak = ceilings["peak_candidates_per_second"] / 1e6
    head = (
        "agents", "candidates/s, 10^6", f"arithmetic allows {arithmetic:.0f}", f"peak {peak:.0f}",
    )  # fmt: skip
    rows = [
        (
            row["agents"],
            f"{row['candidates_per_second'] / 1e6:.0f}",
            f"{times(row['factor_to_arithmetic'])} more",
            f"{times(row['factor_to_peak'])} more",
        )
        for row in results["rows"]
        if row["candidates_per_second"] is not None
    ]
    return f"what this processor could do ({ceilings['how']})", head, rows


def _radii(rows: list[dict[str, Any]]) -> Table:
    first = rows[0]["nanoseconds_a_neighbour"]
    cells = [
        (
            row["scene"],
            f"{row['neighbours']:.1f}",
            f"{row['candidates']:.0f}",
            ms(row["median_seconds"]),
            f"{row['nanoseconds_a_neighbour']:.2f}",
            times(row["nanoseconds_a_neighbour"] / first),
        )
        for row in rows
    ]
    head = ("scene", "neighbours", "candidates, both ends", "ms", "ns a neighbour", "times first")
    return f"core radii of agents' own, {rows[0]['agents']} agents", head, cells


def _skins(rows: list[dict[str, Any]]) -> Table:
    cells = [
        (row["evaluation"], row["skin"], ms(row["median_seconds"]), times(row["times_default"]))
        for row in rows
    ]
    head = ("evaluation", "skin", "ms", "times the default")
    return "a search kept for all steps, agents at rest: the most that a skin can gain", head, cells


def draw(results: dict[str, Any], path: Path) -> None:
    """Time per agent, and times as long as ours, against the number of agents."""
    figure, axes = panels(2)
    rows = [
        row | {"nanoseconds": 1e9 * row["median_seconds"] / row["agents"]}
        for row in results["rows"]
    ]
    for name, ours in groups(rows, "contender").items():
        line(axes[0], ours, "agents", "nanoseconds", name)
        line(axes[1], ours, "agents", "times_ours", name)
    label(axes[0], "search and sums, or search only", "agents", "time per agent, ns", log=True)
    label(axes[1], "times as long as apmethod", "agents", "ratio of medians", log=True)
    axes[1].get_legend().remove()  # it is the left one's
    save(figure, path)
