"""Tables and plot of the study of the quad-lattice."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from apmethod.bench.plots import groups, label, line, panels, save
from apmethod.bench.tables import Table, ms, times


def tables(results: dict[str, Any]) -> list[Table]:
    """Candidates, times of the algorithms, and Mesa beside them."""
    return [
        _candidates(results["rows"]),
        _levels(results["rows"]),
        *([_mesa(results["mesa"])] if "mesa" in results else []),
    ]


def _candidates(rows: list[dict[str, Any]]) -> Table:
    """Predicted and counted; both tiers look at the same ones."""
    head = ("agents", "algorithm", "Table 2", "counted", "counted / Table 2")
    cells = [
        (
            row["agents"],
            row["algorithm"],
            f"{row['predicted_candidates']:.0f}",
            f"{row['counted_candidates']:.0f}",
            f"{row['counted_candidates'] / row['predicted_candidates']:.3f}",
        )
        for row in rows
        if row["tier"] == rows[0]["tier"]
    ]
    return "candidates in a search for the neighbours of all agents", head, cells


def _levels(rows: list[dict[str, Any]]) -> Table:
    """One line for each number of agents and tier: times, and ratios beside those of candidates."""
    head = (
        "agents", "tier", "A1, ms", "A2, ms", "p=2, ms",
        "A1/A2", "candidates", "A2/p=2", "candidates",
    )  # fmt: skip
    cells = []
    for start in range(0, len(rows), 3):
        levels = rows[start : start + 3]
        medians = [ms(row["median_seconds"]) for row in levels]
        ratios = [
            times(row[name])
            for row in levels[1:]
            for name in ("gain_in_time", "gain_in_candidates")
        ]
        cells.append((levels[0]["agents"], levels[0]["tier"], *medians, *ratios))
    return "medians of times and of a step's ratios (the paper's: 1.251 and 1.23)", head, cells


def _mesa(found: list[dict[str, Any]]) -> Table:
    head = ("contender", "searching", "ms, all agents", "times counted", "times listed")
    rows = [
        (
            row["contender"],
            f"{row['searching']} of {row['agents']}",
            ms(row["median_seconds"]),
            times(row["against_counted"]),
            times(row["against_listed"]),
        )
        for row in found
    ]
    return "against Mesa's continuous spaces; a part of the agents is scaled to all", head, rows


def draw(results: dict[str, Any], path: Path) -> None:
    """The paper's Figure 3: time per step against the number of agents, for both tiers."""
    figure, axes = panels(2)
    for ax, tier in zip(axes, ("agents", "compiled"), strict=True):
        rows = [row for row in results["rows"] if row["tier"] == tier]
        for name, ours in groups(rows, "algorithm").items():
            line(ax, ours, "agents", "median_seconds", name, scale=1e3)
        label(ax, f"tier {tier!r}", "agents", "time per step, ms")
        ax.set_xlim(left=0)
        ax.set_ylim(bottom=0)
    save(figure, path)
