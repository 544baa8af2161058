"""Clusters of agents that walls separate: DBSCAN over the pairs that see each other."""

from __future__ import annotations

import numpy as np

from apmethod.move.obstacles.collection import Obstacles
from apmethod.move.obstacles.sight import shifts_of
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import Domain
from apmethod.perceive.pairs import neighbour_pairs


def pairs_in_sight(
    positions: np.ndarray, cells: SortedCells, radius: float, obstacles: Obstacles, domain: Domain
) -> np.ndarray | None:
    """Pairs i < j at most ``radius`` apart that no wall separates; None if no wall is near.

    Args:
        positions: of shape (n, 2).
        cells: the positions, sorted; their search radius is above ``radius``.
        radius: distance, included.
        obstacles: what separates.
        domain: walls are met across its periodic sides, too.

    Returns:
        Rows (i, j), of shape (pairs, 2).
    """
    shifts = shifts_of(domain)
    near = np.logical_or.reduce([obstacles.near(positions - shift, radius) for shift in shifts])
    if not near.any():
        return None
    pairs = neighbour_pairs(cells)
    apart = positions[pairs[:, 0]] - positions[pairs[:, 1]]
    for axis, period in enumerate(domain.periods):
        if period:
            apart[:, axis] -= period * np.round(apart[:, axis] / period)
    kept = (apart**2).sum(axis=1) <= radius * radius
    pairs, apart = pairs[kept], apart[kept]
    looked = np.flatnonzero(near[pairs].any(axis=1))
    begin = positions[pairs[looked, 0]]
    ends = np.concatenate([begin, begin - apart[looked]])
    ways = np.column_stack([np.arange(len(looked)), len(looked) + np.arange(len(looked))])
    cut = np.logical_or.reduce([obstacles.blocked(ends - shift, ways) for shift in shifts])
    return np.delete(pairs, looked[cut], axis=0)


def clusters_of(pairs: np.ndarray, count: int, least: int) -> np.ndarray:
    """`apmethod.clusters` of ``count`` agents, of which ``pairs`` (m, 2) are near each other."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    core = 1 + np.bincount(pairs.ravel(), minlength=count) >= least
    joined = pairs[core[pairs].all(axis=1)]
    graph = coo_array((np.ones(len(joined), np.int8), joined.T), shape=(count, count))
    _, part = connected_components(graph, directed=False)
    label = np.full(count, -1)
    _, first, number = np.unique(part[core], return_index=True, return_inverse=True)
    label[core] = np.argsort(np.argsort(first))[number]
    # Who is near core agents of several clusters belongs to the first of these.
    border = np.concatenate([pairs, pairs[:, ::-1]])
    border = border[~core[border[:, 0]] & core[border[:, 1]]]
    lowest = np.full(count, count)
    np.minimum.at(lowest, border[:, 0], label[border[:, 1]])
    found = lowest < count
    label[found] = lowest[found]
    return label
