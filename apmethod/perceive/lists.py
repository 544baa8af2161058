"""Each agent's neighbours as one flat list: found once, used in several rounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from apmethod.compile import compiled, in_blocks, memory
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import distance_2


@dataclass(frozen=True)
class NeighbourLists:
    """Neighbours of the agents of sorted cells, by their places in the sorted arrays.

    Attributes:
        start: the neighbours of entry k are other[start[k]:start[k + 1]]; an image has none.
        other: places of the neighbours, run by run; mirror images are among them.
    """

    start: np.ndarray
    other: np.ndarray


def neighbour_lists(cells: SortedCells) -> NeighbourLists:
    """The neighbours of all agents in ``cells``, closer than the core radius."""
    start = neighbour_counts(cells)
    np.cumsum(start, out=start)
    other = memory.empty(int(start[-1]), np.int32)
    in_blocks(_find, len(cells.number), *_searched(cells), start, other, False, least=200)
    return NeighbourLists(start, other)


def neighbour_counts(cells: SortedCells) -> np.ndarray:
    """How many neighbours each entry has, one place on, after a first 0."""
    start = np.zeros(len(cells.row) + 1, np.int64)
    none = np.empty(0, np.int32)
    in_blocks(_find, len(cells.number), *_searched(cells), start, none, True, least=200)
    return start


def _searched(cells: SortedCells) -> tuple:
    return cells.runs, cells.entries, cells.core_radius, cells.longest


@compiled
def _find(first, last, runs, entries, core_radius, longest, begin, other, count_only):
    """Count each agent's neighbours into ``begin``, one place on, or list them from there."""
    start, low, high = runs.start, runs.low, runs.high
    x, y, shift_x, shift_y, image, radius = entries
    near_x, near_y, apart_2 = np.empty(longest), np.empty(longest), np.empty(longest)
    over_x, over_y, near_radius = np.empty(longest), np.empty(longest), np.empty(longest)
    place, found = np.empty(longest, np.int32), np.empty(longest + 1, np.int32)
    reach_2 = np.full(longest, core_radius * core_radius)
    for cell in range(first, last):
        # LpN: the runs of the surrounding sub-domains, one after the other.
        count = 0
        for run in range(runs.first[cell], runs.first[cell + 1]):
            for j in range(low[run], high[run]):
                near_x[count], near_y[count], place[count] = x[j], y[j], j
                if image.size:
                    over_x[count], over_y[count] = shift_x[j], shift_y[j]
                if radius.size:
                    near_radius[count] = radius[j]
                count += 1
        for i in range(start[cell], start[cell + 1]):
            if image.size and image[i]:
                continue
            x_i, y_i = x[i], y[i]
            if image.size:
                for k in range(count):
                    dx, dy = (x_i - near_x[k]) - over_x[k], (y_i - near_y[k]) - over_y[k]
                    apart_2[k] = distance_2(dx, dy)
            else:
                for k in range(count):
                    apart_2[k] = distance_2(x_i - near_x[k], y_i - near_y[k])
            if radius.size:
                radius_i = radius[i]
                for k in range(count):
                    reach = 0.5 * (radius_i + near_radius[k])
                    reach_2[k] = reach * reach
            if count_only:
                total = -1  # the agent itself is among the candidates
                for k in range(count):
                    total += 1 if apart_2[k] < reach_2[k] else 0
                begin[i + 1] = total
                continue
            # Written at every candidate and kept at each neighbour: no branch to mispredict.
            taken = 0
            for k in range(count):
                found[taken] = place[k]
                taken += 1 if (apart_2[k] < reach_2[k]) & (place[k] != i) else 0
            for k in range(taken):
                other[begin[i] + k] = found[k]
