"""The benchmarks' results as tables for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from apmethod.bench.results import machine_line
from apmethod.bench.stability.tables import tables as stability
from apmethod.run.report import print_table

#: A table: its title, its columns' names, and its rows.
Table = tuple[str, Sequence[str], list[tuple]]


def show(results: dict[str, Any], files: dict[str, str]) -> None:
    """Print a benchmark's tables, what was checked, where it ran, and its files."""
    makers = {
        "neighbours": _neighbours, "sums": _sums, "scale": _scale, "error": _error,
        "aggregation": _aggregation, "obstacles": _obstacles, "stability": stability,
    }  # fmt: skip
    for title, head, rows in makers[results["benchmark"]](results):
        print_table(title, rows, head)
    if "checked" in results:
        print(f"checked before timing: {results['checked']}")
    print(machine_line(results["machine"]))
    for kind, path in files.items():
        print(f"{kind:8} {path}")


def _neighbours(results: dict[str, Any]) -> list[Table]:
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
        times = [_ms(row["median_seconds"]) for row in levels]
        ratios = [
            _times(row[name])
            for row in levels[1:]
            for name in ("gain_in_time", "gain_in_candidates")
        ]
        cells.append((levels[0]["agents"], levels[0]["tier"], *times, *ratios))
    return "time per step, medians (the paper's ratios: 1.251 and 1.23)", head, cells


def _mesa(found: list[dict[str, Any]]) -> Table:
    head = ("contender", "searching", "ms, all agents", "times counted", "times listed")
    rows = [
        (
            row["contender"],
            f"{row['searching']} of {row['agents']}",
            _ms(row["median_seconds"]),
            _times(row["against_counted"]),
            _times(row["against_listed"]),
        )
        for row in found
    ]
    return "against Mesa's continuous spaces; a part of the agents is scaled to all", head, rows


def _sums(results: dict[str, Any]) -> list[Table]:
    head = ("agents", "contender", "ms", "least", "times ours", "10^6 pairs/s", "difference")
    rows = [
        (
            row["agents"],
            row["contender"],
            _ms(row["median_seconds"]),
            _ms(row["minimum_seconds"]),
            _times(row["times_ours"]),
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
            f"{_times(row['factor_to_arithmetic'])} more",
            f"{_times(row['factor_to_peak'])} more",
        )
        for row in results["rows"]
        if row["candidates_per_second"] is not None
    ]
    return f"what this processor could do ({ceilings['how']})", head, rows


def _scale(results: dict[str, Any]) -> list[Table]:
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


def _error(results: dict[str, Any]) -> list[Table]:
    orders = {
        (found["problem"], found["contender"]): f"{found['order']:.2f}"
        for found in results["orders"]
    }
    runs = [
        (
            row["problem"],
            row["contender"],
            row["size"],
            row["steps"],
            f"{row['error']:.2e}",
            f"{row['seconds']:.3g}",
            f"{row['build_seconds']:.2g}" if "build_seconds" in row else "-",
            orders.get((row["problem"], row["contender"]), "-"),
        )
        for row in results["rows"]
    ]
    compared = [
        (
            row["problem"],
            f"{row['error']:.1e}",
            *("not reached" if row[name] is None else f"{row[name]:.3g}"
              for name in ("agents_seconds", "elements_seconds")),
            _times(row["times_less"]),
        )
        for row in results["comparisons"]
    ]  # fmt: skip
    return [
        (
            "error and run time; order in the agents' spacing, fitted to all sizes",
            ("problem", "contender", "agents or unknowns", "steps", "error", "seconds",
             "building, s", "order"),
            runs,
        ),
        (
            "seconds at equal error, the best of each kind",
            ("problem", "error", "agents", "finite elements", "ratio"),
            compared,
        ),
    ]  # fmt: skip


def _aggregation(results: dict[str, Any]) -> list[Table]:
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
        (title, row["contender"], row["agents"], _ms(row["median_seconds"]), _times(row["times"]))
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


def _obstacles(results: dict[str, Any]) -> list[Table]:
    head = ("walls", "rays", "contender", "ms", "least", "times ours", "skipped", "other hits")
    rows = [
        (
            row["walls"],
            row["rays"],
            row["contender"],
            _ms(row["median_seconds"]),
            _ms(row["minimum_seconds"]),
            _times(row["times_ours"]),
            "-" if row["skipped"] is None else f"{row['skipped']:.1%}",
            row["other_hits"],
        )
        for row in results["rows"]
    ]
    moving_head = ("walls", "follow, ms", "build, ms", "follow / build", "steps", "rebuilds")
    moving = [
        (
            row["walls"],
            _ms(row["follow_seconds"]),
            _ms(row["build_seconds"]),
            f"{row['follow_over_build']:.3f}",
            row["steps"],
            row["rebuilds"],
        )
        for row in results["moving"]
    ]
    count = results["settings"]["rays"]
    return [
        (f"first walls on {count} rays, medians; skipped: tried no wall", head, rows),
        ("one moving octagon: planes that follow, or a new tree", moving_head, moving),
    ]


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.3g}"


def _times(ratio: float | None) -> str:
    return "-" if ratio is None else f"{ratio:.2f}"
