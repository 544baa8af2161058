"""What agents with core radii of their own may perceive: runs in the lattice of each class."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from apmethod.compile import compiled, in_blocks, inlined, memory
from apmethod.perceive.cells import rounding


class Lattices(NamedTuple):
    """The lattice of each class, and the lines of all of them that may hold anybody.

    Attributes:
        widest: largest radius of each class, 0 where nobody is in it, (classes,).
        lowest: south-west corner of each lattice, (classes, 2).
        side: of its sub-domains, (classes,).
        grid: how many of them there are along x and y, (classes, 2).
        first: where the lines of each class begin in the following, (classes + 1,).
        line: number of each line in its lattice, ascending in each class, (lines,).
        rank: its place in the order of all lines from south to north, (lines,).
        begin: by rank, where the occupied sub-domains of a line begin, (lines + 1,).
    """

    widest: np.ndarray
    lowest: np.ndarray
    side: np.ndarray
    grid: np.ndarray
    first: np.ndarray
    line: np.ndarray
    rank: np.ndarray
    begin: np.ndarray


def runs_in_reach(
    placed: dict[str, np.ndarray],
    start: np.ndarray,
    column: np.ndarray,
    line: np.ndarray,
    lattices: Lattices,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The runs of agents around each sub-domain, those that hold nobody left out.

    Args:
        placed: the sorted entries, see `SortedCells`.
        start: where each occupied sub-domain begins, and the last one ends.
        column, line: of each occupied sub-domain, the line by its rank.
        lattices: see there.

    Returns:
        first, low and high of `SortedCells`.
    """
    columns = (placed[name] for name in ("x", "y", "shift_x", "shift_y", "radius"))
    arguments = (*columns, start, column, line, lattices)
    cells, nowhere = len(column), np.empty(0, np.int64)
    count, place = np.zeros(cells, np.int64), np.zeros(cells + 1, np.int64)
    in_blocks(_find_runs, cells, *arguments, place, count, nowhere, nowhere, least=1000)
    np.cumsum(count, out=place[1:])
    low, high = memory.empty((2, int(place[-1])), np.int64)
    in_blocks(_find_runs, cells, *arguments, place, count, low, high, least=1000)
    first = _move_up(place, count, low, high)
    return first, low[: first[-1]], high[: first[-1]]


@inlined
def _span(low, high, lowest, a_length, count):
    """First and last sub-domain, and one more, that an interval along an axis touches."""
    left, right = (low - lowest) * a_length, (high - lowest) * a_length
    if right < 0.0 or left >= count:
        return 0, 0
    return int(max(left, 0.0)), min(int(right), count - 1) + 1


@inlined
def _first_from(wanted, numbers, low, high):
    """The first of numbers[low:high], ascending, none twice, that is not below ``wanted``."""
    if low == high:
        return low
    # Where no number is left out, these two are the same.
    low, high = (
        max(low, high - 1 - max(numbers[high - 1] - wanted, -1)),
        min(high, low + max(wanted - numbers[low], 0)),
    )
    while low < high:
        middle = (low + high) // 2
        if numbers[middle] < wanted:
            low = middle + 1
        else:
            high = middle
    return low


@compiled
def _find_runs(
    first, last, x, y, shift_x, shift_y, radius, start, column, own_line, lattices, place, count,
    low, high,
):  # fmt: skip
    """Count the runs around each sub-domain, or rather more, or list them where there is room.

    Those of sub-domain k are written from place[k] on.
    """
    widest, side, grid = lattices.widest, lattices.side, lattices.grid
    lowest, known, rank, begin = lattices.lowest, lattices.line, lattices.rank, lattices.begin
    for cell in range(first, last):
        own = 0.0
        west, south, east, north = np.inf, np.inf, -np.inf, -np.inf
        for k in range(start[cell], start[cell + 1]):
            over_x, over_y = (shift_x[k], shift_y[k]) if shift_x.size else (0.0, 0.0)
            own = max(own, radius[k])
            west, east = min(west, x[k] + over_x), max(east, x[k] + over_x)
            south, north = min(south, y[k] + over_y), max(north, y[k] + over_y)
        found = 1  # the first is its own
        for each in range(widest.size):
            if widest[each] == 0.0:
                continue
            # Where a line begins is rounded; the slack keeps an agent at its very edge.
            slack = rounding(max(grid[each, 0], grid[each, 1])) * side[each]
            reach = 0.5 * (own + widest[each]) * (1.0 + 1e-9) + slack
            a_length = 1.0 / side[each]  # as agents are numbered
            bottom, top = _span(
                south - reach, north + reach, lowest[each, 1], a_length, grid[each, 1]
            )
            lines = lattices.first[each], lattices.first[each + 1]
            for k in range(_first_from(bottom, known, *lines), _first_from(top, known, *lines)):
                one, two = begin[rank[k]], begin[rank[k] + 1]
                if one == two:
                    continue
                mine = rank[k] == own_line[cell]
                if not low.size:
                    found += not mine
                    continue
                edge = lowest[each, 1] + known[k] * side[each]
                gap = max(edge - north, south - (edge + side[each])) - slack
                half = reach
                if gap > 0.0:
                    half = np.sqrt(max(reach * reach - gap * gap, 0.0))
                left, right = _span(
                    west - half, east + half, lowest[each, 0], a_length, grid[each, 0]
                )
                one = _first_from(left, column, one, two)
                two = _first_from(right, column, one, two)
                if mine:
                    low[place[cell]], high[place[cell]] = start[one], start[two]
                elif one < two:
                    at = place[cell] + found
                    low[at], high[at] = start[one], start[two]
                    found += 1
        count[cell] = found


@compiled
def _move_up(place, count, low, high):
    """Let the runs of each sub-domain follow those of the one before; where they begin then."""
    first = np.zeros(len(count) + 1, np.int64)
    for cell in range(len(count)):
        for run in range(count[cell]):
            low[first[cell] + run] = low[place[cell] + run]
            high[first[cell] + run] = high[place[cell] + run]
        first[cell + 1] = first[cell] + count[cell]
    return first
