"""Agents with core radii of their own, sorted into one lattice for each size of radius.

Two agents are neighbours if they are closer than the mean of their radii.  A lattice as
coarse as the largest radius would have the agents of a crowd, whose radii are small, test
everybody around (paper 2.4.4 takes that price).  Here the agents are divided into classes
whose radii differ by a factor of 1.7 at most, each with a quad-lattice of its own, and
a sub-domain looks into the lattice of each class as far as that class can be perceived.

The lines of all lattices are put in one order from south to north, so that agents who may
be neighbours are not far from each other in it, whatever their classes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from apmethod.compile import compiled, in_blocks, inlined, memory
from apmethod.perceive.cells import SortedCells, few_enough, grid_of, rounding
from apmethod.perceive.domain import Domain
from apmethod.perceive.images import with_images
from apmethod.perceive.sorting import in_order, room_for, sort_numbers, take

#: Radii of a class differ by this factor at most, but for the last class, which has the rest.
#: Measured: smaller ones look into too many lattices, larger ones at too many agents.
_RATIO = 1.7
_CLASSES = 24
#: Radii from which the middle one is taken.
_SAMPLE = 2_000


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


def sort_by_radius(
    positions: np.ndarray, radii: np.ndarray, level: int, domain: Domain
) -> SortedCells:
    """Sort agents, positions of shape (n, 2) and radii of shape (n,), into sub-domains.

    The sides of a class's sub-domains are its largest radius / 2^level.  The first run
    around each sub-domain is the one that it lies in itself.
    """
    largest = float(radii.max())
    entries = with_images(positions, largest, domain)
    where = entries.places
    radius = radii[entries.row] if domain.makes_images else np.ascontiguousarray(radii)
    kind = np.empty(len(where), np.int64)
    in_blocks(_classify, len(where), radius, _edges(radius), kind)
    widest, lowest, highest = np.zeros(_CLASSES), np.empty((_CLASSES, 2)), np.empty((_CLASSES, 2))
    _measure(where, radius, kind, widest, lowest, highest)
    side, grid = np.ones(_CLASSES), np.zeros((_CLASSES, 2), np.int64)
    for each in np.flatnonzero(widest):
        extent = tuple(highest[each] - lowest[each])
        side[each], grid[each] = grid_of(extent, float(widest[each]), level)
    column, line = np.empty((2, len(where)), np.int64)
    first_line = np.concatenate([[0], np.cumsum(grid[:, 1])])
    in_blocks(_number, len(where), where, kind, lowest, side, grid, first_line, column, line)
    # Lines of all classes in a row, and where each of them comes from south to north.
    known, line = _tabled(line, first_line[-1])
    first = np.searchsorted(known, first_line)
    owner = np.repeat(np.arange(_CLASSES), np.diff(first))
    known = known - first_line[owner]
    rank = np.empty(len(known), np.int64)
    rank[np.argsort(lowest[owner, 1] + known * side[owner], kind="stable")] = np.arange(len(known))
    line = rank[line]
    columns, short = _tabled(column, int(grid[:, 0].max()))
    order = sort_numbers(short, len(columns))[0]
    order = order[sort_numbers(line[order], len(known))[0]]
    start, kind, column, line = _occupied(order, kind, column, line)
    begin = np.concatenate([[0], np.cumsum(np.bincount(line, minlength=len(known)))])
    lattices = Lattices(widest, lowest, side, grid, first, known, rank, begin)
    (sorted_radius,) = room_for(1, len(order))
    in_blocks(take, len(order), order, radius, sorted_radius)
    placed = in_order(order, positions, entries)
    low, high = _runs(placed, sorted_radius, start, kind, column, line, lattices)
    return SortedCells(
        core_radius=largest, level=level, side=float(side[0]), origin=tuple(lowest[0]),
        grid=tuple(grid[0].tolist()), number=line * int(grid[:, 0].max()) + column,
        start=start, low=low, high=high, radius=sorted_radius, **placed,
    )  # fmt: skip


def _edges(radius: np.ndarray) -> np.ndarray:
    """The radii at which one class ends and the next begins, from the largest on."""
    # One class has the middle radius in its middle, and with it most agents of a crowd.
    middle = np.median(radius[:: max(1, len(radius) // _SAMPLE)])
    first = round(np.log(middle / radius.max()) / np.log(_RATIO))
    return middle * _RATIO ** -(first + 0.5 + np.arange(_CLASSES - 1))


def _tabled(numbers: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers below ``count`` to number again: all of them, or, if too many, those that occur.

    Returns:
        them, ascending; and for each of ``numbers`` its place among them.
    """
    if few_enough(count, len(numbers)):
        return np.arange(count), numbers
    return np.unique(numbers, return_inverse=True)


def _runs(
    placed: dict[str, np.ndarray], radius: np.ndarray, start: np.ndarray, *arguments
) -> tuple[np.ndarray, np.ndarray]:
    """Begin and end of the runs of agents to look at, those that hold nobody left out."""
    x, y, over_x, over_y = (placed[name] for name in ("x", "y", "shift_x", "shift_y"))
    arguments = (x, y, over_x, over_y, radius, start, *arguments[:-1], *arguments[-1])
    cells, none = len(start) - 1, np.empty((0, 0), np.int64)
    count = np.zeros(cells, np.int64)
    in_blocks(_find_runs, cells, *arguments, count, none, none, least=1000)
    runs = memory.empty((2, cells, count.max(initial=1)), np.int64)
    in_blocks(_find_runs, cells, *arguments, count, *runs, least=1000)
    found = memory.empty((2, cells, count.max(initial=1)), np.int64)
    found[:] = runs[:, :, : found.shape[2]]
    return found[0], found[1]


@compiled
def _classify(first, last, radius, edges, kind):
    """The class of each radius: how many of the edges, descending, it is below."""
    for k in range(first, last):
        below = 0
        while below < len(edges) and radius[k] < edges[below]:
            below += 1
        kind[k] = below


@compiled
def _measure(where, radius, kind, widest, lowest, highest):
    """The largest radius and the corners of each class."""
    lowest[:], highest[:] = np.inf, -np.inf
    for k in range(where.shape[0]):
        each = kind[k]
        widest[each] = max(widest[each], radius[k])
        for axis in range(2):
            lowest[each, axis] = min(lowest[each, axis], where[k, axis])
            highest[each, axis] = max(highest[each, axis], where[k, axis])


@compiled
def _number(first, last, where, kind, lowest, side, grid, first_line, column, line):
    """Column and line of each place in the lattice of its class."""
    for k in range(first, last):
        each = kind[k]
        a_length = 1.0 / side[each]
        east = int((where[k, 0] - lowest[each, 0]) * a_length)
        north = int((where[k, 1] - lowest[each, 1]) * a_length)
        column[k] = min(east, grid[each, 0] - 1)
        line[k] = first_line[each] + min(north, grid[each, 1] - 1)


@compiled
def _occupied(order, kind, column, line):
    """Where each occupied sub-domain begins, and the last one ends, and which one it is."""
    cells, column_before, line_before = 0, -1, -1
    start = np.empty(len(order) + 1, np.int64)
    for k in range(len(order)):
        agent = order[k]
        if column[agent] != column_before or line[agent] != line_before:
            column_before, line_before = column[agent], line[agent]
            start[cells] = k
            cells += 1
    start[cells] = len(order)
    first = order[start[:cells]]
    return start[: cells + 1], kind[first], column[first], line[first]


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
    first, last, x, y, shift_x, shift_y, radius, start, kind, column, own_line, widest, lowest,
    side, grid, first_known, known, rank, begin, count, low, high,
):  # fmt: skip
    """Count the runs around each sub-domain, or rather more, or list them where there is room."""
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
            lines = first_known[each], first_known[each + 1]
            for k in range(_first_from(bottom, known, *lines), _first_from(top, known, *lines)):
                one, two = begin[rank[k]], begin[rank[k] + 1]
                if one == two:
                    continue
                mine = each == kind[cell] and rank[k] == own_line[cell]
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
                    low[cell, 0], high[cell, 0] = start[one], start[two]
                elif one < two:
                    low[cell, found], high[cell, found] = start[one], start[two]
                    found += 1
        count[cell] = found
        if low.size:
            low[cell, found:], high[cell, found:] = 0, 0
