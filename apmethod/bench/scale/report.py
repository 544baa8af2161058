"""Tables and plot of the cost of an agent."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from apmethod.bench.plots import label, line, panels, save
from apmethod.bench.tables import Table


def tables(results: dict[str, Any]) -> list[Table]:
    """Time by phase and memory per agent, and the first steps."""
    rows = results["rows"]
    phases = [name for name in rows[0] if name.startswith("nanoseconds_")]
    memory = [name for name in rows[0] if name.startswith("bytes_")]
    growth = results["cost_of_an_agent"]["largest_over_smallest"]
    return [
        (
            f"a step of the rotating hill, ns an agent (largest / smallest: {growth:.2f})",
            ("agents", *(name.removeprefix("nanoseconds_") for name in phases)),
            [(row["agents"], *(f"{row[name]:.1f}" for name in phases)) for row in rows],
        ),
        (
            "memory in bytes an agent, and building",
            (
                "agents", *(name.removeprefix("bytes_").replace("_", " ") for name in memory),
                "build, s", "bare Mesa, s", "ratio",
            ),
            [
                (
                    row["agents"], *(f"{row[name]:.0f}" for name in memory),
                    f"{row['build_seconds']:.3g}", f"{row['mesa_build_seconds']:.3g}",
                    f"{row['build_over_mesa']:.2f}",
                )
                for row in rows
            ],
        ),
        (
            "seconds from a process's start to its second step",
            tuple(results["first_steps"][0]),
            [tuple(row.values()) for row in results["first_steps"]],
        ),
    ]  # fmt: skip


def draw(results: dict[str, Any], path: Path) -> None:
    """Cost of a step by phase and memory, per agent, against the number of agents."""
    figure, axes = panels(2)
    rows = results["rows"]
    for column in [name for name in rows[0] if name.startswith("nanoseconds_")]:
        line(axes[0], rows, "agents", column, column.removeprefix("nanoseconds_"))
    label(axes[0], "a step of the rotating hill", "agents", "time per agent, ns", log=True)
    for column in [name for name in rows[0] if name.startswith("bytes_")]:
        line(axes[1], rows, "agents", column, column.removeprefix("bytes_").replace("_", " "))
    label(axes[1], "resident memory", "agents", "bytes per agent")
    axes[1].set_xscale("log")
    axes[1].set_ylim(bottom=0)
    save(figure, path)
