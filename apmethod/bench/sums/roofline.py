"""What this processor could do at the arithmetic of the sums, measured.

Two ceilings, both for double precision:

* the arithmetic ceiling: the very formulas of the sums (kernel, slope, density, gradient,
  the choice by the core radius), each candidate tried once for both its ends, over candidates
  that lie in a short array in the nearest cache, in one vectorised loop: no sort, no search,
  no memory;
* the peak: operations a second of a matrix product by NumPy's BLAS, divided by the
  operations that one candidate takes.  A root and a division are counted as one operation
  each, although they take many times the time of a product, so nothing reaches it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from apmethod import KERNELS
from apmethod.bench.timing import stopwatch
from apmethod.compile import compiled, keep
from apmethod.contribute.terms import pair_maker
from apmethod.perceive.domain import distance_2

#: Operations of one candidate: 2 for x_i - x_j, 3 for r^2, 1 for q^2, a root, 4 for the
#: two (s - q)_+, 8 for W, 9 for its slope with a division, 2 for the gradient, 1 to compare
#: with the core radius, and a product, a choice and a sum for each of three sums of both ends.
OPERATIONS = 49

_LENGTH = 504  # six columns of it fill half of a 48 kB cache
_AGENTS = 4000  # of each timed piece, a few milliseconds
_ROUNDS = 15

HOW = (
    "candidates are counted once for both ends; arithmetic ceiling: the formulas of the sums "
    "over candidates in the nearest cache in one vectorised loop, measured on one thread, times "
    "the threads; peak: a matrix product by "
    f"NumPy's BLAS on all processors, over {OPERATIONS} operations a candidate"
)


@cache
def _arithmetic():
    make_pair = pair_maker(KERNELS["cubic"])

    @compiled
    def arithmetic(first, last, places, core_radius, mass, sums):
        h = 0.5 * core_radius
        block = np.zeros((6, _LENGTH))  # x, y, mass, and what the candidates get
        block[:3] = places
        for i in range(first, last):
            x_i, y_i = 0.5 + 1e-6 * i, 0.5
            density, grad_x, grad_y = 0.0, 0.0, 0.0
            for j in range(_LENGTH):
                dx, dy = x_i - block[0, j], y_i - block[1, j]
                pair = make_pair(dx, dy, h)
                near = distance_2(dx, dy) < core_radius * core_radius
                density += keep(near, block[2, j] * pair.w)
                grad_x += keep(near, block[2, j] * pair.grad_x)
                grad_y += keep(near, block[2, j] * pair.grad_y)
                block[3, j] += keep(near, mass * pair.w)
                block[4, j] -= keep(near, mass * pair.grad_x)
                block[5, j] -= keep(near, mass * pair.grad_y)
            sums[i, 0], sums[i, 1], sums[i, 2] = density, grad_x, grad_y
        return block[3:].sum()  # or else they would not be computed

    return arithmetic


def arithmetic_ceiling() -> float:
    """Candidates a second, each for both ends, that the formulas alone allow on one thread."""
    places = np.random.default_rng(0).random((3, _LENGTH))
    sums = np.empty((_AGENTS, 3))
    run = partial(_arithmetic(), 0, _AGENTS, places, 0.5, 1.0, sums)
    return _AGENTS * _LENGTH / _shortest(run)


def peak_operations() -> float:
    """Operations a second of a matrix product, all processors together."""
    size = 1536
    a, b = np.random.default_rng(0).random((2, size, size))
    return 2.0 * size**3 / _shortest(lambda: a @ b)


def roofline(threads: int) -> dict[str, Any]:
    """Both ceilings in candidates a second, and how they were found."""
    peak = peak_operations()
    return {
        "threads": threads,
        "arithmetic_candidates_per_second": threads * arithmetic_ceiling(),
        "peak_operations_per_second": peak,
        "peak_candidates_per_second": peak / OPERATIONS,
        "how": HOW,
    }


def _shortest(run: Callable[[], object]) -> float:
    """The least disturbed time of a run that has been made before."""
    run()
    return min(stopwatch(run) for _ in range(_ROUNDS))
