"""Scattered evaluation: each pair is computed once and both ends get their half.

This is the paper's message (2.3) compiled.  The sub-domains are divided into parts, and each
part sums into a table of its own, which goes on behind it as far as its pairs reach.  Threads
take one part after the other until none is left; then the tables are added up.

The agents behind a sub-domain in the sorted order are copied block by block into a short
table, with a column for each part of the message.  Each agent of the sub-domain runs over
that table without a branch, sums its own halves and adds the others' to their columns,
all in vector instructions (blocks are filled up to whole vectors, so that no agent is left
to scalar code); then the columns are added to the sums.
"""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from apmethod.compile import (
    LANES,
    add_lanes,
    compiled,
    copy_lanes,
    fill_lanes,
    in_blocks,
    inlined,
    keep,
    memory,
    threads,
)
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term
from apmethod.message.fuse import ingredients, mirror_evaluator, width_of
from apmethod.message.parts import APART, MOST, add_up, next_part, parts_of, write_alone
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import distance_2

#: Agents in a block: few enough for the nearest cache, enough for most sub-domains.
_BLOCK = 240


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
    run = _compile(
        tuple(terms), kernel, reads, bool(len(cells.image)), bool(len(cells.radius)), len(table)
    )
    parts = parts_of(cells)
    count = len(parts.begin)
    tables = memory.empty((width_of(terms), parts.base[-1]))
    shares = min(threads(), count)
    claimed = np.zeros(APART * shares, np.int64)
    sums = sums.T  # one layout for any number of parts, so that passes are compiled once
    in_blocks(
        run, shares, claimed, parts, cells.runs, cells.entries, row, table, cells.core_radius,
        kernel.support, tables, sums, least=1,
    )  # fmt: skip
    if count > 1:
        in_blocks(add_up, count, row, cells.image, parts, tables, sums, least=MOST // 2)


@inlined
def _run_behind(cell, run, runs, image):
    """Entries of a run around a sub-domain, from its own ones on."""
    begin = max(runs.low[run], runs.start[cell])
    end = max(runs.high[run], begin)
    # Agents come first in a sub-domain: this one has images only, which want no other images.
    if image.size and image[runs.start[cell]]:
        while begin < end and image[begin]:
            begin += 1
        while begin < end and image[end - 1]:
            end -= 1
    return begin, end


@cache
def _compile(
    terms: tuple[Term, ...],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    images: bool,
    own_radii: bool,
    lines: int,
) -> Callable:
    make_pair, read, evaluate, evaluate_own, add, zero = ingredients(terms, kernel, reads)
    mirror = mirror_evaluator(terms)
    width = len(zero)
    # Rows of a block: what the terms read, x, y, shifts of images, radii, the halves to send.
    place = lines
    shift = place + 2
    size = shift + (2 if images else 0)
    half = size + (1 if own_radii else 0)

    @inlined
    def fill(block, count, at, length, entries, table):
        for k in range(0, length, LANES):
            here, there = at + k, count + k
            copy_lanes(block[place], there, entries.x, here)
            copy_lanes(block[place + 1], there, entries.y, here)
            if images:
                copy_lanes(block[shift], there, entries.shift_x, here)
                copy_lanes(block[shift + 1], there, entries.shift_y, here)
            if own_radii:
                copy_lanes(block[size], there, entries.radius, here)
            for line in range(lines):
                copy_lanes(block[line], there, table[line], here)
            for part in range(width):
                fill_lanes(block[half + part], there, 0.0)

    @inlined
    def send(block, count, at, length, tables):
        for k in range(0, length, LANES):
            for part in range(width):
                add_lanes(tables[part], at + k, block[half + part], count + k, length - k)

    @inlined
    def sum_cell(
        cell, block, pieces, offset, runs, entries, table, core_radius, support, tables
    ):  # fmt: skip
        start, x, y, radius = runs.start, entries.x, entries.y, entries.radius
        # Its own run is the middle one, those before are south of it; or the first.
        run, last, done = runs.first[cell], runs.first[cell + 1], 0
        if not own_radii:
            run = (run + last) // 2
        reach, h = core_radius, core_radius / support
        at, end = _run_behind(cell, run, runs, entries.image)
        with_own = at == start[cell]
        while run < last:
            count, filled = 0, 0
            while run < last and count < _BLOCK:
                length = min(end - at, _BLOCK - count)
                if length:
                    fill(block, count, at, length, entries, table)
                    pieces[filled, 0], pieces[filled, 1] = at, length
                    filled += 1
                count += length
                at += length
                if at == end:
                    run += 1
                    if run < last:
                        at, end = _run_behind(cell, run, runs, entries.image)
            if count == 0:
                continue  # nobody behind
            fill_lanes(block[place], count, np.inf)  # nobody is near there
            for i in range(start[cell], start[cell + 1]):
                me, total = read(table, i), zero
                if own_radii:
                    h = radius[i] / support
                if done == 0:
                    total = add(zero, evaluate_own(make_pair(0.0, 0.0, h), me, me), True)
                behind = max(i + 1 - start[cell] - done, 0) if with_own else 0
                over_x, over_y = 0.0, 0.0
                if images:
                    over_x, over_y = entries.shift_x[i], entries.shift_y[i]
                # As a function of its own this loop is not vectorised.
                ahead, x_i, y_i = block[:, behind:], x[i], y[i]
                for j in range((count - behind + LANES - 1) // LANES * LANES):
                    dx, dy = x_i - ahead[place, j], y_i - ahead[place + 1, j]
                    if images:
                        dx = (dx + over_x) - ahead[shift, j]
                        dy = (dy + over_y) - ahead[shift + 1, j]
                    if own_radii:
                        reach = 0.5 * (radius[i] + ahead[size, j])
                        h = reach / support
                    near = distance_2(dx, dy) < reach * reach
                    pair, you = make_pair(dx, dy, h), read(ahead, j)
                    total = add(total, evaluate(pair, me, you), near)
                    back = mirror(pair, me, you)
                    for part in range(width):
                        ahead[half + part, j] += keep(near, back[part])
                for part in range(width):
                    tables[part, offset + i] += total[part]
            done += count
            count = 0
            for piece in range(filled):
                send(block, count, offset + pieces[piece, 0], pieces[piece, 1], tables)
                count += pieces[piece, 1]

    @compiled
    def scatter_sums(
        first, last, claimed, parts, runs, entries, row, table, core_radius, support, tables, sums
    ):  # fmt: skip
        cell, begin, base = parts.cell, parts.begin, parts.base
        block = np.ones((half + width, _BLOCK + 2 * LANES))
        for line in range(lines):
            block[line] = table[line, 0]  # formulas see no columns but agents'
        pieces = np.empty((_BLOCK, 2), np.int64)
        shares, count = len(claimed) // APART, len(begin)
        part = next_part(claimed, first, shares, count)
        while part < count:
            tables[:, base[part] : base[part + 1]] = 0.0
            for each in range(cell[part], cell[part + 1]):
                sum_cell(
                    each, block, pieces, base[part] - begin[part], runs, entries, table,
                    core_radius, support, tables,
                )  # fmt: skip
            write_alone(part, row, entries.image, parts, tables, sums)
            part = next_part(claimed, first, shares, count)

    return scatter_sums
