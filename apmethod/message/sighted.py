"""Sums of agents near walls: over whom they see, directly and in walls.

Whichever way the sums of all others are taken, those of agents near walls are taken anew
from lists: the quick passes stay as they are, and agents far from walls pay nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from apmethod.compile import compiled, in_blocks
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term
from apmethod.message.fuse import evaluator, ingredients
from apmethod.move.obstacles.sight import Sights


def sum_over_sights(
    terms: Sequence[Term],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    odd: frozenset[str],
    sights: Sights,
    core_radius: float,
    row: np.ndarray,
    table: np.ndarray,
    sums: np.ndarray,
) -> None:
    """Write the sums of agents near walls; see `apmethod.message.passes.RoundPass`."""
    in_blocks(
        _compile(tuple(terms), kernel, reads, odd), len(sights.place), sights.place, sights.begin,
        sights.end, sights.other, sights.dx, sights.dy, sights.sign, row, table,
        _opposite(table[:, : len(row)], reads, odd) if (sights.sign < 0).any() else table,
        core_radius / kernel.support, sums, least=500,
    )  # fmt: skip


def _opposite(
    table: np.ndarray, reads: tuple[tuple[str, int | None], ...], odd: frozenset[str]
) -> np.ndarray:
    """The columns as they are in images of opposite sign."""
    signs = [-1.0 if name in odd else 1.0 for name, parts in reads for _ in range(parts or 1)]
    return np.array(signs)[:, None] * table


@cache
def _compile(
    terms: tuple[Term, ...],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    odd: frozenset[str],
) -> Callable:
    make_pair, read, evaluate, evaluate_own, add, zero = ingredients(terms, kernel, reads)
    width = len(zero)
    # Terms that are not weighed by the mass know of no negative one: they get nothing of it.
    evaluate_odd = evaluator([term for term in terms if term.weight in odd], among=terms)

    @compiled
    def sighted_sums(
        first, last, place, begin, end, other, dx, dy, sign, row, table, opposite,
        smoothing_length, sums,
    ):  # fmt: skip
        for k in range(first, last):
            i = place[k]
            me = read(table, i)
            total = add(zero, evaluate_own(make_pair(0.0, 0.0, smoothing_length), me, me), True)
            for n in range(begin[k], end[k]):
                pair = make_pair(dx[n], dy[n], smoothing_length)
                if sign[n] < 0:
                    total = add(total, evaluate_odd(pair, me, read(opposite, other[n])), True)
                else:
                    total = add(total, evaluate(pair, me, read(table, other[n])), True)
            for part in range(width):
                sums[row[i], part] = total[part]

    return sighted_sums
