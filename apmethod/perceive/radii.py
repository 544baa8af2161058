"""Agents with core radii of their own, sorted into one lattice for each size of radius.

Two agents are neighbours if they are closer than the mean of their radii.  A lattice as
coarse as the largest radius would have the agents of a crowd, whose radii are small, test
everybody around (paper 2.4.4 takes that price).  Here the agents are divided into classes
whose radii differ by a factor of 1.7 at most, each with a quad-lattice of its own, and
a sub-domain looks into the lattice of each class as far as that class can be perceived.
"""

from __future__ import annotations

import numpy as np

from apmethod.compile import compiled, in_blocks, inlined
from apmethod.perceive.cells import SortedCells, grid_of
from apmethod.perceive.domain import Domain
from apmethod.perceive.images import with_images
from apmethod.perceive.sorting import in_order, sort_numbers

#: Radii of a class differ by this factor at most, but for the last class, which has the rest.
#: Measured: smaller ones look into too many lattices, larger ones at too many agents.
_RATIO = 1.7
_CLASSES = 24


def sort_by_radius(
    positions: np.ndarray, radii: np.ndarray, level: int, domain: Domain
) -> SortedCells:
    """Sort agents, positions of shape (n, 2) and radii of shape (n,), into sub-domains.

    Sub-domains of a class are numbered together, those of larger radii first; their sides
    are the largest radius of the class / 2^level.
    """
    largest = float(radii.max())
    entries = with_images(positions, largest, domain)
    where = entries.places
    radius = radii[entries.row] if domain.makes_images else radii
    # One class has the middle radius in its middle, and with it most agents of a crowd.
    kind = np.round(np.log(np.median(radius) / radius) / np.log(_RATIO)).astype(np.int64)
    kind = np.minimum(kind - kind.min(), _CLASSES - 1)
    widest, lowest, highest = np.zeros(_CLASSES), np.empty((_CLASSES, 2)), np.empty((_CLASSES, 2))
    _measure(where, radius, kind, widest, lowest, highest)
    side, grid = np.ones(_CLASSES), np.zeros((_CLASSES, 2), np.int64)
    for each in np.flatnonzero(widest):
        extent = tuple(highest[each] - lowest[each])
        side[each], grid[each] = grid_of(extent, float(widest[each]), level)
    # Lines of all classes, one after the other: few enough to be tabled, as their
    # sub-domains, most of them empty, may not be.
    first_line = np.concatenate([[0], np.cumsum(grid[:, 1])])
    column, line = np.empty(len(where), np.int64), np.empty(len(where), np.int64)
    in_blocks(_number, len(where), where, kind, lowest, side, grid, first_line, column, line)
    order = sort_numbers(column, grid[:, 0].max())[0]
    order = order[sort_numbers(line[order], first_line[-1])[0]]
    column, line = column[order], line[order]
    new = (np.diff(line, prepend=-1) != 0) | (np.diff(column, prepend=-1) != 0)
    start = np.append(np.flatnonzero(new), len(where))
    column, line = column[new], line[new]
    cells_before = np.concatenate([[0], np.cumsum(np.bincount(line, minlength=first_line[-1]))])
    lattices = (widest, lowest, side, grid, first_line, cells_before)
    low, high = _runs(where[order], radius[order], start, column, lattices)
    return SortedCells(
        core_radius=largest, level=level, side=float(side[0]), origin=tuple(lowest[0]),
        grid=tuple(grid[0].tolist()), number=line * grid[:, 0].max() + column,
        start=start, low=low, high=high, radius=radius[order],
        **in_order(order, positions, entries),
    )  # fmt: skip


def _runs(where, radius, start, column, lattices) -> tuple[np.ndarray, np.ndarray]:
    """Begin and end of the runs of agents to look at, those that hold nobody left out."""
    arguments = (where, radius, start, column, *lattices)
    count = np.zeros(len(column), np.int64)
    none = np.empty((0, 0), np.int64)
    in_blocks(_find_runs, len(column), *arguments, count, none, none, least=1000)
    low = np.zeros((len(column), count.max(initial=1)), np.int64)
    high = np.zeros_like(low)
    in_blocks(_find_runs, len(column), *arguments, count, low, high, least=1000)
    return low, high


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
        east = int((where[k, 0] - lowest[each, 0]) / side[each])
        north = int((where[k, 1] - lowest[each, 1]) / side[each])
        column[k] = min(east, grid[each, 0] - 1)
        line[k] = first_line[each] + min(north, grid[each, 1] - 1)


@inlined
def _span(low, high, lowest, side, count):
    """First and last sub-domain, and one more, that an interval along an axis touches."""
    left, right = (low - lowest) / side, (high - lowest) / side
    if right < 0.0 or left >= count:
        return 0, 0
    return int(max(left, 0.0)), min(int(right), count - 1) + 1


@inlined
def _first_from(wanted, column, low, high):
    """The first of the sub-domains low to high, of one line, that is not west of a column."""
    while low < high:
        middle = (low + high) // 2
        if column[middle] < wanted:
            low = middle + 1
        else:
            high = middle
    return low


@compiled
def _find_runs(
    first, last, where, radius, start, column, widest, lowest, side, grid, first_line,
    cells_before, count, low, high,
):  # fmt: skip
    """Count the runs around each sub-domain, or list them where there is room."""
    for cell in range(first, last):
        own = 0.0
        west, south, east, north = np.inf, np.inf, -np.inf, -np.inf
        for k in range(start[cell], start[cell + 1]):
            own = max(own, radius[k])
            west, east = min(west, where[k, 0]), max(east, where[k, 0])
            south, north = min(south, where[k, 1]), max(north, where[k, 1])
        found = 0
        for each in range(widest.size):
            if widest[each] == 0.0:
                continue
            # Where a row begins is rounded; the slack keeps an agent at its very edge.
            slack = 1e-9 * side[each]
            reach = 0.5 * (own + widest[each]) * (1.0 + 1e-9) + slack
            bottom, top = _span(
                south - reach, north + reach, lowest[each, 1], side[each], grid[each, 1]
            )
            for line in range(bottom, top):
                begin = cells_before[first_line[each] + line]
                end = cells_before[first_line[each] + line + 1]
                if begin == end:
                    continue
                edge = lowest[each, 1] + line * side[each]
                gap = max(edge - north, south - (edge + side[each])) - slack
                half = reach
                if gap > 0.0:
                    half = np.sqrt(max(reach * reach - gap * gap, 0.0))
                left, right = _span(
                    west - half, east + half, lowest[each, 0], side[each], grid[each, 0]
                )
                one = start[_first_from(left, column, begin, end)]
                two = start[_first_from(right, column, begin, end)]
                if one < two:
                    if low.size:
                        low[cell, found], high[cell, found] = one, two
                    found += 1
        count[cell] = found
