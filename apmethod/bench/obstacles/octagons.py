"""Octagons all over the unit square, and rays among them.

They cover some 18 % of it, whatever their number.  Short rays are as long as an agent's step,
a quarter of an octagon's radius; long ones go from anywhere to anywhere.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from apmethod import Polygon, disc

_CORNERS = 8


def octagons(walls: int, seed: int, moving: int = 0, speed: float = 0.1) -> list[Polygon]:
    """So many walls of octagons; those with most room around them may move.

    Args:
        walls: eight to an octagon.
        seed: of places.
        moving: how many move.
        speed: of those, in radii.
    """
    count = max(1, walls // _CORNERS)
    places = np.random.default_rng(seed).random((count, 2))
    radius = 0.25 / np.sqrt(count)
    nearest, _ = cKDTree(places).query(places, k=2)
    speeds = np.zeros(count)
    speeds[np.argsort(-nearest[:, 1])[:moving]] = speed * radius
    return [
        disc(place, radius, corners=_CORNERS, velocity=(along, 0.0))
        for place, along in zip(places, speeds.tolist(), strict=True)
    ]


def rays(walls: int, count: int, length: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Starts and ends of "short" or "long" rays, each (count, 2)."""
    draw = np.random.default_rng(seed + 1)
    starts = draw.random((count, 2))
    if length == "long":
        return starts, draw.random((count, 2))
    step = 0.25 * 0.25 / np.sqrt(max(1, walls // _CORNERS))
    angles = draw.uniform(0.0, 2.0 * np.pi, count)
    return starts, starts + step * np.column_stack([np.cos(angles), np.sin(angles)])
