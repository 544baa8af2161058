"""Finite elements: FreeFem++, run as a good user would.

P2 elements on a uniform mesh of the region that the field stays in, two schemes, each a
script beside this file:

* ``p2_crank_nicolson.edp``: convection and diffusion together, one factorisation;
* ``p2_bdf2_characteristics.edp``: the flow followed backwards along its exact
  characteristics, diffusion by BDF2, one factorisation.

What the scripts have in common, the problem, the mesh and the number of steps, is written
to ``problem.edp`` for each run.  Their time begins when the mesh is there and ends with the
last step: assembly, factorisation and steps.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np

from apmethod.bench.error.problem import Problem

SCHEMES = {
    "FreeFem++ P2, Crank-Nicolson": "p2_crank_nicolson.edp",
    "FreeFem++ P2, BDF2 on characteristics": "p2_bdf2_characteristics.edp",
}


class Solved(NamedTuple):
    """A run of finite elements.

    Attributes:
        values: the solution at the points asked for.
        seconds: of assembly, factorisation and all steps.
        unknowns: of a step's system.
    """

    values: np.ndarray
    seconds: float
    unknowns: int


def executable() -> str | None:
    """Path of FreeFem++, or None where it is not installed."""
    return shutil.which("FreeFem++")


def versions() -> dict[str, str]:
    """Its version and the linear algebra it is linked with."""
    path = executable()
    if path is None:
        return {}
    told = subprocess.run([path, "-nw", "none.edp"], capture_output=True, text=True)
    words = (told.stdout + told.stderr).split()
    version = next((word for word in words if word.startswith("v") and word[1:2].isdigit()), "?")
    return {"FreeFem++": version, "BLAS of FreeFem++": _blas(path)}


def _blas(path: str) -> str:
    """The library behind its ``libblas``, where the system's loader tells."""
    ldd = shutil.which("ldd")
    told = subprocess.run([ldd, path], capture_output=True, text=True).stdout if ldd else ""
    for line in told.splitlines():
        if "libblas" in line and "=>" in line:
            return str(Path(line.split("=>")[1].split()[0]).resolve())
    return "unknown"


def solve(
    scheme: str, problem: Problem, edges: int, steps: int, x: np.ndarray, y: np.ndarray,
    threads: int = 1,
) -> Solved:  # fmt: skip
    """Run a scheme of ``SCHEMES``.

    Args:
        scheme: its name.
        problem: one with a ``freefem``.
        edges: of the mesh along a side, or along a quarter of a disc's rim.
        steps: time steps.
        x, y: where the solution is wanted, of one shape.
        threads: of its BLAS.

    Raises:
        RuntimeError: if FreeFem++ fails; its last words are quoted.
    """
    script = Path(__file__).with_name(SCHEMES[scheme])
    with tempfile.TemporaryDirectory(prefix="apmethod-freefem-") as name:
        folder = Path(name)
        (folder / "problem.edp").write_text(problem_script(problem, edges, steps))
        np.savetxt(folder / "points.txt", np.column_stack([np.ravel(x), np.ravel(y)]),
                   header=str(np.size(x)), comments="")  # fmt: skip
        for source in (script, script.with_name("report.edp")):
            shutil.copy(source, folder)
        seconds = _run(script.name, folder, threads)
        told = dict(line.split() for line in (folder / "told.txt").read_text().splitlines())
        values = np.loadtxt(folder / "values.txt").reshape(np.shape(x))
    return Solved(values, seconds, int(told["unknowns"]))


def _run(script: str, folder: Path, threads: int) -> float:
    """Run a script; the wall time from when it says ``begun`` to when it says ``ended``.

    It is our clock that is read: FreeFem++'s own tell processor time or whole seconds, and
    the times of files that it might leave are as coarse as the system's tick, in which a
    small run begins and ends.
    """
    said, words = {}, []
    with subprocess.Popen(
        [executable(), "-nw", "-v", "0", script], cwd=folder, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        env=os.environ | {"OPENBLAS_NUM_THREADS": str(threads), "OMP_NUM_THREADS": str(threads)},
    ) as run:  # fmt: skip
        for line in run.stdout:
            said[line.strip()] = perf_counter()
            words.append(line.strip())
    if run.returncode:
        last = next((word for word in reversed(words) if word), "it said nothing")
        raise RuntimeError(f"FreeFem++ ended {script} with {run.returncode}: {last}")
    return said["ended"] - said["begun"]


def problem_script(problem: Problem, edges: int, steps: int) -> str:
    """What the scripts include: the problem in FreeFem++'s language."""
    words = problem.freefem
    x_min, x_max, y_min, y_max = problem.box
    if words.round:
        radius = 0.5 * (x_max - x_min)
        mesh = (
            f"border rim(t=0, 2*pi){{x={radius}*cos(t); y={radius}*sin(t);}}\n"
            f"mesh Th = buildmesh(rim({4 * edges}));"
        )
    else:
        shortest = min(x_max - x_min, y_max - y_min)
        along = [round(edges * (high - low) / shortest) for low, high in
                 ((x_min, x_max), (y_min, y_max))]  # fmt: skip
        mesh = (
            f"mesh Th = square({along[0]}, {along[1]}, "
            f"[{x_min}+({x_max}-({x_min}))*x, {y_min}+({y_max}-({y_min}))*y]);"
        )
    return f"""// {problem.name}
real D = {problem.diffusivity}, growth = {problem.growth}, until = {problem.until};
int steps = {steps};
real dt = until / steps;
func vx = {words.velocity[0]};
func vy = {words.velocity[1]};
macro footX(s) ({words.foot[0]}) // where the flow comes from in the time s
macro footY(s) ({words.foot[1]}) //
func start = {problem.freefem_start()};
{mesh}
"""
