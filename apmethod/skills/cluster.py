"""Clusters of agents by distance and density: DBSCAN on the neighbours already perceived.

Ester, Kriegel, Sander and Xu (1996).  An agent is a *core* agent if at least ``least``
agents, itself included, are at most ``radius`` from it.  Core agents that near each other
are in one cluster, and so is whoever is that near to a core agent; everybody else is alone.
An agent near core agents of several clusters belongs to the first of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from apmethod.checks import finite_number, whole_number
from apmethod.compile import compiled, in_blocks, inlined
from apmethod.perceive.cells import SortedCells, sort_into_cells
from apmethod.perceive.domain import Domain, Open, distance_2

if TYPE_CHECKING:
    from apmethod.move.obstacles.collection import Obstacles


def clusters(
    positions: np.ndarray,
    radius: float,
    least: int,
    domain: Domain | None = None,
    obstacles: Obstacles | None = None,
) -> np.ndarray:
    """The cluster of each of any positions.

    Args:
        positions: of shape (n, 2).
        radius: distance at which two agents are near, this distance included.
        least: how many agents, itself included, a core agent has within the radius.
        domain: distances are taken across its periodic sides.
        obstacles: agents whose line of sight their walls cut are not near, at any distance.

    Returns:
        Numbers 0, 1, ... of the clusters, by the first of their core agents, and -1 for
        agents in none, of shape (n,): what scikit-learn's ``DBSCAN`` gives.

    Raises:
        ValueError: for a radius that is not above 0 or a ``least`` below 1.
    """
    radius = finite_number("radius", radius, above=0.0)
    least = whole_number("least", least, least=1)
    positions = np.ascontiguousarray(positions, float).reshape(-1, 2)
    domain = domain or Open()
    cells = search(positions, radius, domain)
    if obstacles is not None:
        return clusters_in_sight(positions, cells, radius, least, obstacles, domain)
    return clusters_in(cells, len(positions), radius, least)


def clusters_in_sight(
    positions: np.ndarray, cells: SortedCells, radius: float, least: int, obstacles: Obstacles,
    domain: Domain,
) -> np.ndarray:  # fmt: skip
    """`clusters` among obstacles, of positions sorted into cells."""
    from apmethod.skills.cluster_walls import clusters_of, pairs_in_sight  # where there are some

    pairs = pairs_in_sight(positions, cells, radius, obstacles, domain)
    if pairs is None:
        return clusters_in(cells, len(positions), radius, least)
    return clusters_of(pairs, len(positions), least)


def search(positions: np.ndarray, radius: float, domain: Domain) -> SortedCells:
    """Cells in which agents exactly at the radius are found, too, and no mirror images."""
    if domain.mirrors:
        borders = tuple(name.replace("mirrored", "bounded") for name in domain.borders)
        domain = Domain(domain.lower, domain.upper, borders)
    return sort_into_cells(positions, radius * (1.0 + 1e-9), 0, domain)


def clusters_in(cells: SortedCells, count: int, radius: float, least: int) -> np.ndarray:
    """`clusters` of ``count`` agents sorted into cells whose search radius is above ``radius``."""
    around = cells.runs, cells.entries, cells.row, radius * radius
    core = np.zeros(count, np.bool_)
    in_blocks(_find_cores, len(cells.number), *around, least, core, least=500)
    first = np.arange(count)
    _join(*around, core, first)
    label = np.full(count, -1)
    _number(core, first, label)
    in_blocks(_join_border, len(cells.number), *around, core, first, label, least=500)
    return label


@inlined
def _apart_2(i, j, entries):
    """Squared distance from entry i to entry j, which may be an image."""
    x, y = entries.x, entries.y
    dx, dy = x[i] - x[j], y[i] - y[j]
    if entries.image.size:
        dx, dy = dx - entries.shift_x[j], dy - entries.shift_y[j]
    return distance_2(dx, dy)


@compiled
def _find_cores(begin, end, runs, entries, row, radius_2, least, core):
    """Mark agents with enough others near them; who has enough is not counted on."""
    start, image = runs.start, entries.image
    for cell in range(begin, end):
        for i in range(start[cell], start[cell + 1]):
            if image.size and image[i]:
                continue
            near = 0
            for run in range(runs.first[cell], runs.first[cell + 1]):
                for j in range(runs.low[run], runs.high[run]):
                    near += 1 if _apart_2(i, j, entries) <= radius_2 else 0
                if near >= least:
                    break
            core[row[i]] = near >= least


@compiled
def _join(runs, entries, row, radius_2, core, first):
    """Union-find over core agents: ``first`` leads from each to the first of its cluster."""
    start, image = runs.start, entries.image
    for cell in range(start.size - 1):
        for i in range(start[cell], start[cell + 1]):
            me = row[i]
            if not core[me] or (image.size and image[i]):
                continue
            a = _end(first, me)
            for run in range(runs.first[cell], runs.first[cell + 1]):
                for j in range(runs.low[run], runs.high[run]):
                    # Each pair once, from its end that is the later one in the table; most
                    # are of one cluster already, which is quicker to see than their distance.
                    if row[j] >= me or first[row[j]] == a or not core[row[j]]:
                        continue
                    if _apart_2(i, j, entries) <= radius_2:
                        b = _end(first, row[j])
                        a, b = min(a, b), max(a, b)
                        first[b] = a


@inlined
def _end(first, k):
    """Where ``first`` leads to from agent k; the way gets shorter as it is gone."""
    while first[k] != k:
        first[k] = first[first[k]]
        k = first[k]
    return k


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
def _join_border(begin, end, runs, entries, row, radius_2, core, first, label):
    """Give agents that are not core agents the first cluster that they are near to."""
    start, image = runs.start, entries.image
    for cell in range(begin, end):
        for i in range(start[cell], start[cell + 1]):
            if core[row[i]] or (image.size and image[i]):
                continue
            found = first.size
            for run in range(runs.first[cell], runs.first[cell + 1]):
                for j in range(runs.low[run], runs.high[run]):
                    if (
                        core[row[j]]
                        and first[row[j]] < found
                        and _apart_2(i, j, entries) <= radius_2
                    ):
                        found = first[row[j]]
            if found < first.size:
                label[row[i]] = label[found]


def centres_of(
    label: np.ndarray, position: np.ndarray, mass: np.ndarray, sizes: np.ndarray, domain: Domain
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, centre of mass and root mean square radius of each cluster.

    Where an axis is periodic the centre is found from the mean angle on a circle.
    """
    count = len(sizes)
    weight = np.where(mass > 0.0, mass, np.finfo(float).tiny)
    masses = np.bincount(label, weight, count)
    centres, square = np.empty((count, 2)), np.zeros(count)
    for axis, period in enumerate(domain.periods):
        along = position[:, axis]
        around = np.zeros(count)
        if period:
            turn = 2.0 * np.pi / period * along
            around = np.arctan2(
                np.bincount(label, weight * np.sin(turn), count),
                np.bincount(label, weight * np.cos(turn), count),
            ) * (period / (2.0 * np.pi))
        apart = along - around[label]
        if period:
            apart -= period * np.round(apart / period)
        off = np.bincount(label, weight * apart, count) / masses
        square += np.bincount(label, (apart - off[label]) ** 2, count) / sizes
        centres[:, axis] = around + off
        if period:
            lower = domain.lower[axis]
            centres[:, axis] = lower + (centres[:, axis] - lower) % period
    return np.bincount(label, mass, count), centres, np.sqrt(square)
