"""Outlines as arrays of points, which of them cannot be, and what is inside of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from apmethod.move.obstacles.borrowing import borrowing
from apmethod.move.obstacles.predicates import MISS, meeting, orientation

Points = Sequence[Sequence[float]] | np.ndarray


def inside(points: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Which points, (n, 2), are inside a closed ring or on it: exact, by counting crossings."""
    result = np.zeros(len(points), np.bool_)
    _inside(points, ring, result)
    return result


@borrowing
def _inside(points, ring, result):
    for k in range(len(points)):
        x, y = points[k, 0], points[k, 1]
        odd = False
        for corner in range(len(ring) - 1):
            ax, ay, bx, by = (
                ring[corner, 0],
                ring[corner, 1],
                ring[corner + 1, 0],
                ring[corner + 1, 1],
            )
            if meeting(x, y, x, y, ax, ay, bx, by) != MISS:
                odd = True
                break
            if (ay > y) != (by > y):  # the side crosses the line to the east or west
                left = orientation(ax, ay, bx, by, x, y) > 0.0
                if left == (by > ay):
                    odd = not odd
        result[k] = odd


@borrowing
def crossing(walls, ends, found):
    """The first two sides that meet without being next to each other in a ring, or -1."""
    found[0], found[1] = -1, -1
    first = 0
    ring = 0
    for i in range(len(walls)):
        if i == ends[ring]:
            first = ends[ring]
            ring += 1
        ax, ay, bx, by = walls[i, 0], walls[i, 1], walls[i, 2], walls[i, 3]
        for j in range(i + 1, len(walls)):
            cx, cy, dx, dy = walls[j, 0], walls[j, 1], walls[j, 2], walls[j, 3]
            if max(ax, bx) < min(cx, dx) or max(cx, dx) < min(ax, bx):
                continue
            if max(ay, by) < min(cy, dy) or max(cy, dy) < min(ay, by):
                continue
            after = j == i + 1 and j < ends[ring]
            before = i == first and j == ends[ring] - 1
            if after or before:
                # Neighbours share a corner, and must not fold back over each other.
                if after:
                    ux, uy, vx, vy, wx, wy = ax, ay, bx, by, dx, dy
                else:
                    ux, uy, vx, vy, wx, wy = cx, cy, ax, ay, bx, by
                folded = (ux - vx) * (wx - vx) + (uy - vy) * (wy - vy) > 0.0
                if not (folded and orientation(ux, uy, vx, vy, wx, wy) == 0.0):
                    continue
            elif meeting(ax, ay, bx, by, cx, cy, dx, dy) == MISS:
                continue
            found[0], found[1] = i, j
            return found
    return found


def points_of(name: str, points: Points, least: int) -> np.ndarray:
    """Points as an array of shape (n, 2); refused if they are fewer than ``least`` or too far."""
    try:
        array = np.array(points, float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim != 2 or array.shape[1:] != (2,) or len(array) < least:
        raise ValueError(f"{name} must have {least} or more points (x, y); it has {points!r}")
    sizes = np.abs(array)
    fit = (sizes <= 1e100) & ((sizes >= 1e-100) | (sizes == 0.0))
    if not fit.all():
        bad = array[np.flatnonzero(~fit.all(axis=1))[0]].tolist()
        raise ValueError(
            f"{name} has a point at {bad}; coordinates must be finite, and 0 or between "
            "1e-100 and 1e100 in size"
        )
    return array


def ring_of(name: str, corners: Points) -> np.ndarray:
    """Corners as a closed ring, whose last point is its first."""
    ring = points_of(name, corners, least=3)
    if (ring[0] != ring[-1]).any():
        ring = np.concatenate([ring, ring[:1]])
    if len(ring) < 4:
        raise ValueError(f"{name} must have 3 or more corners; it has {ring[:-1].tolist()}")
    refuse_repeated(name, ring)
    return ring


def refuse_repeated(name: str, chain: np.ndarray) -> None:
    """Refuse two equal points in a row: a wall without a length."""
    repeated = np.flatnonzero((chain[1:] == chain[:-1]).all(axis=1))
    if len(repeated):
        raise ValueError(f"{name} has the point {chain[repeated[0]].tolist()} twice in a row")
