"""Finite elements where FreeFem++ is missing: scikit-fem, P2 and Crank-Nicolson.

``pip install scikit-fem``.  Convection and diffusion together on a uniform mesh of the box,
the matrix factorised once by SciPy's SuperLU, as `p2_crank_nicolson.edp` does.
"""

from __future__ import annotations

from importlib.metadata import version
from importlib.util import find_spec
from time import perf_counter

import numpy as np

from apmethod.bench.error.freefem import Solved
from apmethod.bench.error.problem import Problem

SCHEMES = {"scikit-fem P2, Crank-Nicolson": None}


def installed() -> bool:
    """Whether it can be imported."""
    return find_spec("skfem") is not None


def versions() -> dict[str, str]:
    """Its version and what solves its systems."""
    return {"scikit-fem": version("scikit-fem"), "solver": "SciPy SuperLU"}


def solve(
    scheme: str, problem: Problem, edges: int, steps: int, x: np.ndarray, y: np.ndarray,
    threads: int = 1,
) -> Solved:  # fmt: skip
    """Run it; see `apmethod.bench.error.freefem.solve`.  A flow must not change in time."""
    from scipy.sparse.linalg import splu
    from skfem import Basis, BilinearForm, ElementTriP2, LinearForm, MeshTri
    from skfem.helpers import dot, grad

    x_min, x_max, y_min, y_max = problem.box
    shortest = min(x_max - x_min, y_max - y_min)
    axes = [
        np.linspace(low, high, 1 + round(edges * (high - low) / shortest))
        for low, high in ((x_min, x_max), (y_min, y_max))
    ]
    mesh = MeshTri.init_tensor(*axes)
    flow = problem.flow or (lambda x, y, t: (0.0 * x, 0.0 * y))

    @BilinearForm
    def mass(u, v, w):
        return u * v

    @BilinearForm
    def rate(u, v, w):
        vx, vy = flow(w.x[0], w.x[1], 0.0)
        carried = u * (vx * grad(v)[0] + vy * grad(v)[1])
        return carried - problem.diffusivity * dot(grad(u), grad(v)) + problem.growth * u * v

    @LinearForm
    def start(v, w):
        return problem.exact(w.x[0], w.x[1], 0.0) * v

    began, dt = perf_counter(), problem.until / steps
    basis = Basis(mesh, ElementTriP2())
    m, r = mass.assemble(basis), rate.assemble(basis)
    after, before = splu((m - 0.5 * dt * r).tocsc()), (m + 0.5 * dt * r).tocsr()
    u = splu(m.tocsc()).solve(start.assemble(basis))
    for _ in range(steps):
        u = after.solve(before @ u)
    seconds = perf_counter() - began
    values = basis.probes(np.vstack([np.ravel(x), np.ravel(y)])) @ u
    return Solved(values.reshape(np.shape(x)), seconds, len(u))
