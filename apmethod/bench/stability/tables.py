"""The stability study's tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Table = tuple[str, Sequence[str], list[tuple]]
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
    margin = [(name, f"{share:.2f}") for name, share in results["margin"].items()]
    head = ("step, or the least limit measured", "share of the theory's limit")
    return [*found, ("what steps that the model chooses keep away from", head, margin)]


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
    head = ("accuracy", "start", "mass ratio", "limit / theory", "mass at limit", "momentum")
    cells = [
        (
            row["accuracy"], row["start"], f"{row['mass_ratio']:.0e}",
            f"{row['share_of_limit']:.2f}", f"{row['mass_at_limit']:.2%}",
            f"{row['momentum']:.0e}",
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
