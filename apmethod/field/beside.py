"""Agents laid beside walls: the squares of their lattice that walls cut.

An agent on a lattice stands for the field in its square.  Of a square that walls cut it
stands for the part that it can see; parts that it cannot see get agents of their own.  The
mass of a part is the field at its centroid by its area, so that mass and centre of mass are
those of the field beside walls of any direction, to second order.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from apmethod.contribute.sample import Field
from apmethod.perceive.domain import Domain

if TYPE_CHECKING:
    from apmethod.move.obstacles.collection import Obstacles

#: Points along each side of a square that a wall cuts.
_POINTS = 24
#: Parts of a square at the most.
_PARTS = 12


def fit_to_walls(
    obstacles: Obstacles, field: Field, positions: np.ndarray, masses: np.ndarray,
    spacings: tuple[float, float], least: float, domain: Domain,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Agents on a lattice, and those beside walls where these cut their squares.

    Args:
        obstacles: what cuts.
        field: u(x, y) on arrays.
        positions: nodes of a square lattice outside of obstacles, (n, 2).
        masses: of the agents there, (n,).
        spacings: of the lattice along x and y.
        least: value of u below which a part is left without an agent.
        domain: where agents may be.

    Returns:
        positions and masses of all agents; those whose squares no wall cuts come first.
    """
    size = np.array(spacings)
    reach = 0.5 * np.hypot(*spacings)
    cut = obstacles.near(positions, reach)
    nodes = _around(positions[obstacles.near(positions, 3.0 * reach)], size)
    nodes = nodes[((nodes >= domain.lower) & (nodes <= domain.upper)).all(axis=1)]
    nodes = nodes[obstacles.near(nodes, reach)]
    if not len(nodes):
        return positions, masses
    line = (np.arange(_POINTS) + 0.5) / _POINTS - 0.5
    within = np.column_stack([part.ravel() for part in np.meshgrid(line, line)]) * size
    places, areas = _parts(obstacles, nodes, within, float(size.prod()))
    if not domain.is_open:  # a square may reach across a periodic side
        places = np.array([domain.place(x, y) for x, y in places.tolist()])
    values = np.asarray(field(*places.T), float)
    kept = values > least
    return (
        np.concatenate([positions[~cut], places[kept]]),
        np.concatenate([masses[~cut], (values * areas)[kept]]),
    )


def _around(nodes: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Nodes, and those next to them, each once."""
    if not len(nodes):
        return nodes
    origin = nodes[0]
    numbers = np.rint((nodes - origin) / size).astype(np.int64)
    steps = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    return origin + np.unique((numbers[:, None] + steps).reshape(-1, 2), axis=0) * size


def _parts(
    obstacles: Obstacles, nodes: np.ndarray, within: np.ndarray, area: float
) -> tuple[np.ndarray, np.ndarray]:
    """Centroids and areas of the parts of the squares around nodes, each seen from one place."""
    count = len(within)
    points = (nodes[:, None] + within).reshape(-1, 2)
    left = ~obstacles.occupied(points).reshape(-1, count)
    places, areas = [], []
    for _ in range(_PARTS):
        cells = np.flatnonzero(left.any(axis=1))
        if not len(cells):
            break
        # From the point nearest to the middle of what is left.
        middles = _means(left[cells], within)
        apart = ((within - middles[:, None]) ** 2).sum(axis=2)
        seer = np.where(left[cells], apart, np.inf).argmin(axis=1)
        pairs = np.column_stack(
            [np.repeat(cells * count + seer, count),
             (cells[:, None] * count + np.arange(count)).ravel()]
        )  # fmt: skip
        seen = left[cells]
        seen[seen] = ~obstacles.blocked(points, pairs[seen.ravel()])
        seen[np.arange(len(cells)), seer] = True
        left[cells] &= ~seen
        seers, centroids = points[cells * count + seer], nodes[cells] + _means(seen, within)
        both = np.concatenate([seers, centroids])
        ways = np.arange(len(cells))[:, None] + (0, len(cells))
        hidden = obstacles.blocked(both, ways) | obstacles.occupied(centroids)
        places.append(np.where(hidden[:, None], seers, centroids))
        areas.append(seen.sum(axis=1) * (area / count))
    return np.concatenate(places or [nodes[:0]]), np.concatenate(areas or [np.empty(0)])


def _means(chosen: np.ndarray, within: np.ndarray) -> np.ndarray:
    """Mean of the chosen points of each square."""
    return (chosen @ within) / chosen.sum(axis=1)[:, None]
