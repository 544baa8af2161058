"""Bands of sub-domains, in which all potential neighbours of an agent follow each other.

The band of a line of sub-domains is that line with those within reach of it, all their
agents in one order from west to east: what is around a sub-domain is one slice of it.
"""

from __future__ import annotations

import numpy as np

from apmethod.compile import compiled
from apmethod.perceive.cells import SortedCells

Slices = tuple[np.ndarray, np.ndarray, np.ndarray]


def slices_around(cells: SortedCells, chosen: np.ndarray) -> Slices:
    """What is around each occupied sub-domain, as slices of one array.

    Args:
        chosen: the entries of ``cells`` that count, ascending.

    Returns:
        order, places in ``chosen``, each as often as it needs be; begin and end, (cells,):
        around sub-domain k are chosen[order[begin[k]:end[k]]].
    """
    if len(cells.radius):
        return _runs_in_line(cells, chosen)
    line, column = np.divmod(cells.number, cells.grid[0])
    order = np.empty((2 * 2**cells.level + 1) * len(chosen), np.int64)
    begin, end = np.empty(len(line), np.int64), np.empty(len(line), np.int64)
    start = np.searchsorted(chosen, cells.start)
    _merge(line, column, start, 2**cells.level, order, begin, end)
    return order[: end.max(initial=0)], begin, end


@compiled
def places_of_own(order, begin, end, start):
    """Where in the slice around its sub-domain each entry itself stands.

    ``start`` is where the entries of each sub-domain begin, and the last ones end.
    """
    own = np.empty(start[-1], np.int64)
    for cell in range(len(begin)):
        around = order[begin[cell] : end[cell]]
        for k in range(len(around)):
            if start[cell] <= around[k] < start[cell + 1]:
                own[around[k]] = k
    return own


def _runs_in_line(cells: SortedCells, chosen: np.ndarray) -> Slices:
    """The runs around each one after the other: several lattices have no common lines."""
    length = cells.high - cells.low
    after = np.cumsum(length)
    order = np.arange(length.sum()) + np.repeat(cells.low - (after - length), length)
    place = np.full(len(cells.row), -1)
    place[chosen] = np.arange(len(chosen))
    order = place[order]
    kept = order >= 0
    ends = np.append(0, after)[cells.first]
    ends = np.append(0, np.cumsum(kept))[ends]
    return order[kept], ends[:-1], ends[1:]


@compiled
def _merge(line, column, start, reach, order, begin, end):
    """Write the bands of all lines one after the other, and where each slice is in them."""
    cells, count = len(line), 0
    lines = 2 * reach + 1
    following, last = np.empty(lines, np.int64), np.empty(lines, np.int64)
    first = 0
    while first < cells:
        middle = line[first]
        for k in range(lines):
            following[k] = np.searchsorted(line, middle - reach + k)
            last[k] = np.searchsorted(line, middle - reach + k + 1)
        opened = closed = first
        while True:
            west = -1
            for k in range(lines):
                if following[k] < last[k]:
                    here = column[following[k]]
                    west = here if west < 0 else min(west, here)
            if west < 0:
                break
            # The slices that begin with this column, or have ended before it.
            while opened < last[reach] and column[opened] - reach <= west:
                begin[opened] = count
                opened += 1
            while closed < last[reach] and column[closed] + reach < west:
                end[closed] = count
                closed += 1
            for k in range(lines):
                cell = following[k]
                if cell < last[k] and column[cell] == west:
                    for entry in range(start[cell], start[cell + 1]):
                        order[count] = entry
                        count += 1
                    following[k] += 1
        end[closed : last[reach]] = count
        first = last[reach]
