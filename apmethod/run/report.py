"""What a run leaves behind: a table, JSON, and files in open formats."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from apmethod.particles import Particles
from apmethod.run.runner import Run

_LABELS = {
    "ended": "ended",
    "agents": "agents",
    "steps": "steps",
    "time": "physical time",
    "seconds": "wall time of all steps, s",
    "seconds_perceive": "  perceive, s",
    "seconds_contribute": "  contribute, s",
    "seconds_message": "  message, s",
    "seconds_move": "  move, s",
    "seconds_skills": "  skills, s",
    "mass_drift": "mass drift, relative",
    "centroid_drift": "centroid drift, length",
    "l2_error": "L2 error, relative",
    "linf_error": "L-infinity error, relative",
    "failure": "failure",
}


def print_table(title: str, rows: Iterable[Sequence[Any]], head: Sequence[str] = ()) -> None:
    """Print rows under a title; with ``head``, under column names."""
    table = Table(title=title, title_justify="left", show_header=bool(head))
    for name in head or [""] * 2:
        table.add_column(name)
    for row in rows:
        table.add_row(*(_text(value) for value in row))
    Console().print(table)


def print_json(numbers: Any) -> None:
    """Print numbers as JSON and nothing else."""
    print(json.dumps(numbers, indent=2))


def summary_rows(summary: dict[str, Any]) -> list[tuple[str, Any]]:
    """A run's summary with labels for people."""
    return [(_LABELS.get(name, name), value) for name, value in summary.items()]


def write_run(run: Run, scene: str, folder: Path, summary: dict[str, Any]) -> dict[str, str]:
    """Write the summary, the series, the agents and the picture of a run.

    Returns:
        What was written: the kind of each file and its path.
    """
    from apmethod.view.picture import draw_run

    folder.mkdir(parents=True, exist_ok=True)
    files = {
        "picture": folder / "picture.png",
        "series": folder / "series.csv",
        "agents": folder / "agents.csv",
        "summary": folder / "summary.json",
    }
    with open(files["series"], "w", newline="") as file:
        writer = csv.DictWriter(file, run.series[0].keys())
        writer.writeheader()
        writer.writerows(run.series)
    with open(files["agents"], "w", newline="") as file:
        csv.writer(file).writerows(_agent_rows(run.model.particles))
    files["summary"].write_text(json.dumps({"scene": scene, **summary}, indent=2) + "\n")
    draw_run(run, scene, files["picture"])
    return {kind: str(path) for kind, path in files.items()}


def _agent_rows(particles: Particles) -> Iterable[Sequence[Any]]:
    """A head and one row an agent: its id and the columns that mean something to people."""
    head, columns = ["unique_id"], [[agent.unique_id for agent in particles.agents]]
    for name in particles.names:
        column = particles.columns[name]
        values = particles.array(name)
        if column.components is None:
            head.append(name)
            columns.append(values.tolist())
        else:
            suffixes = "xy" if column.components == 2 else range(column.components)
            head += [f"{name}_{suffix}" for suffix in suffixes]
            columns += [part.tolist() for part in values.T]
    yield head
    yield from zip(*columns, strict=True)


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
