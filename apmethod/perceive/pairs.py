"""Pairs of agents: by the lattice, and by trying them all."""

import numpy as np

from apmethod.compile import compiled
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import Domain, Open, distance_2
from apmethod.perceive.images import MIRROR


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
    arguments = (
        cells.start, cells.low, cells.high, cells.row, cells.image,
        cells.x, cells.y, cells.shift_x, cells.shift_y, cells.core_radius,
    )  # fmt: skip
    pairs = np.empty((_find_pairs(*arguments, np.empty((0, 2), np.int64)), 2), np.int64)
    _find_pairs(*arguments, pairs)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


@compiled
def _find_pairs(start, low, high, row, image, x, y, shift_x, shift_y, core_radius, pairs):
    """Write the pairs as far as ``pairs`` has room, and count them all."""
    count = 0
    for cell in range(start.size - 1):
        for i in range(start[cell], start[cell + 1]):
            if image.size and image[i]:
                continue
            for run in range(low.shape[1]):
                for j in range(low[cell, run], high[cell, run]):
                    if row[j] > row[i] and not (image.size and image[j] == MIRROR):
                        dx, dy = x[i] - x[j], y[i] - y[j]
                        if image.size:
                            dx, dy = dx - shift_x[j], dy - shift_y[j]
                        if distance_2(dx, dy) < core_radius * core_radius:
                            if count < pairs.shape[0]:
                                pairs[count, 0] = row[i]
                                pairs[count, 1] = row[j]
                            count += 1
    return count
