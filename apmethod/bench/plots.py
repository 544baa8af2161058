"""Pictures of the benchmarks, drawn by matplotlib without a screen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from apmethod.bench.error.compare import front
from apmethod.bench.stability.plot import draw as draw_stability  # noqa: F401

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Rows = Sequence[dict[str, Any]]


def draw_neighbours(results: dict[str, Any], path: Path) -> None:
    """The paper's Figure 3: time per step against the number of agents, for both tiers."""
    figure, axes = _panels(2)
    for ax, tier in zip(axes, ("agents", "compiled"), strict=True):
        rows = [row for row in results["rows"] if row["tier"] == tier]
        for name, ours in _groups(rows, "algorithm").items():
            _line(ax, ours, "agents", "median_seconds", name, scale=1e3)
        _label(ax, f"tier {tier!r}", "agents", "time per step, ms")
        ax.set_xlim(left=0)
        ax.set_ylim(bottom=0)
    _save(figure, path)


def draw_sums(results: dict[str, Any], path: Path) -> None:
    """Time per agent, and times as long as ours, against the number of agents."""
    figure, axes = _panels(2)
    rows = [
        row | {"nanoseconds": 1e9 * row["median_seconds"] / row["agents"]}
        for row in results["rows"]
    ]
    for name, ours in _groups(rows, "contender").items():
        _line(axes[0], ours, "agents", "nanoseconds", name)
        _line(axes[1], ours, "agents", "times_ours", name)
    _label(axes[0], "search and sums, or search only", "agents", "time per agent, ns", log=True)
    _label(axes[1], "times as long as apmethod", "agents", "ratio of medians", log=True)
    axes[1].get_legend().remove()  # it is the left one's
    _save(figure, path)


def draw_scale(results: dict[str, Any], path: Path) -> None:
    """Cost of a step by phase and memory, per agent, against the number of agents."""
    figure, axes = _panels(2)
    rows = results["rows"]
    for column in [name for name in rows[0] if name.startswith("nanoseconds_")]:
        _line(axes[0], rows, "agents", column, column.removeprefix("nanoseconds_"))
    _label(axes[0], "a step of the rotating hill", "agents", "time per agent, ns", log=True)
    for column in [name for name in rows[0] if name.startswith("bytes_")]:
        _line(axes[1], rows, "agents", column, column.removeprefix("bytes_").replace("_", " "))
    _label(axes[1], "resident memory", "agents", "bytes per agent")
    axes[1].set_xscale("log")
    axes[1].set_ylim(bottom=0)
    _save(figure, path)


def draw_error(results: dict[str, Any], path: Path) -> None:
    """Error against run time, one panel a problem; finite elements dashed, by mesh and step."""
    problems = _groups(results["rows"], "problem")
    figure, axes = _panels(len(problems))
    for ax, (name, rows) in zip(np.atleast_1d(axes), problems.items(), strict=True):
        for contender, ours in _groups(rows, "contender").items():
            if ours[0]["kind"] == "agents":
                _line(ax, ours, "seconds", "error", contender)
            else:
                ours = front(ours)
                ax.plot(
                    [row["seconds"] for row in ours], [row["error"] for row in ours],
                    linestyle="--", marker="s", markersize=4, label=contender,
                )  # fmt: skip
        _label(ax, name, "run time, s", "relative L2 error", log=True)
    _save(figure, path)


def draw_aggregation(results: dict[str, Any], path: Path) -> None:
    """Growth rates against the dispersion relation, and the seeds of Figures 9 and 10."""
    figure, axes = _panels(3)
    rows = results["waves"]
    _line(axes[0], rows, "k", "expected", "dispersion relation")
    _line(axes[0], rows, "k", "measured", "measured")
    _label(axes[0], "growth of small waves", "wave number k", "growth rate, 1/time")
    drawn = (("figure 9", "groups"), ("figure 10", "stable_since"))
    for ax, (name, what) in zip(axes[1:], drawn, strict=True):
        ours = [row for row in results["rows"] if row["figure"] == name]
        compared = next(
            row for row in results["compared"] if (row["figure"], row["what"]) == (name, what)
        )
        for k, label in enumerate(("first", "second")):
            _line(ax, ours[k::2], "seed", what, compared[label])
        _label(ax, name, "seed", what.replace("_", " "))
        ax.set_ylim(bottom=0)
    _save(figure, path)


def draw_obstacles(results: dict[str, Any], path: Path) -> None:
    """Rays a second against the number of walls, for short and for long rays."""
    figure, axes = _panels(2)
    for ax, length in zip(axes, ("short", "long"), strict=True):
        rows = [row for row in results["rows"] if row["rays"] == length]
        for name, ours in _groups(rows, "contender").items():
            _line(ax, ours, "walls", "rays_per_second", name)
        _label(ax, f"{length} rays", "walls", "rays a second", log=True)
    _save(figure, path)


def _panels(count: int) -> tuple[Figure, Sequence[Axes]]:
    figure = Figure(figsize=(5.2 * count, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(1, count)


def _groups(rows: Rows, key: str) -> dict[str, list[dict[str, Any]]]:
    """Rows by what they have under ``key``, in the order they come."""
    found: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        found.setdefault(row[key], []).append(row)
    return found


def _line(ax: Axes, rows: Rows, x: str, y: str, label: str, scale: float = 1.0) -> None:
    values = [scale * row[y] for row in rows]
    ax.plot([row[x] for row in rows], values, marker="o", markersize=4, label=label)


def _label(ax: Axes, title: str, x: str, y: str, log: bool = False) -> None:
    ax.set_title(title)
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    if log:
        ax.set_xscale("log")
        ax.set_yscale("log")
    # Below, where it hides no line.
    ax.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
    ax.grid(alpha=0.3)


def _save(figure: Figure, path: Path) -> None:
    figure.savefig(path, dpi=110)
