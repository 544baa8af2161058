"""The stability study's picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Rows = list[dict[str, Any]]


def draw(results: dict[str, Any], path: Path) -> None:
    """Limits beside the theory, a map of growth for each scheme, mass ratios, and Peclet."""
    rows = {study: [] for study in ("limit", "map", "start", "peclet")}
    for row in results["rows"]:
        rows.setdefault(row["study"], []).append(row)
    maps: dict[tuple, Rows] = {}
    for row in rows["map"]:
        maps.setdefault((row["form"], row["kernel"], row["integrator"]), []).append(row)
    figure = Figure(figsize=(5.2 * (len(maps) + 3), 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, len(maps) + 3)
    _limits(axes[0], rows["limit"])
    for ax, (scheme, ours) in zip(axes[1:], maps.items(), strict=False):
        _map(figure, ax, ", ".join(scheme), ours)
    _masses(axes[-2], rows["start"], results["margin"]["chosen"])
    _peclet(axes[-1], rows["peclet"])
    figure.savefig(path, dpi=110)


def _limits(ax: Axes, rows: Rows) -> None:
    for form in dict.fromkeys(row["form"] for row in rows):
        ours = [row for row in rows if row["form"] == form]
        ax.plot([row["theory"] for row in ours], [row["measured"] for row in ours], "o", label=form)
    most = 1.1 * max(row["theory"] for row in rows)
    ends = np.array([0.0, most])
    ax.plot(ends, ends, color="grey", linewidth=1)
    ax.fill_between(ends, 0.8 * ends, 1.2 * ends, color="grey", alpha=0.2, label="within 20 %")
    _label(ax, "largest stable D dt/h^2", "theory", "measured")


def _map(figure: Figure, ax: Axes, name: str, rows: Rows) -> None:
    spacings = list(dict.fromkeys(row["spacings"] for row in rows))
    shares = list(dict.fromkeys(row["share_of_limit"] for row in rows))
    growth = np.array([row["growth"] for row in rows]).reshape(len(spacings), len(shares))
    image = ax.pcolormesh(
        shares, spacings, np.clip(growth, 0.5, 1.5), cmap="RdBu_r", vmin=0.5, vmax=1.5
    )
    figure.colorbar(image, ax=ax, label="growth of velocities in a step")
    ax.set_title(name)
    ax.set_xlabel("dt over the theory's limit")
    ax.set_ylabel("h over spacing")


def _masses(ax: Axes, rows: Rows, chosen: float) -> None:
    rows = [row for row in rows if row["start"] == "jittered"]
    for name in dict.fromkeys(row["accuracy"] for row in rows):
        ours = sorted(
            (row["mass_ratio"], row["share_of_limit"]) for row in rows if row["accuracy"] == name
        )
        ax.semilogx(*zip(*ours, strict=True), marker="o", label=name)
    ax.axhline(chosen, color="grey", linestyle="--", label="chosen steps")
    ax.set_ylim(bottom=0.0)
    _label(ax, "neighbours of uneven mass", "heaviest over lightest", "limit over theory")


def _peclet(ax: Axes, rows: Rows) -> None:
    for name in dict.fromkeys(row["accuracy"] for row in rows):
        ours = [row for row in rows if row["accuracy"] == name]
        ax.loglog([row["peclet"] for row in ours], [row["error"] for row in ours], marker="o",
                  label=name)  # fmt: skip
    _label(ax, "one turn of the hill", "Peclet number", "relative L2 error")


def _label(ax: Axes, title: str, x: str, y: str) -> None:
    ax.set_title(title)
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.legend(fontsize=8)
    ax.grid(alpha=0.3)
