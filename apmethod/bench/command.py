"""``apmethod bench`` and its benchmarks: what each takes, and what it runs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

#: How to make an environment with PySPH, which needs an older numpy and a C++ compiler.
_PYSPH = """\
PySPH needs an environment of its own, with numpy below 2 and a C++ compiler (g++, with
OpenMP).  Python 3.11:

    python3.11 -m venv pysph-environment
    pysph-environment/bin/pip install "numpy<2" "cython<3.1" "setuptools<70" wheel
    pysph-environment/bin/pip install mako cyarray compyle
    pysph-environment/bin/pip install --no-build-isolation pysph
    apmethod bench sums --pysph pysph-environment/bin/python
"""

_QUICK = "a short form for a look, two minutes at most"


def add_parser(commands: Any) -> None:
    """Add ``bench`` to the command line's commands."""
    bench = commands.add_parser("bench", help="measure this machine, against peers and the paper")
    benchmarks = bench.add_subparsers(required=True, metavar="BENCHMARK")
    _add_neighbours(benchmarks)
    _add_sums(benchmarks)
    _add_scale(benchmarks)
    _add_error(benchmarks)
    _add_stability(benchmarks)
    _add_aggregation(benchmarks)
    _add_obstacles(benchmarks)


def _add_neighbours(benchmarks: Any) -> None:
    parser = _benchmark(
        benchmarks, "neighbours", _neighbours, "the paper's study of its quad-lattice (2.4.3)",
        "Uniform random agents in the periodic square ]-1/2, 1/2[^2 move at random and find "
        "their neighbours by A1 (p = 0), A2 (p = 1) and p = 2, agent by agent and compiled: "
        "candidates as Table 2 predicts them and as counted, times, and Figure 3.",
    )  # fmt: skip
    parser.add_argument("--steps", type=int, help="random moves at each size (default: 20)")
    parser.add_argument(
        "--mesa", action="store_true", help="also time Mesa's continuous spaces at the largest size"
    )


def _add_sums(benchmarks: Any) -> None:
    parser = _benchmark(
        benchmarks, "sums", _sums, "perceive, contribute and message against installed peers",
        "Density and gradient, cubic B-spline, 28 neighbours, double precision, uniform random "
        "agents that move at random, against SciPy's cKDTree, freud (pip install "
        "freud-analysis), PySPH, and Mesa's continuous spaces at small sizes.\n\n" + _PYSPH,
    )  # fmt: skip
    parser.add_argument("--rounds", type=int, help="runs of each contender (default: 7)")
    parser.add_argument("--pysph", metavar="PYTHON", help="interpreter of PySPH's environment")


def _add_scale(benchmarks: Any) -> None:
    parser = _benchmark(
        benchmarks, "scale", _scale, "a whole step of the rotating hill as agents grow in number",
        "Time by phase and memory per agent, building against bare Mesa agents, and first "
        "steps with and without machine code on disk; each in a fresh process.",
    )  # fmt: skip
    parser.add_argument("--largest", type=int, metavar="N", help="leave out the sizes above N")
    parser.add_argument("--rounds", type=int, help="processes of each size (default: 3)")
    parser.add_argument("--steps", type=int, help="timed steps of each process (default: 5)")


def _add_error(benchmarks: Any) -> None:
    parser = _benchmark(
        benchmarks, "error", _error, "error against run time, beside finite elements",
        "Problems with exact solutions by several schemes of agents, and by FreeFem++ (apt "
        "install freefem++) or, where it is missing, scikit-fem (pip install scikit-fem): "
        "relative L2 error on one grid, time of all steps without building and compiling. "
        "Runs that the output folder has already are not made again.",
    )  # fmt: skip
    parser.add_argument(
        "--problems", metavar="NAME,NAME,...", help="which problems (default: eight of them)"
    )


def _add_stability(benchmarks: Any) -> None:
    _benchmark(
        benchmarks, "stability", _stability, "the largest stable steps, beside the theory",
        "D dt/h^2 of each form, kernel and integrator by bisection; maps over the step and the "
        "smoothing length; disordered starts, uneven masses, units, Peclet numbers; 10^5 steps, "
        "and the shipped scenes ten times their length. All of it takes about half an hour; parts "
        "that the output folder has already are not made again. Sizes are given.",
    )  # fmt: skip


def _add_aggregation(benchmarks: Any) -> None:
    parser = _benchmark(
        benchmarks, "aggregation", _aggregation, "the paper's animals (3.2): Figures 9 and 10",
        "Growth of small waves against the dispersion relation; Figures 9 and 10 over many "
        "seeds, with 95 % confidence, drawn as the paper does; what signals and groups cost, "
        "and scikit-learn's DBSCAN where it is installed.  Sizes are those of the costs.",
    )  # fmt: skip
    parser.add_argument("--seeds", type=int, help="seeds of each setting (default: 20)")
    parser.add_argument("--rounds", type=int, help="timed rounds (default: 7)")


def _add_obstacles(benchmarks: Any) -> None:
    parser = _benchmark(
        benchmarks, "obstacles", _obstacles, "first walls on displacements (paper 2.5)",
        "10^5 short and long rays among octagons: kd-tree-domains by the surface area "
        "heuristic and by the median, no tree, and shapely's STRtree and Embree (pip install "
        "shapely embreex) if they are installed; one moving octagon, with planes that follow "
        "it or a new tree; and what 1000 obstacles far from all agents add to a step. Sizes are "
        "numbers of walls.",
    )  # fmt: skip
    parser.add_argument("--rounds", type=int, help="runs of each contender (default: 7)")


def _benchmark(
    benchmarks: Any, name: str, command: Callable, summary: str, description: str
) -> argparse.ArgumentParser:
    """A benchmark's parser with the options that all of them have."""
    parser = benchmarks.add_parser(
        name, help=summary, description=description,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument(
        "--sizes", type=_sizes, metavar="N,N,...", help="numbers of agents, in growing order"
    )
    parser.add_argument("--quick", action="store_true", help=_QUICK)
    parser.add_argument("--threads", type=int, help="threads of the compiled tier (default: all)")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help=f"folder for the results (default: out/bench_{name})",
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(command=_measured(name, command))
    return parser


def _sizes(text: str) -> list[int]:
    try:
        sizes = [int(number) for number in text.split(",")]
    except ValueError:
        sizes = []
    if not sizes or sizes[0] < 1 or sorted(set(sizes)) != sizes:
        raise argparse.ArgumentTypeError(
            f"sizes is {text!r}; it must be growing whole numbers with commas, as 1000,16000"
        )
    return sizes


def _measured(name: str, command: Callable) -> Callable[[argparse.Namespace], int]:
    """A command that measures, writes the files, and prints tables or JSON."""

    def run(options: argparse.Namespace) -> int:
        from apmethod.bench.results import write_table
        from apmethod.bench.tables import show
        from apmethod.compile import set_threads
        from apmethod.run.report import print_json
        from apmethod.view.progress import progress_bar

        if options.threads is not None:
            set_threads(options.threads)
        try:
            with progress_bar(name) as report:
                results = command(options, report)
        except RuntimeError as error:  # contenders that disagree, a process that failed
            if options.debug:
                raise
            print(f"apmethod: {error}", file=sys.stderr)
            return 1
        except KeyboardInterrupt:
            return 130
        shown = import_module(f"apmethod.bench.{name}.report")
        folder = options.out or Path("out") / f"bench_{name}"
        files = write_table(folder, name, results)
        files["plot"] = str(folder / f"{name}.png")
        shown.draw(results, Path(files["plot"]))
        if options.json:
            print_json(results | {"files": files})
        else:
            show(results, shown.tables(results), files)
        return 0

    return run


def _neighbours(options: argparse.Namespace, report: Callable) -> dict[str, Any]:
    from apmethod.bench.neighbours.against_mesa import against_mesa
    from apmethod.bench.neighbours.study import SIZES, study

    sizes = options.sizes or (SIZES[:3] if options.quick else SIZES)
    steps = _chosen("steps", options.steps, 3 if options.quick else 20)
    results = study(sizes, steps, report=report)
    if options.mesa:
        results["mesa"] = against_mesa(sizes[-1], sample=200 if options.quick else None)
    return results


def _sums(options: argparse.Namespace, report: Callable) -> dict[str, Any]:
    from apmethod.bench.sums.study import SIZES, study

    sizes = options.sizes or (SIZES[:2] if options.quick else SIZES)
    rounds = _chosen("rounds", options.rounds, 3 if options.quick else 7)
    return study(sizes, rounds, options.pysph, report=report)


def _scale(options: argparse.Namespace, report: Callable) -> dict[str, Any]:
    from apmethod.bench.scale.study import SIZES, study

    sizes = options.sizes or (SIZES[:2] if options.quick else SIZES)
    if options.largest is not None:
        sizes = [size for size in sizes if size <= options.largest]
        if not sizes:
            raise ValueError(f"largest is {options.largest}; no size is that small")
    rounds = _chosen("rounds", options.rounds, 1 if options.quick else 3)
    return study(sizes, rounds, _chosen("steps", options.steps, 5), report)


def _error(options: argparse.Namespace, report: Callable) -> dict[str, Any]:
    from apmethod.bench.error.study import (
        CHOSEN,
        EDGES,
        PATIENCE,
        QUICK,
        QUICK_EDGES,
        QUICK_PATIENCE,
        SIZES,
        study,
    )

    names = options.problems.split(",") if options.problems else QUICK if options.quick else CHOSEN
    sizes = options.sizes or (SIZES[:6] if options.quick else SIZES)
    edges = QUICK_EDGES if options.quick else EDGES
    folder = options.out or Path("out") / "bench_error"
    patience = QUICK_PATIENCE if options.quick else PATIENCE
    return study(names, sizes, edges, folder, report, patience=patience)


def _stability(options: argparse.Namespace, report: Callable) -> dict[str, Any]:
    from apmethod.bench.stability.study import study

    if options.sizes:
        raise ValueError(f"sizes is {options.sizes}; the stability study has sizes of its own")
    return study(options.quick, options.out or Path("out") / "bench_stability", report)


def _aggregation(options: argparse.Namespace, report: Callable) -> dict[str, Any]:
    from apmethod.bench.aggregation import gatherings
    from apmethod.bench.aggregation.study import study

    return study(
        options.out or Path("out") / "bench_aggregation",
        _chosen("seeds", options.seeds, 2 if options.quick else 20),
        (options.sizes or [10_000 if options.quick else 100_000])[-1],
        _chosen("rounds", options.rounds, 3 if options.quick else 7),
        until=gatherings.QUICK if options.quick else None,
        report=report,
    )


def _obstacles(options: argparse.Namespace, report: Callable) -> dict[str, Any]:
    from apmethod.bench.obstacles.study import RAYS, SIZES, study

    sizes = options.sizes or (SIZES[:3] if options.quick else SIZES)
    rounds = _chosen("rounds", options.rounds, 3 if options.quick else 7)
    return study(sizes, rounds, RAYS // 5 if options.quick else RAYS, report=report)


def _chosen(name: str, given: int | None, otherwise: int) -> int:
    from apmethod.checks import whole_number

    return otherwise if given is None else whole_number(name, given, least=1)
