"""Random obstacles, and the oracle that finds first hits by trying every wall."""

import numpy as np

from apmethod import Polygon, Polyline
from apmethod.move.obstacles.rays import BEFORE, brute_force_hits

BEHAVIOURS = ("repulse", "bounce", "slide", "stick", "absorb")


def half_back(dx, dy, nx, ny):
    """A user's own behaviour: half of what is left, mirrored."""
    into = dx * nx + dy * ny
    return 0.5 * (dx - 2.0 * into * nx), 0.5 * (dy - 2.0 * into * ny)


def star(draw, middle, size, corners):
    """A ring that is not convex, around a point."""
    angles = 2.0 * np.pi * (np.arange(corners) + 0.4 * draw.random(corners)) / corners
    reach = size * draw.uniform(0.4, 1.0, corners)
    return middle + reach[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


def motion(draw, fast):
    """A path to and fro that turns, for an obstacle."""
    a, b, turn = draw.uniform(-fast, fast, 3)
    p, q, r = draw.uniform(0.2, 1.5, 3)
    return lambda t: (a * np.sin(p * t), b * np.sin(q * t), 8.0 * turn * np.sin(r * t))


def random_obstacles(draw, moving, absorbing=True):
    """Some of everything in the unit square."""
    found = []
    own = [*BEHAVIOURS, half_back] if absorbing else ["repulse", "bounce", "slide"]
    for number in range(draw.integers(6, 18)):
        options = {"name": f"thing {number}", "behaviour": own[draw.integers(len(own))]}
        middle, size = draw.uniform(0.15, 0.85, 2), draw.uniform(0.02, 0.12)
        if moving and draw.random() < 0.4:
            options["path"] = motion(draw, 0.1)
        kind = draw.integers(4)
        ring = star(draw, middle, size, draw.integers(3, 12))
        if kind == 0:
            found.append(Polygon(ring, **options))
        elif kind == 1:
            found.append(Polygon(ring, holes=[middle + 0.5 * (ring - middle)], **options))
        elif kind == 2:
            found.append(Polyline(np.concatenate([ring, ring[:1]]), **options))  # a room
        else:
            found.append(Polyline(ring, **options))
    return found


def by_brute_force(obstacles, starts, ends):
    shares, hits = np.empty(len(starts)), np.empty(len(starts), np.int32)
    brute_force_hits(0, len(starts), obstacles.walls, BEFORE, starts, ends, shares, hits)
    return shares, hits


def assert_as_brute_force(obstacles, starts, ends):
    found, expected = obstacles.first_hits(starts, ends), by_brute_force(obstacles, starts, ends)
    assert (found[0] == expected[0]).all()
    assert (found[1] == expected[1]).all()
    return expected
