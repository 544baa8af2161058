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

import numpy as np

from apmethod.compile import compiled, in_blocks
from apmethod.perceive.cells import SortedCells, few_enough, grid_of
from apmethod.perceive.domain import Domain
from apmethod.perceive.images import with_images
from apmethod.perceive.reach import Lattices, runs_in_reach
from apmethod.perceive.sorting import in_order, room_for, sort_numbers, take

#: Radii of a class differ by this factor at most, but for the last class, which has the rest.
#: Measured: smaller ones look into too many lattices, larger ones at too many agents.
_RATIO = 1.7
_CLASSES = 24
#: Radii from which the middle one is taken.
_SAMPLE = 2_000


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
    columns = int(grid[:, 0].max())
    order = _order(column, columns)
    order = order[sort_numbers(line[order], len(known))[0]]
    start, column, line = _occupied(order, column, line)
    begin = np.concatenate([[0], np.cumsum(np.bincount(line, minlength=len(known)))])
    lattices = Lattices(widest, lowest, side, grid, first, known, rank, begin)
    (sorted_radius,) = room_for(1, len(order))
    in_blocks(take, len(order), order, radius, sorted_radius)
    placed = in_order(order, positions, entries) | {"radius": sorted_radius}
    first, low, high = runs_in_reach(placed, start, column, line, lattices)
    return SortedCells(
        core_radius=largest, level=level, side=float(side[0]), origin=tuple(lowest[0]),
        grid=tuple(grid[0].tolist()), number=line * columns + column,
        start=start, first=first, low=low, high=high, **placed,
    )  # fmt: skip


def _edges(radius: np.ndarray) -> np.ndarray:
    """The radii at which one class ends and the next begins, from the largest on."""
    # One class has the middle radius in its middle, and with it most agents of a crowd.
    middle = np.median(radius[:: max(1, len(radius) // _SAMPLE)])
    first = round(np.log(middle / radius.max()) / np.log(_RATIO))
    return middle * _RATIO ** -(first + 0.5 + np.arange(_CLASSES - 1))


def _order(column: np.ndarray, columns: int) -> np.ndarray:
    """The entries from west to east."""
    if few_enough(columns, len(column)):
        return sort_numbers(column, columns)[0]
    return np.argsort(column, kind="stable")


def _tabled(numbers: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers below ``count`` to number again: all of them, or, if too many, those that occur.

    Returns:
        them, ascending; and for each of ``numbers`` its place among them.
    """
    if few_enough(count, len(numbers)):
        return np.arange(count), numbers
    return np.unique(numbers, return_inverse=True)


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
def _occupied(order, column, line):
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
    return start[: cells + 1], column[first], line[first]
