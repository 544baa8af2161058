"""Scattered evaluation: each pair is computed once and both ends get their half.

This is the paper's message (2.3) compiled.  Lines of sub-domains are taken together in
slabs as high as a cell, so that a slab's pairs reach into the next one at most.  The even
slabs are summed first and then the odd ones, each on its own thread: no two threads write
to one agent, and an agent's sum has the same order for any number of threads.
"""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from apmethod.compile import compiled, in_blocks
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term
from apmethod.message.fuse import ingredients, mirror_evaluator, width_of
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import distance_2
from apmethod.perceive.images import REAL


def scatter(
    terms: Sequence[Term],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    cells: SortedCells,
    row: np.ndarray,
    table: np.ndarray,
    sums: np.ndarray,
) -> None:
    """Write each agent's sums; see `apmethod.message.passes.RoundPass`."""
    run = _compile(tuple(terms), kernel, reads, bool(len(cells.image)))
    slab = cells.number // cells.grid[0] // 2**cells.level
    slabs, begin = np.unique(slab, return_index=True)
    end = np.append(begin[1:], len(slab))
    total = np.zeros((len(cells.row), width_of(terms)))
    for colour in (0, 1):
        chosen = slabs % 2 == colour
        in_blocks(
            run, int(chosen.sum()), begin[chosen], end[chosen], cells.start, cells.low,
            cells.high, cells.image, cells.x, cells.y, cells.shift_x, cells.shift_y, table,
            cells.core_radius, cells.core_radius / kernel.support, total, least=4,
        )  # fmt: skip
    real = cells.image == REAL if len(cells.image) else slice(None)
    sums[row[real]] = total[real]


@cache
def _compile(
    terms: tuple[Term, ...],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    periodic: bool,
) -> Callable:
    make_pair, read, evaluate, evaluate_own, add, zero = ingredients(terms, kernel, reads)
    mirror = mirror_evaluator(terms)
    width = len(zero)

    @compiled
    def scatter_sums(
        first, last, begin, end, start, low, high, image, x, y, shift_x, shift_y, table,
        core_radius, smoothing_length, sums,
    ):  # fmt: skip
        radius_2 = core_radius * core_radius
        middle = low.shape[1] // 2
        for slab in range(first, last):
            for cell in range(begin[slab], end[slab]):
                for i in range(start[cell], start[cell + 1]):
                    me = read(table, i)
                    own = evaluate_own(make_pair(0.0, 0.0, smoothing_length), me, me)
                    total = add(zero, own, True)
                    # Entries behind i in the sorted order: the rest of its line, and north.
                    for run in range(middle, low.shape[1]):
                        for j in range(max(low[cell, run], i + 1), high[cell, run]):
                            if periodic and image[i] and image[j]:
                                continue
                            dx, dy = x[i] - x[j], y[i] - y[j]
                            if periodic:
                                dx = dx + shift_x[i] - shift_x[j]
                                dy = dy + shift_y[i] - shift_y[j]
                            if distance_2(dx, dy) < radius_2:
                                pair, you = make_pair(dx, dy, smoothing_length), read(table, j)
                                total = add(total, evaluate(pair, me, you), True)
                                half = mirror(pair, me, you)
                                for part in range(width):
                                    sums[j, part] += half[part]
                    for part in range(width):
                        sums[i, part] += total[part]

    return scatter_sums
