"""Gathered evaluation: every agent sums over its potential neighbours.

The potential neighbours of a sub-domain are copied once into a short contiguous buffer,
shared by all agents in it (the list LpN of paper 2.4.2).  Each agent then runs over that
buffer without a branch, which the compiler turns into vector instructions, and adds up
all terms of the round in one pass.  Nothing is stored and no message is mirrored: each
contribution is computed at both of its ends, and no agent's sums are written by another.
"""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from apmethod.compile import compiled, in_blocks
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term
from apmethod.message.fuse import ingredients
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import distance_2


def gather(
    terms: Sequence[Term],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    cells: SortedCells,
    row: np.ndarray,
    table: np.ndarray,
    sums: np.ndarray,
) -> None:
    """Write each agent's sums; see `apmethod.message.passes.RoundPass`."""
    images, own_radii = bool(len(cells.image)), bool(len(cells.radius))
    in_blocks(
        _compile(tuple(terms), kernel, reads, images, own_radii), len(cells.number),
        cells.runs, cells.entries, row, table, cells.longest, cells.core_radius, kernel.support,
        sums, least=200,
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
    def gather_sums(
        first, last, runs, entries, row, table, longest, core_radius, support, sums
    ):  # fmt: skip
        start, low, high = runs.start, runs.low, runs.high
        x, y, shift_x, shift_y, image, radius = entries
        near_x, near_y = np.empty(longest), np.empty(longest)
        over_x, over_y = np.empty(longest), np.empty(longest)
        near = np.empty((table.shape[0], longest))
        near_radius = np.empty(longest if own_radii else 0)
        for cell in range(first, last):
            # LpN: the runs of the surrounding sub-domains, one after the other.
            count = 0
            mine = 0
            for run in range(runs.first[cell], runs.first[cell + 1]):
                begin = low[run]
                length = high[run] - begin
                if begin <= start[cell] and start[cell] < high[run]:
                    mine = count + start[cell] - begin
                for k in range(length):
                    near_x[count + k] = x[begin + k]
                    near_y[count + k] = y[begin + k]
                if periodic:
                    for k in range(length):
                        over_x[count + k] = shift_x[begin + k]
                        over_y[count + k] = shift_y[begin + k]
                if own_radii:
                    for k in range(length):
                        near_radius[count + k] = radius[begin + k]
                for line in range(table.shape[0]):
                    for k in range(length):
                        near[line, count + k] = table[line, begin + k]
                count += length
            others = count - 1
            for i in range(start[cell], start[cell + 1]):
                if periodic and image[i]:
                    continue
                # The last candidate takes the agent's own place while it sums.
                own = mine + i - start[cell]
                near_x[own], near_y[own] = near_x[others], near_y[others]
                if periodic:
                    over_x[own], over_y[own] = over_x[others], over_y[others]
                if own_radii:
                    near_radius[own] = near_radius[others]
                for line in range(table.shape[0]):
                    near[line, own] = near[line, others]
                reach = radius[i] if own_radii else core_radius
                h = reach / support
                me = read(table, i)
                x_i, y_i = x[i], y[i]
                total = add(zero, evaluate_own(make_pair(0.0, 0.0, h), me, me), True)
                for j in range(others):
                    dx, dy = x_i - near_x[j], y_i - near_y[j]
                    if periodic:
                        dx, dy = dx - over_x[j], dy - over_y[j]
                    if own_radii:
                        reach = 0.5 * (radius[i] + near_radius[j])
                        h = reach / support
                    value = evaluate(make_pair(dx, dy, h), me, read(near, j))
                    total = add(total, value, distance_2(dx, dy) < reach * reach)
                near_x[own], near_y[own] = x_i, y_i
                if own_radii:
                    near_radius[own] = radius[i]
                if periodic:
                    over_x[own], over_y[own] = 0.0, 0.0
                for line in range(table.shape[0]):
                    near[line, own] = table[line, i]
                for part in range(width):
                    sums[row[i], part] = total[part]

    return gather_sums
