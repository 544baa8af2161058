"""A whole step as the number of agents grows: time by phase, memory, building, compiling.

The scene is the rotating hill, with its defaults.  Every number of agents has a process of
its own, and so have the bare Mesa agents that its building is held against, so that no
memory is another's.  Steps are timed with the garbage collector off, building with it on,
as a user has it.  Compile time is that of a first step in a new process, once with an
empty folder for machine code and once with what that left there.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any

from apmethod.bench.results import machine
from apmethod.bench.timing import Progress, Report
from apmethod.compile import threads

SIZES = (10_000, 30_000, 100_000, 300_000, 1_000_000)
#: Agents of the scene whose first steps are timed: the rotating hill's default.
_FIRST = 4000


def study(
    sizes: Sequence[int] = SIZES, rounds: int = 3, steps: int = 5, report: Report | None = None
) -> dict[str, Any]:
    """Measure building, steps and memory at each size, and first steps.

    Args:
        sizes: numbers of agents.
        rounds: processes for each size; medians are over the steps of all of them.
        steps: timed steps of each process, after one that is not.
        report: called with the share done and the rounds made.

    Returns:
        A dictionary with ``rows``, one for each size, and ``first_steps``.

    Raises:
        RuntimeError: if a process fails; its last words are quoted.
    """
    progress = Progress(report, [size for size in sizes for _ in range(rounds)])
    first = first_steps()
    found: dict[int, list[dict[str, Any]]] = {size: [] for size in sizes}
    for _ in range(rounds):
        for size in sizes:
            found[size].append({
                "mesa": worker("mesa", size), "scene": worker("scene", size, steps),
            })  # fmt: skip
            progress.made(size)
    rows = [_row(size, runs) for size, runs in found.items()]
    return {
        "benchmark": "scale",
        "machine": machine(),
        "settings": {"sizes": list(sizes), "rounds": rounds, "steps": steps},
        "cost_of_an_agent": {
            "largest_over_smallest": rows[-1]["nanoseconds_step"] / rows[0]["nanoseconds_step"]
        },
        "first_steps": first,
        "rows": rows,
    }


def first_steps() -> list[dict[str, Any]]:
    """Seconds of the first steps of two processes: machine code to be made, and there."""
    with tempfile.TemporaryDirectory(prefix="apmethod-cache-") as folder:
        return [
            {"cache": cache, **worker("first", _FIRST, variables={"NUMBA_CACHE_DIR": folder})}
            for cache in ("empty", "filled")
        ]


def worker(*arguments: object, variables: Mapping[str, str] | None = None) -> dict[str, Any]:
    """What a fresh process of `apmethod.bench.scale.worker` measures.

    Raises:
        RuntimeError: if it fails; its last words are quoted.
    """
    run = subprocess.run(
        [sys.executable, "-m", "apmethod.bench.scale.worker", *map(str, arguments)],
        capture_output=True,
        text=True,
        env=os.environ | {"APMETHOD_THREADS": str(threads())} | dict(variables or {}),
    )
    if run.returncode:
        last = (run.stderr.strip().splitlines() or ["it said nothing"])[-1]
        what = " ".join(map(str, arguments))
        raise RuntimeError(f"measuring {what!r} ended with status {run.returncode}: {last}")
    return json.loads(run.stdout)


def _row(size: int, runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians of all runs at one size."""
    steps = [step for run in runs for step in run["scene"]["steps"]]
    scene = _median_build(run["scene"] for run in runs)
    mesa = _median_build(run["mesa"] for run in runs)
    memory = {name: median(run["scene"]["bytes"][name] for run in runs)
              for name in runs[0]["scene"]["bytes"]}  # fmt: skip
    return {
        "agents": size,
        **{
            f"nanoseconds_{phase}": 1e9 / size * median(step[phase] for step in steps)
            for phase in steps[0]
        },
        "build_seconds": scene,
        "mesa_build_seconds": mesa,
        "build_over_mesa": scene / mesa,
        **{f"bytes_{name}": value for name, value in memory.items()},
        "bytes_mesa_alone": median(run["mesa"]["bytes"] for run in runs),
    }


def _median_build(runs) -> float:
    return median(seconds for run in runs for seconds in run["build_seconds"])
