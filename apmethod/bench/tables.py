"""The benchmarks' results as tables for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from apmethod.bench.results import machine_line
from apmethod.run.report import print_table

#: A table: its title, its columns' names, and its rows.
Table = tuple[str, Sequence[str], list[tuple]]


def show(results: dict[str, Any], tables: Sequence[Table], files: dict[str, str]) -> None:
    """Print a benchmark's tables, what was checked, where it ran, and its files."""
    for title, head, rows in tables:
        print_table(title, rows, head)
    if "checked" in results:
        print(f"checked before timing: {results['checked']}")
    print(machine_line(results["machine"]))
    for kind, path in files.items():
        print(f"{kind:8} {path}")


def ms(seconds: float) -> str:
    """Milliseconds to three digits."""
    return digits(1e3 * seconds)


def digits(number: float) -> str:
    """A number to three digits, a large one to its last before the point."""
    return f"{number:.0f}" if abs(number) >= 999.5 else f"{number:.3g}"


def times(ratio: float | None) -> str:
    """A ratio, or a dash where there is none."""
    return "-" if ratio is None else f"{ratio:.2f}"
