"""Scattered evaluation: each pair is computed once and both ends get their half.

This is the paper's message (2.3) compiled.  Lines of sub-domains are taken together in
slabs as high as a cell, so that a slab's pairs reach into the next one at most.  The even
slabs are summed first and then the odd ones, each on its own thread: no two threads write
to one agent, and an agent's sum has the same order for any number of threads.

The agents behind a sub-domain in the sorted order are copied block by block into a short
table, with a column for each part of the message.  Each agent of the sub-domain runs over
that table without a branch, sums its own halves and adds the others' to their columns,
all in vector instructions; then the columns are added to the sums.
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

#: Agents in a block: few enough for the nearest cache, enough for most sub-domains.
_BLOCK = 240
#: Blocks are filled up to a multiple of this, so that no agent is left to scalar code.
_LANES = 8


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
    run = _compile(tuple(terms), kernel, reads, bool(len(cells.image)), len(table))
    slab = cells.number // (cells.grid[0] * 2**cells.level)
    begin = np.flatnonzero(np.diff(slab, prepend=-1))
    end = np.append(begin[1:], len(slab))
    total = np.zeros((len(cells.row), width_of(terms)))
    for colour in (0, 1):
        chosen = slab[begin] % 2 == colour
        in_blocks(
            run, int(chosen.sum()), begin[chosen], end[chosen], cells.start, cells.low,
            cells.high, cells.x, cells.y, cells.shift_x, cells.shift_y, table,
            cells.core_radius, cells.core_radius / kernel.support, total, least=4,
        )  # fmt: skip
    in_blocks(_deliver, len(row), row, cells.image, total, sums)


@compiled
def _deliver(first, last, row, image, total, sums):
    """Write the sums in the order of the table's rows."""
    for k in range(first, last):
        if not (image.size and image[k]):
            for part in range(sums.shape[1]):
                sums[row[k], part] = total[k, part]


@cache
def _compile(
    terms: tuple[Term, ...],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    images: bool,
    lines: int,
) -> Callable:
    make_pair, read, evaluate, evaluate_own, add, zero = ingredients(terms, kernel, reads)
    mirror = mirror_evaluator(terms)
    width = len(zero)
    # Rows of a block: what the terms read, x, y, the shifts of images, the halves to send.
    place = lines
    shift = place + 2
    half = shift + (2 if images else 0)

    @compiled
    def scatter_sums(
        first, last, begin, end, start, low, high, x, y, shift_x, shift_y, table,
        core_radius, smoothing_length, sums,
    ):  # fmt: skip
        radius_2 = core_radius * core_radius
        runs = low.shape[1]
        block = np.ones((half + width, _BLOCK + _LANES))
        piece, size = np.empty(runs, np.int64), np.empty(runs, np.int64)
        for slab in range(first, last):
            for cell in range(begin[slab], end[slab]):
                # Entries from the sub-domain's own on: the rest of its line, and north.
                run, at = runs // 2, start[cell]
                done = 0
                while run < runs:
                    pieces, count = 0, 0
                    while run < runs and count < _BLOCK:
                        length = min(high[cell, run] - at, _BLOCK - count)
                        for k in range(length):
                            block[place, count + k] = x[at + k]
                            block[place + 1, count + k] = y[at + k]
                        if images:
                            for k in range(length):
                                block[shift, count + k] = shift_x[at + k]
                                block[shift + 1, count + k] = shift_y[at + k]
                        for line in range(lines):
                            for k in range(length):
                                block[line, count + k] = table[line, at + k]
                        piece[pieces], size[pieces] = at, length
                        pieces += 1
                        count += length
                        at += length
                        if at == high[cell, run]:
                            run += 1
                            at = low[cell, run] if run < runs else 0
                    for k in range(count, count + _LANES):
                        block[place, k] = np.inf  # nobody is near there
                    for part in range(width):
                        for k in range(count + _LANES):
                            block[half + part, k] = 0.0
                    for i in range(start[cell], start[cell + 1]):
                        me = read(table, i)
                        x_i, y_i = x[i], y[i]
                        if done == 0:
                            own = evaluate_own(make_pair(0.0, 0.0, smoothing_length), me, me)
                            total = add(zero, own, True)
                        else:
                            total = zero
                        behind = max(i + 1 - start[cell] - done, 0)
                        ahead = block[:, behind:]
                        for j in range((count - behind + _LANES - 1) // _LANES * _LANES):
                            dx, dy = x_i - ahead[place, j], y_i - ahead[place + 1, j]
                            if images:
                                dx = (dx + shift_x[i]) - ahead[shift, j]
                                dy = (dy + shift_y[i]) - ahead[shift + 1, j]
                            near = distance_2(dx, dy) < radius_2
                            pair, you = make_pair(dx, dy, smoothing_length), read(ahead, j)
                            total = add(total, evaluate(pair, me, you), near)
                            back = mirror(pair, me, you)
                            for part in range(width):
                                ahead[half + part, j] += back[part] if near else 0.0
                        for part in range(width):
                            sums[i, part] += total[part]
                    count = 0
                    for k in range(pieces):
                        for part in range(width):
                            for j in range(size[k]):
                                sums[piece[k] + j, part] += block[half + part, count + j]
                        count += size[k]
                    done += count

    return scatter_sums
