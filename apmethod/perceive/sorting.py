"""Compiled passes that sort agents into sub-domains and find the runs around each.

The counting sort is stable and runs on several threads: each counts and places a block of
agents of its own, and the blocks follow each other inside every sub-domain, so the order
is the same for any number of threads.
"""

from __future__ import annotations

import numpy as np

from apmethod.compile import LANES, WORTH, compiled, in_blocks, memory, threads
from apmethod.perceive.images import Entries

#: Coordinates that are compared side by side, x and y in turn.
_WIDE = 256


def counting_sort(
    places: np.ndarray, lowest: tuple[float, float], side: float, grid: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Order of places, of shape (n, 2), by the number of their sub-domain.

    Returns:
        order, of shape (n,): sub-domain k holds order[begin[k]:begin[k + 1]];
        begin, of shape (sub-domains + 1,).
    """
    blocks = max(1, min(threads(), len(places) // WORTH))
    edges = np.array([len(places) * block // blocks for block in range(blocks + 1)])
    number = memory.empty(len(places), np.int64)
    tally = memory.zeros((blocks, grid[0] * grid[1]), np.int64)
    in_blocks(_number_and_count, blocks, edges, places, lowest, side, grid, number, tally, least=1)
    begin = memory.empty(grid[0] * grid[1] + 1, np.int64)
    _accumulate(tally, begin)
    order = memory.empty(len(places), np.int64)
    in_blocks(_put_in_order, blocks, edges, number, tally, order, least=1)
    return order, begin


def sort_numbers(number: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The same for entries whose sub-domains, ``count`` in all, are numbered already."""
    edges, tally = np.array([0, len(number)]), np.zeros((1, count), np.int64)
    tally[0] = np.bincount(number, minlength=count)
    begin, order = np.empty(count + 1, np.int64), memory.empty(len(number), np.int64)
    _accumulate(tally, begin)
    _put_in_order(0, 1, edges, number, tally, order)
    return order, begin


def room_for(columns: int, count: int) -> np.ndarray:
    """Columns of so many entries, with memory behind each that whole vectors may look at."""
    return memory.empty((columns, count + LANES))[:, :count]


def runs_around(
    number: np.ndarray, grid: tuple[int, int], reach: int, begin: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Begin and end of the run of agents in each row of the square around sub-domains.

    Args:
        number: of the sub-domains to look around, ascending, of shape (cells,).
        grid: number of sub-domains along x and y.
        reach: how many sub-domains to look in each direction.
        begin: where each sub-domain of the grid begins in the order.

    Returns:
        low and high, of shape (cells, 2*reach + 1).
    """
    low = memory.empty((len(number), 2 * reach + 1), np.int64)
    high = memory.empty(low.shape, np.int64)
    in_blocks(_find_runs, len(number), number, grid, reach, begin, low, high, least=5_000)
    return low, high


@compiled
def corners(places):
    """Smallest and largest x and y of places, of shape (n, 2): (x, y), (x, y)."""
    # Side by side: in one minimum over all, each would have to wait for the one before.
    smallest, largest = np.full(_WIDE, np.inf), np.full(_WIDE, -np.inf)
    numbers = places.reshape(places.size)
    for first in range(0, len(numbers), _WIDE):
        some = numbers[first : first + _WIDE]
        for k in range(len(some)):
            smallest[k], largest[k] = min(smallest[k], some[k]), max(largest[k], some[k])
    west, south = smallest[0::2].min(), smallest[1::2].min()
    return (west, south), (largest[0::2].max(), largest[1::2].max())


@compiled
def longest_of(first, low, high):
    """The largest number of entries in the runs around one sub-domain."""
    longest = 0
    for cell in range(len(first) - 1):
        entries = 0
        for run in range(first[cell], first[cell + 1]):
            entries += high[run] - low[run]
        longest = max(longest, entries)
    return longest


@compiled
def sharing_a_cell(start):
    """In how large a company entries are in their sub-domain, on average."""
    company = 0
    for cell in range(len(start) - 1):
        company += (start[cell + 1] - start[cell]) ** 2
    return company / start[-1]


@compiled
def _number_and_count(first, last, edges, places, lowest, side, grid, number, tally):
    a_length = 1.0 / side
    for block in range(first, last):
        # From zero on: numbers that might be negative ones would be tested for that.
        here, numbers = (
            places[edges[block] : edges[block + 1]],
            number[edges[block] : edges[block + 1]],
        )
        for k in range(len(numbers)):
            column = min(int((here[k, 0] - lowest[0]) * a_length), grid[0] - 1)
            line = min(int((here[k, 1] - lowest[1]) * a_length), grid[1] - 1)
            numbers[k] = line * grid[0] + column
        for cell in numbers:
            tally[block, cell] += 1


@compiled
def _accumulate(tally, begin):
    """Turn counts by block and sub-domain into where each block begins in each."""
    total = 0
    for k in range(tally.shape[1]):
        begin[k] = total
        for block in range(tally.shape[0]):
            count = tally[block, k]
            tally[block, k] = total
            total += count
    begin[tally.shape[1]] = total


@compiled
def _put_in_order(first, last, edges, number, tally, order):
    for block in range(first, last):
        for k in range(edges[block], edges[block + 1]):
            order[tally[block, number[k]]] = k
            tally[block, number[k]] += 1


@compiled
def _find_runs(first, last, number, grid, reach, begin, low, high):
    line = number[first] // grid[0] if first < last else 0
    for cell in range(first, last):
        while number[cell] >= (line + 1) * grid[0]:
            line += 1
        column = number[cell] - line * grid[0]
        west, east = max(column - reach, 0), min(column + reach, grid[0] - 1)
        for run in range(low.shape[1]):
            row = line - reach + run
            if row >= 0 and row < grid[1]:
                low[cell, run] = begin[row * grid[0] + west]
                high[cell, run] = begin[row * grid[0] + east + 1]
            else:
                low[cell, run], high[cell, run] = 0, 0


@compiled
def occupied(begin):
    """Numbers of the sub-domains that hold anybody, and where each begins, and the last ends."""
    cells = 0
    for k in range(len(begin) - 1):
        cells += begin[k] < begin[k + 1]
    number, start = np.empty(cells, np.int64), np.empty(cells + 1, np.int64)
    cell = 0
    for k in range(len(begin) - 1):
        if begin[k] < begin[k + 1]:
            number[cell], start[cell] = k, begin[k]
            cell += 1
    start[cells] = begin[-1]
    return number, start


def in_order(order: np.ndarray, positions: np.ndarray, entries: Entries) -> dict[str, np.ndarray]:
    """What `SortedCells` holds of agents at positions, (n, 2), and their images, in an order."""
    images = len(order) if len(entries.row) else 0
    x, y = room_for(2, len(order))
    shift_x, shift_y = room_for(2, images)
    image = memory.empty(images, np.int8)
    row = memory.empty(images, np.int64) if images else order
    in_blocks(_take_all, len(order), order, positions, *entries[1:], row, x, y, shift_x, shift_y,
              image)  # fmt: skip
    return {
        "row": row, "x": x, "y": y, "shift_x": shift_x, "shift_y": shift_y, "image": image
    }  # fmt: skip


@compiled
def _take_all(
    first, last, order, positions, from_row, from_shift, from_kind, row, x, y, shift_x, shift_y,
    image,
):  # fmt: skip
    for k in range(first, last):
        agent = order[k]
        if from_row.size:
            shift_x[k], shift_y[k] = from_shift[agent, 0], from_shift[agent, 1]
            image[k] = from_kind[agent]
            agent = from_row[agent]
            row[k] = agent
        x[k], y[k] = positions[agent, 0], positions[agent, 1]


@compiled
def take(first, last, row, column, taken):
    """taken[k] = column[row[k]]."""
    for k in range(first, last):
        taken[k] = column[row[k]]
