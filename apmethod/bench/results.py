"""What a benchmark leaves behind: JSON, CSV, and where they were measured."""

from __future__ import annotations

import csv
import json
import os
import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from apmethod import __version__
from apmethod.compile import threads

_PACKAGES = ("numpy", "numba", "scipy", "mesa", "freud-analysis", "shapely", "embreex")


class Disagreement(RuntimeError):
    """Contenders that should have found the same have not; nothing has been timed."""


def machine() -> dict[str, Any]:
    """Processor, threads and versions: what a measurement holds for."""
    found = {"apmethod": __version__, "python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return {
        "processor": _processor(),
        "processors": os.cpu_count(),
        "threads": threads(),
        "system": f"{platform.system()} {platform.machine()}",
        "versions": found,
    }


def machine_line(found: dict[str, Any]) -> str:
    """The same for people, in one line."""
    versions = ", ".join(f"{name} {number}" for name, number in found["versions"].items())
    return (
        f"{found['processor']}, {found['processors']} processors, {found['threads']} threads, "
        f"{found['system']}; {versions}"
    )


def write_table(folder: Path, name: str, results: dict[str, Any]) -> dict[str, str]:
    """Write all results as JSON and their ``rows`` as CSV.

    Returns:
        What was written: the kind of each file and its path.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = {"json": folder / f"{name}.json", "csv": folder / f"{name}.csv"}
    files["json"].write_text(json.dumps(results, indent=2) + "\n")
    with open(files["csv"], "w", newline="") as file:
        head = dict.fromkeys(key for row in results["rows"] for key in row)
        writer = csv.DictWriter(file, head)
        writer.writeheader()
        writer.writerows(results["rows"])
    return {kind: str(path) for kind, path in files.items()}


def _processor() -> str:
    """The processor's model, where the system tells it."""
    if sys.platform == "linux":
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
