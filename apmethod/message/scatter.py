"""Scattered evaluation: each pair is computed once and both ends get their half.

This is the paper's message (2.3) compiled.  The sub-domains are divided into parts that
depend on the agents alone, and each part sums into a table of its own, which goes on behind
it as far as its pairs reach.  Threads take one part after the other until none is left.
The tables are added up in one order, so that the bits do not depend on who has filled them.

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
    claim,
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
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import distance_2
from apmethod.perceive.images import REAL

#: Agents in a block: few enough for the nearest cache, enough for most sub-domains.
_BLOCK = 240
#: Candidates in a part, below which another thread does not pay: some 0.2 ms of work.
_PART = 80_000
#: Parts at the most, a power of two: enough to keep threads equally busy, few enough that
#: their tables hardly overlap.
_PARTS = 32
#: Room for the tables of more than two parts, over that of one table for all: a few agents who
#: perceive very far let every table reach to them.
_COPIES = 3.0


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
    cell, begin, end, base = _parts(
        cells.start, cells.low, cells.high, cells.image, _PART, _PARTS, _COPIES
    )
    tables = memory.empty((width_of(terms), base[-1]))
    claimed = np.zeros(1, np.int64)
    in_blocks(
        run, min(threads(), len(begin)), claimed, cell, begin, end, base, row,
        cells.start, cells.low, cells.high, cells.image,
        cells.x, cells.y, cells.shift_x, cells.shift_y, cells.radius, table,
        cells.core_radius, kernel.support, tables, sums, least=1,
    )  # fmt: skip
    if len(begin) > 1:
        in_blocks(
            _add_up, len(begin), row, cells.image, begin, end, base, tables, sums,
            least=_PARTS // 2,
        )  # fmt: skip


@inlined(arrays=True)
def _agents_before(image):
    """How many agents, images not counted, there are before each entry."""
    agents = np.zeros(len(image) + 1, np.int64)
    for k in range(len(image)):
        agents[k + 1] = agents[k] + (image[k] == REAL)
    return agents


@inlined(arrays=True)
def _candidates(start, low, high, image):
    """How many pairs are tested from each sub-domain on."""
    agents = _agents_before(image)
    tested = np.zeros(len(start) - 1, np.int64)
    for cell in range(len(tested)):
        ahead = 0
        for run in range(low.shape[1]):
            first, last = max(low[cell, run], start[cell]), high[cell, run]
            if first < last:
                if len(image) and image[start[cell]] != REAL:  # images look at agents only
                    first, last = agents[first], agents[last]
                ahead += last - first
        tested[cell] = ahead * (start[cell + 1] - start[cell])
    return tested


@compiled
def _parts(start, low, high, image, least, most, copies):
    """Divide the sub-domains into parts of about as many candidates each.

    Args:
        start, low, high, image: see `SortedCells`.
        least: candidates in a part.
        most: parts, a power of two.
        copies: room for the tables of more than two parts, over that of one table for all.

    Returns:
        cell, the first sub-domain of each part, and behind the last one; begin and end, the
        entries that each part adds to; base, where its table begins, and the last one ends,
        with room for whole vectors behind each.
    """
    tested = _candidates(start, low, high, image)
    wanted = 1
    while wanted < most and wanted * least < tested.sum():
        wanted *= 2
    while True:
        cell, begin, end, base = _divide(wanted, tested, start, high)
        if wanted <= 2 or base[-1] <= copies * start[-1]:
            return cell, begin, end, base
        wanted //= 2


@inlined(arrays=True)
def _divide(wanted, tested, start, high):
    """The same for a number of parts, by how many pairs are tested from each sub-domain on."""
    cell, parts = np.zeros(wanted + 1, np.int64), 1
    before, share, candidates = 0, 1, tested.sum()
    for each in range(len(tested)):
        if before * wanted >= share * candidates and before and parts < wanted:
            cell[parts] = each
            parts += 1
            share = before * wanted // candidates + 1
        before += tested[each]
    cell[parts] = len(tested)
    begin, end = np.empty(parts, np.int64), np.empty(parts, np.int64)
    base, last = np.zeros(parts + 1, np.int64), 0
    for part in range(parts):
        for each in range(cell[part], cell[part + 1]):
            for run in range(high.shape[1]):
                last = max(last, high[each, run])
        begin[part], end[part] = start[cell[part]], last
        base[part + 1] = base[part] + last - begin[part] + LANES
    return cell[: parts + 1], begin, end, base


@inlined
def _write(first, last, row, image, at, tables, sums):
    """Write the sums of entries first to last, which stand in the tables from ``at`` on."""
    rows, images = row[first:last], image[first:last]
    for column in range(tables.shape[0]):
        complete, written = tables[column, at:], sums[:, column]
        for k in range(len(rows)):
            if not (images.size and images[k]):
                written[rows[k]] = complete[k]


@compiled
def _add_up(first, last, row, image, begin, end, base, tables, sums):
    """Add up the tables of entries that several parts have added to, and write their sums."""
    for part in range(max(first, 1), last):
        entry = begin[part]
        shared = min(end[part - 1], begin[part + 1] if part + 1 < len(begin) else end[part])
        other = part - 1
        while other >= 0 and end[other] > entry:
            for column in range(tables.shape[0]):
                mine = tables[column, base[part] :]
                theirs = tables[column, base[other] + entry - begin[other] :]
                for k in range(min(end[other], shared) - entry):
                    mine[k] += theirs[k]
            other -= 1
        _write(entry, shared, row, image, base[part], tables, sums)


@inlined
def _run_behind(cell, run, start, low, high, image):
    """Entries of a run from the sub-domain's own on."""
    begin = max(low[cell, run], start[cell])
    end = max(high[cell, run], begin)
    if image.size and image[start[cell]]:  # agents come first: it has none, and images want none
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
    def fill(block, count, at, length, x, y, shift_x, shift_y, radius, table):
        for k in range(0, length, LANES):
            here, there = at + k, count + k
            copy_lanes(block[place], there, x, here)
            copy_lanes(block[place + 1], there, y, here)
            if images:
                copy_lanes(block[shift], there, shift_x, here)
                copy_lanes(block[shift + 1], there, shift_y, here)
            if own_radii:
                copy_lanes(block[size], there, radius, here)
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
        cell, block, pieces, offset, start, low, high, image, x, y, shift_x, shift_y, radius,
        table, core_radius, support, tables,
    ):  # fmt: skip
        # Its own run is the middle one, those before are south of it; or the first.
        run, done = 0 if own_radii else low.shape[1] // 2, 0
        reach, h = core_radius, core_radius / support
        at, end = _run_behind(cell, run, start, low, high, image)
        with_own = at == start[cell]
        while run < low.shape[1]:
            count, filled = 0, 0
            while run < low.shape[1] and count < _BLOCK:
                length = min(end - at, _BLOCK - count)
                fill(block, count, at, length, x, y, shift_x, shift_y, radius, table)
                pieces[filled, 0], pieces[filled, 1] = at, length
                filled += 1
                count += length
                at += length
                if at == end:
                    run += 1
                    if run < low.shape[1]:
                        at, end = _run_behind(cell, run, start, low, high, image)
            if count == 0:
                continue  # images with no agent behind
            fill_lanes(block[place], count, np.inf)  # nobody is near there
            for i in range(start[cell], start[cell + 1]):
                me, total = read(table, i), zero
                if own_radii:
                    h = radius[i] / support
                if done == 0:
                    total = add(zero, evaluate_own(make_pair(0.0, 0.0, h), me, me), True)
                behind = max(i + 1 - start[cell] - done, 0) if with_own else 0
                over_x, over_y = (shift_x[i], shift_y[i]) if images else (0.0, 0.0)
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
        first, last, claimed, cell, begin, end, base, row, start, low, high, image, x, y, shift_x,
        shift_y, radius, table, core_radius, support, tables, sums,
    ):  # fmt: skip
        block = np.ones((half + width, _BLOCK + 2 * LANES))
        pieces = np.empty((low.shape[1], 2), np.int64)
        part = claim(claimed)
        while part < len(begin):
            tables[:, base[part] : base[part + 1]] = 0.0
            for each in range(cell[part], cell[part + 1]):
                sum_cell(
                    each, block, pieces, base[part] - begin[part], start, low, high, image, x, y,
                    shift_x, shift_y, radius, table, core_radius, support, tables,
                )  # fmt: skip
            # What no part before adds to is complete.
            alone = begin[part] if part == 0 else max(begin[part], end[part - 1])
            behind = begin[part + 1] if part + 1 < len(begin) else end[part]
            _write(alone, behind, row, image, base[part] + alone - begin[part], tables, sums)
            part = claim(claimed)

    return scatter_sums
