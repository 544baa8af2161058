"""Pairs of agents: by the lattice, and by trying them all."""

import numpy as np

from apmethod.compile import compiled, in_blocks
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import Domain, Open
from apmethod.perceive.images import MIRROR
from apmethod.perceive.lists import neighbour_lists


def brute_force_pairs(
    positions: np.ndarray, core_radius: float, domain: Domain | None = None
) -> np.ndarray:
    """All pairs i < j closer than the core radius, each tried: the oracle of every search.

    Args:
        positions: of shape (n, 2).
        core_radius: two agents at exactly this distance are not neighbours.
        domain: shortest distances are taken across its periodic sides.

    Returns:
        Rows (i, j) in ascending order, of shape (pairs, 2).
    """
    positions = np.asarray(positions, float)
    found = []
    for i in range(len(positions)):
        apart = positions[i] - positions[i + 1 :]
        for axis, period in enumerate((domain or Open()).periods):
            if period:
                apart[apart[:, axis] > 0.5 * period, axis] -= period
                apart[apart[:, axis] < -0.5 * period, axis] += period
        near = np.flatnonzero(apart[:, 0] ** 2 + apart[:, 1] ** 2 < core_radius**2)
        found.append(np.column_stack([np.full(len(near), i), near + i + 1]))
    return np.concatenate(found) if found else np.empty((0, 2), int)


def neighbour_pairs(cells: SortedCells) -> np.ndarray:
    """All pairs i < j closer than the core radius, found in the lattice.

    Returns:
        Rows (i, j) in ascending order, of shape (pairs, 2).
    """
    lists = neighbour_lists(cells)
    listed = (cells.row, cells.image, lists.start, lists.other)
    begin = np.zeros(cells.row.max(initial=-1) + 2, np.int64)
    none = np.empty((0, 2), np.int64)
    in_blocks(_list_pairs, len(cells.row), *listed, begin, none, least=2000)
    np.cumsum(begin, out=begin)
    pairs = np.empty((begin[-1], 2), np.int64)
    in_blocks(_list_pairs, len(cells.row), *listed, begin, pairs, least=2000)
    return pairs


@compiled
def _list_pairs(first, last, row, image, start, other, begin, pairs):
    """Count the pairs of each row into ``begin``, one place on, or list them from there."""
    longest = 0
    for k in range(first, last):
        longest = max(longest, start[k + 1] - start[k])
    near = np.empty(longest + 1, np.int64)
    for k in range(first, last):
        me, count = row[k], 0
        # Written at every neighbour and kept at those that come later: no branch to mispredict.
        for place in range(start[k], start[k + 1]):
            j = other[place]
            near[count] = row[j]
            count += (row[j] > me) & (not image.size or image[j] != MIRROR)
        if image.size and image[k]:
            continue
        if not pairs.shape[0]:
            begin[me + 1] = count
            continue
        for n in range(count):
            at = begin[me] + n
            pairs[at, 0] = me
            while at > begin[me] and pairs[at - 1, 1] > near[n]:
                pairs[at, 1] = pairs[at - 1, 1]
                at -= 1
            pairs[at, 1] = near[n]
