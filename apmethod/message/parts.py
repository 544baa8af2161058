"""Parts that a scattered round is divided into, each with a table of its own for its sums.

They depend on the agents alone, and their tables are added up in one order, so that the bits
do not depend on which thread has filled which of them.
"""

from typing import NamedTuple

import numpy as np

from apmethod.compile import LANES, claim, compiled, inlined
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.images import REAL

#: Numbers in what one processor takes away from another when it writes to them.
APART = 16
#: Candidates in a part, below which another thread does not pay: some 0.2 ms of work.
_LEAST = 80_000
#: Parts at the most, a power of two: enough to keep threads equally busy, few enough that
#: their tables hardly overlap.
MOST = 32
#: Room for the tables of more than two parts, over that of one table for all: a few agents who
#: perceive very far let every table reach to them.
_COPIES = 3.0


class Parts(NamedTuple):
    """Runs of sub-domains of about as many candidates each.

    Attributes:
        cell: the first sub-domain of each part, and behind the last one, (parts + 1,).
        begin, end: the entries that each part adds to, (parts,).
        base: where its table begins, and the last one ends, with room for whole vectors
            behind each, (parts + 1,).
    """

    cell: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    base: np.ndarray


def parts_of(cells: SortedCells) -> Parts:
    """The parts of a scattered round over all agents."""
    return Parts(*_divide(cells.runs, cells.image, _LEAST, MOST, _COPIES))


@inlined
def next_part(claimed, share, shares, parts):
    """The next part for a thread whose share of the parts this is; one too many if none is left.

    It takes its own parts first, which are next to each other and were its own in the round
    before: what a processor has in its caches is there.  Then it helps with other shares.

    Args:
        claimed: how many parts of each share are taken, ``APART`` numbers from each other.
        share, shares: which one, and of how many.
        parts: how many parts there are.
    """
    for turn in range(shares):
        other = (share + turn) % shares
        first, last = parts * other // shares, parts * (other + 1) // shares
        part = first + claim(claimed, APART * other)
        if part < last:
            return part
    return parts


@inlined(arrays=True)
def _agents_before(image):
    """How many agents, images not counted, there are before each entry."""
    agents = np.zeros(len(image) + 1, np.int64)
    for k in range(len(image)):
        agents[k + 1] = agents[k] + (image[k] == REAL)
    return agents


@inlined(arrays=True)
def _candidates(runs, image):
    """How many pairs are tested from each sub-domain on."""
    start, agents = runs.start, _agents_before(image)
    tested = np.zeros(len(start) - 1, np.int64)
    for cell in range(len(tested)):
        ahead = 0
        for run in range(runs.first[cell], runs.first[cell + 1]):
            first, last = max(runs.low[run], start[cell]), runs.high[run]
            if first < last:
                if len(image) and image[start[cell]] != REAL:  # images look at agents only
                    first, last = agents[first], agents[last]
                ahead += last - first
        tested[cell] = ahead * (start[cell + 1] - start[cell])
    return tested


@compiled
def _divide(runs, image, least, most, copies):
    """As many parts as have ``least`` candidates each, and room for their tables."""
    tested = _candidates(runs, image)
    wanted = 1
    while wanted < most and wanted * least < tested.sum():
        wanted *= 2
    while True:
        cell, begin, end, base = _divide_in(wanted, tested, runs)
        if wanted <= 2 or base[-1] <= copies * runs.start[-1]:
            return cell, begin, end, base
        wanted //= 2


@inlined(arrays=True)
def _divide_in(wanted, tested, runs):
    """So many parts, by how many pairs are tested from each sub-domain on."""
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
        for run in range(runs.first[cell[part]], runs.first[cell[part + 1]]):
            last = max(last, runs.high[run])
        begin[part], end[part] = runs.start[cell[part]], last
        base[part + 1] = base[part] + last - begin[part] + LANES
    return cell[: parts + 1], begin, end, base


@inlined
def _write(first, last, row, image, at, tables, sums):
    """Write the sums of entries first to last, which stand in the tables from ``at`` on."""
    rows, images = row[first:last], image[first:last]
    for column in range(tables.shape[0]):
        complete, written = tables[column, at:], sums[column]
        for k in range(len(rows)):
            if not (images.size and images[k]):
                written[rows[k]] = complete[k]


@inlined
def write_alone(part, row, image, parts, tables, sums):
    """Write the sums of a part's own entries that no part before it adds to."""
    begin, end, base = parts.begin, parts.end, parts.base
    first = begin[part] if part == 0 else max(begin[part], end[part - 1])
    last = begin[part + 1] if part + 1 < len(begin) else end[part]
    _write(first, last, row, image, base[part] + first - begin[part], tables, sums)


@compiled
def add_up(first, last, row, image, parts, tables, sums):
    """Add up the tables of entries that several parts have added to, and write their sums."""
    begin, end, base = parts.begin, parts.end, parts.base
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
