"""Clusters of agents by distance and density: DBSCAN on the neighbours already perceived.

Ester, Kriegel, Sander and Xu (1996).  An agent is a *core* agent if at least ``least``
agents, itself included, are at most ``radius`` from it.  Core agents that near each other
are in one cluster, and so is whoever is that near to a core agent; everybody else is alone.
An agent near core agents of several clusters belongs to the first of them.
"""

from __future__ import annotations

import numpy as np

from apmethod.checks import finite_number, whole_number
from apmethod.compile import compiled, in_blocks
from apmethod.perceive.cells import SortedCells, sort_into_cells
from apmethod.perceive.domain import Domain, Open, distance_2
from apmethod.perceive.lists import neighbour_lists


def clusters(
    positions: np.ndarray, radius: float, least: int, domain: Domain | None = None
) -> np.ndarray:
    """The cluster of each of any positions.

    Args:
        positions: of shape (n, 2).
        radius: distance at which two agents are near, this distance included.
        least: how many agents, itself included, a core agent has within the radius.
        domain: distances are taken across its periodic sides.

    Returns:
        Numbers 0, 1, ... of the clusters, by the first of their core agents, and -1 for
        agents in none, of shape (n,): what scikit-learn's ``DBSCAN`` gives.

    Raises:
        ValueError: for a radius that is not above 0 or a ``least`` below 1.
    """
    radius = finite_number("radius", radius, above=0.0)
    least = whole_number("least", least, least=1)
    positions = np.ascontiguousarray(positions, float).reshape(-1, 2)
    return clusters_in(search(positions, radius, domain or Open()), len(positions), radius, least)


def search(positions: np.ndarray, radius: float, domain: Domain) -> SortedCells:
    """Cells in which agents exactly at the radius are found, too."""
    return sort_into_cells(positions, radius * (1.0 + 1e-9), 1, domain)


def clusters_in(cells: SortedCells, count: int, radius: float, least: int) -> np.ndarray:
    """`clusters` of ``count`` agents sorted into cells whose search radius is above ``radius``."""
    lists = neighbour_lists(cells)
    pairs = (
        lists.start, lists.other, cells.row, cells.image, cells.x, cells.y, cells.shift_x,
        cells.shift_y, radius,
    )  # fmt: skip
    core = np.zeros(count, np.bool_)
    in_blocks(_find_cores, len(cells.row), *pairs, least, core, least=2000)
    first = np.arange(count)
    _join(*pairs, core, first)
    label = np.full(count, -1)
    _number(core, first, label)
    in_blocks(_join_border, len(cells.row), *pairs, core, first, label, least=2000)
    return label


@compiled
def _find_cores(begin, end, start, other, row, image, x, y, shift_x, shift_y, radius, least, core):
    radius_2 = radius * radius
    for i in range(begin, end):
        if image.size and image[i]:
            continue
        near = 1
        if start[i + 1] - start[i] + 1 >= least:
            for k in range(start[i], start[i + 1]):
                j = other[k]
                dx, dy = x[i] - x[j], y[i] - y[j]
                if image.size:
                    dx, dy = dx - shift_x[j], dy - shift_y[j]
                near += 1 if distance_2(dx, dy) <= radius_2 else 0
        core[row[i]] = near >= least


@compiled
def _join(start, other, row, image, x, y, shift_x, shift_y, radius, core, first):
    """Union-find over core agents: ``first`` leads from each to the first of its cluster."""
    radius_2 = radius * radius
    for i in range(row.size):
        me = row[i]
        if not core[me] or (image.size and image[i]):
            continue
        a = me
        while first[a] != a:
            first[a] = first[first[a]]
            a = first[a]
        for k in range(start[i], start[i + 1]):
            j = other[k]
            # Each pair once, from its end that is the later one in the table; most are of
            # one cluster already, which is quicker to see than that they are near.
            if row[j] < me and first[row[j]] != a and core[row[j]]:
                dx, dy = x[i] - x[j], y[i] - y[j]
                if image.size:
                    dx, dy = dx - shift_x[j], dy - shift_y[j]
                if distance_2(dx, dy) <= radius_2:
                    b = row[j]
                    while first[b] != b:
                        first[b] = first[first[b]]
                        b = first[b]
                    a, b = min(a, b), max(a, b)
                    first[b] = a


@compiled
def _number(core, first, label):
    """Number the clusters by their first core agents."""
    count = 0
    for k in range(first.size):
        if core[k]:
            # What leads on from an earlier agent has been led to the end already.
            first[k] = first[first[k]]
            if first[k] == k:
                label[k] = count
                count += 1
            else:
                label[k] = label[first[k]]


@compiled
def _join_border(
    begin, end, start, other, row, image, x, y, shift_x, shift_y, radius, core, first, label
):
    """Give agents that are not core agents the first cluster that they are near to."""
    radius_2 = radius * radius
    for i in range(begin, end):
        if core[row[i]] or (image.size and image[i]):
            continue
        found = first.size
        for k in range(start[i], start[i + 1]):
            j = other[k]
            if core[row[j]] and first[row[j]] < found:
                dx, dy = x[i] - x[j], y[i] - y[j]
                if image.size:
                    dx, dy = dx - shift_x[j], dy - shift_y[j]
                if distance_2(dx, dy) <= radius_2:
                    found = first[row[j]]
        if found < first.size:
            label[row[i]] = label[found]
