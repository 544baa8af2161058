"""Tables and plot of the animals' study."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from apmethod.bench.plots import label, line, panels, save
from apmethod.bench.tables import Table, ms, times


def tables(results: dict[str, Any]) -> list[Table]:
    """Growth rates, the figures' differences over the seeds, and costs."""
    growth = [
        (
            f"{row['k']:.3f}", f"{row['expected']:.5f}", f"{row['measured']:.5f}",
            f"{row['off']:+.1%}",
        )
        for row in [*results["waves"], results["threshold"]]
    ]  # fmt: skip
    compared = [
        (
            f"{row['figure']}, {row['what'].replace('_', ' ')}",
            f"{row['first']}: {row['first_mean']:.4g}",
            f"{row['second']}: {row['second_mean']:.4g}",
            f"{row['difference']:+.4g} +- {row['half_width']:.3g}",
            "yes" if row["certain"] else "no",
        )
        for row in results["compared"]
    ]
    seeds = results["settings"]["seeds"]
    costs = [
        (title, row["contender"], row["agents"], ms(row["median_seconds"]), times(row["times"]))
        for title, rows in results["costs"].items()
        for row in rows
    ]
    agents = results["threshold"]["agents"]
    return [
        (
            f"growth rate of waves of {agents} agents; last, the sensitivity that keeps one",
            ("k", "dispersion relation", "measured", "off"),
            growth,
        ),
        (
            f"means over {seeds} seeds, and the difference's 95 % confidence interval",
            ("of", "first", "second", "difference", "not 0"),
            compared,
        ),
        (
            "costs, medians",
            ("of", "contender", "agents", "ms", "times the first"),
            costs,
        ),
    ]


def draw(results: dict[str, Any], path: Path) -> None:
    """Growth rates against the dispersion relation, and the seeds of Figures 9 and 10."""
    figure, axes = panels(3)
    rows = results["waves"]
    line(axes[0], rows, "k", "expected", "dispersion relation")
    line(axes[0], rows, "k", "measured", "measured")
    label(axes[0], "growth of small waves", "wave number k", "growth rate, 1/time")
    drawn = (("figure 9", "groups"), ("figure 10", "born"))
    for ax, (name, what) in zip(axes[1:], drawn, strict=True):
        ours = [row for row in results["rows"] if row["figure"] == name]
        compared = next(
            row for row in results["compared"] if (row["figure"], row["what"]) == (name, what)
        )
        for k, which in enumerate(("first", "second")):
            line(ax, ours[k::2], "seed", what, compared[which])
        label(ax, name, "seed", what.replace("_", " "))
        ax.set_ylim(bottom=0)
    save(figure, path)
