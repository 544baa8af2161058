"""Tables and plot of the stability study."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from apmethod.bench.plots import label, panels, save
from apmethod.bench.tables import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Rows = list[dict[str, Any]]


def tables(results: dict[str, Any]) -> list[Table]:
    """All tables, of what the study has rows for."""
    makers = {
        "limit": _limits, "start": _starts, "units": _units, "peclet": _peclet, "long": _long,
        "scene": _scenes,
    }  # fmt: skip
    found = []
    for study, make in makers.items():
        rows = [row for row in results["rows"] if row["study"] == study]
        if rows:
            found.append(make(rows))
    closest = [
        (name, f"{chosen:.2f}", f"{limit:.2f}", f"{chosen / limit:.2f}")
        for name, (chosen, limit) in results["margin"].items()
    ]
    head = ("agents", "chosen", "limit", "chosen / limit")
    return [*found, ("steps over the theory's limit, where the chosen one is closest to its limit",
                     head, closest)]  # fmt: skip


def _limits(rows: Rows) -> Table:
    head = ("form", "kernel", "integrator", "theory", "measured", "ratio", "pairing")
    cells = [
        (
            row["form"], row["kernel"], row["integrator"], f"{row['theory']:.3f}",
            f"{row['measured']:.3f}", f"{row['measured_over_theory']:.2f}",
            f"{row['pairing']:.3f}" if row["pairing"] else "-",
        )
        for row in rows
    ]  # fmt: skip
    return "largest stable D dt/h^2; pairing: rate, in D/h^2, at which agents pair", head, cells


def _starts(rows: Rows) -> Table:
    head = ("accuracy", "start", "mass ratio", "unevenness", "limit / theory", "chosen",
            "mass at limit", "momentum")  # fmt: skip
    cells = [
        (
            row["accuracy"], row["start"], f"{row['mass_ratio']:.0e}", f"{row['unevenness']:.1f}",
            f"{row['share_of_limit']:.2f}" if row["share_of_limit"] else "none",
            f"{row['chosen']:.2f}", f"{row['mass_at_limit']:.2%}", f"{row['momentum']:.0e}",
        )
        for row in rows
    ]  # fmt: skip
    return "disorder and uneven masses; momentum: sum m A over sum m |A|", head, cells


def _units(rows: Rows) -> Table:
    head = ("accuracy", "flow", "units", "error", "largest difference")
    groups: dict[tuple, Rows] = {}
    for row in rows:
        groups.setdefault((row["accuracy"], row["flow"]), []).append(row)
    cells = []
    for (accuracy, flow), ours in groups.items():
        decades = [row["decade"] for row in ours]
        off = max(row["off"] for row in ours)
        cells.append(
            (accuracy, flow, f"10^{min(decades)} to 10^{max(decades)} m",
             f"{ours[0]['error']:.2e}", f"{off:.0e}")
        )  # fmt: skip
    return "relative L2 error in other units, and its relative difference", head, cells


def _peclet(rows: Rows) -> Table:
    head = ("accuracy", "Peclet number", "steps", "error", "mass drift")
    cells = [
        (row["accuracy"], f"{row['peclet']:.0e}", row["steps"], f"{row['error']:.1e}",
         f"{row['mass_drift']:.0e}")
        for row in rows
    ]  # fmt: skip
    return "one turn of the hill, relative L2 error", head, cells


def _long(rows: Rows) -> Table:
    head = ("run", "steps", "mass drift", "momentum", "centroid, core radii", "order, first",
            "last")  # fmt: skip
    cells = [
        (row["run"], row["steps"], f"{row['mass_drift']:.0e}", f"{row['largest_momentum']:.0e}",
         f"{row['centroid_drift']:.0e}", f"{row['order_first']:.2f}", f"{row['order_last']:.2f}")
        for row in rows
    ]  # fmt: skip
    return "long runs; order: least over mean distance of nearest neighbours", head, cells


def _scenes(rows: Rows) -> Table:
    head = ("scene", "time", "steps", "agents", "mass gained or lost", "outside", "core radius",
            "warnings", "within bounds")  # fmt: skip
    cells = [
        (row["scene"], f"{row['time']:.4g}", row["steps"], row["agents"],
         f"{row['mass_drift']:.0e}", row["outside"], f"x {row['radius_growth']:.2f}",
         row["warnings"], "yes" if row["kept"] else "no")
        for row in rows
    ]  # fmt: skip
    return "the shipped scenes, ten times their default length", head, cells


def draw(results: dict[str, Any], path: Path) -> None:
    """Limits beside the theory, a map of growth for each scheme, mass ratios, and Peclet."""
    rows = {study: [] for study in ("limit", "map", "start", "peclet")}
    for row in results["rows"]:
        rows.setdefault(row["study"], []).append(row)
    maps: dict[tuple, Rows] = {}
    for row in rows["map"]:
        maps.setdefault((row["form"], row["kernel"], row["integrator"]), []).append(row)
    figure, axes = panels(len(maps) + 3)
    _draw_limits(axes[0], rows["limit"])
    for ax, (scheme, ours) in zip(axes[1:], maps.items(), strict=False):
        _draw_map(figure, ax, ", ".join(scheme), ours)
    _draw_masses(axes[-2], rows["start"])
    _draw_peclet(axes[-1], rows["peclet"])
    save(figure, path)


def _draw_limits(ax: Axes, rows: Rows) -> None:
    for form in dict.fromkeys(row["form"] for row in rows):
        ours = [row for row in rows if row["form"] == form]
        ax.plot([row["theory"] for row in ours], [row["measured"] for row in ours], "o", label=form)
    most = 1.1 * max(row["theory"] for row in rows)
    ends = np.array([0.0, most])
    ax.plot(ends, ends, color="grey", linewidth=1)
    ax.fill_between(ends, 0.8 * ends, 1.2 * ends, color="grey", alpha=0.2, label="within 20 %")
    label(ax, "largest stable D dt/h^2", "theory", "measured")


def _draw_map(figure: Figure, ax: Axes, name: str, rows: Rows) -> None:
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


def _draw_masses(ax: Axes, rows: Rows) -> None:
    rows = [row for row in rows if row["start"] == "jittered"]
    for name in dict.fromkeys(row["accuracy"] for row in rows):
        ours = sorted(
            (row["mass_ratio"], row["share_of_limit"], row["chosen"])
            for row in rows if row["accuracy"] == name
        )  # fmt: skip
        ratios, limits, chosen = zip(*ours, strict=True)
        (line,) = ax.semilogx(ratios, limits, marker="o", label=name)
        ax.semilogx(ratios, chosen, "--", color=line.get_color())
    ax.set_ylim(bottom=0.0)
    label(ax, "neighbours of uneven mass; dashed: chosen", "heaviest over lightest",
          "step over theory's limit")  # fmt: skip


def _draw_peclet(ax: Axes, rows: Rows) -> None:
    for name in dict.fromkeys(row["accuracy"] for row in rows):
        ours = [row for row in rows if row["accuracy"] == name]
        ax.loglog([row["peclet"] for row in ours], [row["error"] for row in ours], marker="o",
                  label=name)  # fmt: skip
    label(ax, "one turn of the hill", "Peclet number", "relative L2 error")
