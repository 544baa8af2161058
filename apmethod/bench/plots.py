"""Pictures of the benchmarks, drawn by matplotlib without a screen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Rows = Sequence[dict[str, Any]]


def panels(count: int) -> tuple[Figure, Sequence[Axes]]:
    """A figure with panels side by side."""
    figure = Figure(figsize=(5.2 * count, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(1, count)


def groups(rows: Rows, key: str) -> dict[str, list[dict[str, Any]]]:
    """Rows by what they have under ``key``, in the order they come."""
    found: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        found.setdefault(row[key], []).append(row)
    return found


def line(ax: Axes, rows: Rows, x: str, y: str, label: str, scale: float = 1.0) -> None:
    """One contender's line."""
    values = [scale * row[y] for row in rows]
    ax.plot([row[x] for row in rows], values, marker="o", markersize=4, label=label)


def label(ax: Axes, title: str, x: str, y: str, log: bool = False) -> None:
    """Title, axes and legend of a panel."""
    ax.set_title(title)
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    if log:
        ax.set_xscale("log")
        ax.set_yscale("log")
    # Below, where it hides no line.
    ax.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
    ax.grid(alpha=0.3)


def save(figure: Figure, path: Path) -> None:
    """Write the figure."""
    figure.savefig(path, dpi=110)
