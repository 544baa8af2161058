"""Error against run time: agents by several schemes, and finite elements.

Every contender solves the same problem; errors are relative L2 norms on one and the same
grid of 160 x 160 points.  Run time is that of all steps.  Building the agents, meshing,
compiling and the evaluation of the error are outside it; assembly and factorisation, which
a finite-element code cannot do without, are inside.  Short runs are repeated and the
shortest time counts.

Each run is kept as it ends, and read again the next time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from apmethod.bench.error import freefem, scikit_fem
from apmethod.bench.error.compare import comparisons, orders
from apmethod.bench.error.problem import Problem
from apmethod.bench.error.problems import PROBLEMS
from apmethod.bench.kept import Kept
from apmethod.bench.results import machine
from apmethod.bench.timing import Progress, Report
from apmethod.compile import threads
from apmethod.field.accuracy import FEW

SIZES = (125, 250, 500, 1000, 2000, 4000, 8000, 16_000, 32_000, 64_000)
#: What the study takes unless it is told, and in its short form.
CHOSEN = (
    "mixture-1e-3",
    "mixture-1e-4",
    "mixture-1e-5",
    "diffusion",
    "shear",
    "disc",
    "box",
    "relaxation",
)
QUICK = ("mixture-1e-3", "diffusion")
#: Settings of `FieldModel`, and the largest number of agents that is worth the wait.
SCHEMES: dict[str, tuple[dict[str, Any], int]] = {
    "paper, Euler": ({"accuracy": "paper", "integrator": "euler"}, 4000),
    "paper": ({"accuracy": "paper"}, 16_000),
    "plain, fourth order": ({"accuracy": "accurate", "kernel": "gaussian_4"}, 64_000),
    "conservative": ({"accuracy": "conservative"}, 64_000),
    "accurate": ({"accuracy": "accurate"}, 64_000),
}
#: Mesh edges along a side, and those of the short form.
EDGES = (10, 15, 20, 30, 60, 120)
QUICK_EDGES = (10, 20, 40)
#: A contender whose run took longer than this, in seconds, gets no larger ones; in the
#: short form it is less.
PATIENCE, QUICK_PATIENCE = 12.0, 2.0
#: Short runs are repeated until they have taken this share of the patience, or so often.
_ENOUGH, _ROUNDS = 1.0 / 12.0, 9

Run = dict[str, Any]


def study(
    problems: Sequence[str] = CHOSEN,
    sizes: Sequence[int] = SIZES,
    edges: Sequence[int] = EDGES,
    folder: Path | None = None,
    report: Report | None = None,
    *,
    patience: float = PATIENCE,
) -> dict[str, Any]:
    """Run all contenders on the problems.

    Args:
        problems: names in `apmethod.bench.error.problems.PROBLEMS`.
        sizes: numbers of agents.
        edges: finite-element meshes, in edges along a side.
        folder: where finished runs are kept; None for nowhere.
        report: called with the share done and the runs made.
        patience: seconds of a run after which its contender gets no larger ones.

    Returns:
        A dictionary with ``rows``, one a run, ``orders`` and ``comparisons``.

    Raises:
        ValueError: for an unknown problem.
        RuntimeError: if a finite-element code fails.
    """
    unknown = [name for name in problems if name not in PROBLEMS]
    if unknown:
        raise ValueError(f"problem is {unknown[0]!r}; it must be one of {', '.join(PROBLEMS)}")
    elements = freefem if freefem.executable() else scikit_fem if scikit_fem.installed() else None
    kept = Kept(folder)
    plan = [
        (PROBLEMS[name], contender)
        for name in problems
        for contender in [*SCHEMES, *(elements.SCHEMES if elements else ())]
        if contender in SCHEMES or PROBLEMS[name].freefem is not None
    ]
    progress = Progress(report, [1] * len(plan))
    rows: list[Run] = []
    for problem, contender in plan:
        if contender in SCHEMES:
            rows += _agents(problem, contender, sizes, kept, patience)
        else:
            rows += _elements(elements, problem, contender, edges, kept, patience)
        progress.made(1)
    return {
        "benchmark": "error",
        "machine": machine() | ({"finite elements": elements.versions()} if elements else {}),
        "settings": {"problems": list(problems), "sizes": list(sizes), "edges": list(edges)},
        "orders": orders(rows),
        "comparisons": comparisons(rows, list(problems)),
        "rows": rows,
    }


# -- agents ----------------------------------------------------------------------------


def _agents(
    problem: Problem, scheme: str, sizes: Sequence[int], kept: Kept, patience: float
) -> list[Run]:
    options, largest = SCHEMES[scheme]
    warm: set[int] = set()

    def run(size: int) -> Run:
        like = 300 if size <= FEW else FEW + 1  # few agents and many have kernels of their own
        if like not in warm:
            _warm_up(problem, options, like)
            warm.add(like)
        return _repeated(lambda: run_agents(problem, scheme, size), patience)

    rows = []
    for size in sizes:
        if size > largest or (rows and rows[-1]["seconds"] > patience):
            break
        key = {"problem": problem.name, "contender": scheme, "options": str(options), "size": size}
        rows.append(kept.or_made(key, lambda size=size: run(size)))
    return rows


def _warm_up(problem: Problem, options: Mapping[str, Any], size: int) -> None:
    """Have everything compiled that a run will use."""
    model = problem.model(size, rng=0, **options)
    model.step()
    model.errors()
    if model.remesh is not None:
        model.remesh.lay_anew()


def run_agents(problem: Problem, scheme: str, size: int, seed: int = 1) -> Run:
    """One run by agents."""
    began = perf_counter()
    model = problem.model(size, rng=seed, **SCHEMES[scheme][0])
    built = perf_counter()
    while model.elapsed < model.until:
        model.step()
    ended = perf_counter()
    return {
        "problem": problem.name, "contender": scheme, "kind": "agents",
        "size": size, "steps": model.steps, "error": model.errors()["l2_error"],
        "seconds": ended - built, "build_seconds": built - began,
        "agents_at_the_end": len(model.particles),
    }  # fmt: skip


# -- finite elements -------------------------------------------------------------------


def _elements(
    library: Any, problem: Problem, scheme: str, edges: Sequence[int], kept: Kept,
    patience: float,
) -> list[Run]:  # fmt: skip
    rows: list[Run] = []
    for along in edges:
        for steps in steps_for(problem, scheme, along):
            if any(row["seconds"] > patience for row in rows):
                return rows
            key = {"problem": problem.name, "contender": scheme, "edges": along, "steps": steps}
            rows.append(
                kept.or_made(
                    key, lambda along=along, steps=steps: _repeated(
                        lambda: run_elements(library, problem, scheme, along, steps), patience
                    ),
                )
            )  # fmt: skip
    return rows


def steps_for(problem: Problem, scheme: str, edges: int) -> list[int]:
    """Numbers of steps worth trying on a mesh; the study keeps the best of them.

    Along characteristics a step may be long.  Crank-Nicolson has to follow the flow from
    element to element.
    """
    finest = max(12, 2 * edges // 3)
    if problem.flow is not None and "Crank" in scheme:
        return [8 * edges, 16 * edges]
    return [finest // 4, finest // 2, finest]


def run_elements(library: Any, problem: Problem, scheme: str, edges: int, steps: int) -> Run:
    """One run by finite elements."""
    x_min, x_max, y_min, y_max = problem.box
    x, y = np.meshgrid(np.linspace(x_min, x_max, 160), np.linspace(y_min, y_max, 160))
    solved = library.solve(scheme, problem, edges, steps, x, y, threads())
    exact = problem.exact(x, y, problem.until)
    return {
        "problem": problem.name, "contender": scheme, "kind": "elements",
        "size": solved.unknowns, "steps": steps,
        "error": float(np.sqrt(((solved.values - exact) ** 2).sum() / (exact**2).sum())),
        "seconds": solved.seconds,
    }  # fmt: skip


def _repeated(run: Callable[[], Run], patience: float) -> Run:
    """The run with the shortest time, short ones repeated."""
    best, spent = run(), 0.0
    for _ in range(_ROUNDS - 1):
        spent += best["seconds"]
        if spent > _ENOUGH * patience:
            break
        again = run()
        if again["seconds"] < best["seconds"]:
            best = again
    return best
