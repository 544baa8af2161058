"""Stored evaluation: neighbours are found once and listed, and every round runs over them."""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from apmethod.compile import compiled, in_blocks
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term
from apmethod.message.fuse import ingredients
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import distance_2
from apmethod.perceive.lists import NeighbourLists


def sum_over_lists(
    terms: Sequence[Term],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    cells: SortedCells,
    lists: NeighbourLists,
    row: np.ndarray,
    table: np.ndarray,
    sums: np.ndarray,
) -> None:
    """Write each agent's sums; see `apmethod.message.passes.RoundPass`."""
    in_blocks(
        _compile(tuple(terms), kernel, reads, bool(len(cells.image)), bool(len(cells.radius))),
        len(cells.row),
        lists.start, lists.other, cells.entries, row, table, cells.core_radius, kernel.support,
        sums, least=500,
    )  # fmt: skip


@cache
def _compile(
    terms: tuple[Term, ...],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    periodic: bool,
    own_radii: bool,
) -> Callable:
    make_pair, read, evaluate, evaluate_own, add, zero = ingredients(terms, kernel, reads)
    width = len(zero)

    @compiled
    def stored_sums(
        first, last, begin, other, entries, row, table, core_radius, support, sums
    ):  # fmt: skip
        x, y, shift_x, shift_y, image, radius = entries
        for i in range(first, last):
            if periodic and image[i]:
                continue
            me = read(table, i)
            reach = radius[i] if own_radii else core_radius
            h = reach / support
            total = add(zero, evaluate_own(make_pair(0.0, 0.0, h), me, me), True)
            for k in range(begin[i], begin[i + 1]):
                j = other[k]
                dx, dy = x[i] - x[j], y[i] - y[j]
                if periodic:
                    dx, dy = dx - shift_x[j], dy - shift_y[j]
                if own_radii:
                    reach = 0.5 * (radius[i] + radius[j])
                    h = reach / support
                value = evaluate(make_pair(dx, dy, h), me, read(table, j))
                total = add(total, value, distance_2(dx, dy) < reach * reach)
            for part in range(width):
                sums[row[i], part] = total[part]

    return stored_sums
