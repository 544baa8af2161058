"""Obstacles: polygons with holes, thin walls, and how they behave and move.

square((0.5, 0.5), 0.2, behaviour="bounce")
Polygon([(0, 0), (4, 0), (4, 3)], holes=[...], name="island", velocity=(0.1, 0.0))
Polyline([(0, 0), (1, 1), (2, 1)], spin=0.5)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from apmethod.checks import finite_number, whole_number
from apmethod.move.obstacles.behaviour import checked_behaviour
from apmethod.move.obstacles.outline import (
    Points,
    crossing,
    inside,
    points_of,
    refuse_repeated,
    ring_of,
)


class Obstacle:
    """What agents cannot pass; made as a `Polygon` or a `Polyline`.

    Args:
        chains: its corners as arrays of shape (n, 2); closed ones begin where they end.
        name: what errors and reports call it; by default its class and number.
        behaviour: what an agent does that hits it, a name of ``BEHAVIOURS`` or
            ``f(dx, dy, nx, ny)`` giving (dx, dy); see `apmethod.move.obstacles.behaviour`.
        velocity: (x, y), length/time.
        spin: radians/time, anticlockwise about the pivot.
        path: ``path(t)`` giving the pivot's displacement (x, y) since time 0, or (x, y, angle)
            with the turn; instead of a velocity and a spin.
        pivot: point that it turns about, by default the middle of its bounds.

    Raises:
        ValueError: for a shape or a motion that cannot be, naming the obstacle.

    Attributes:
        absorbed: how many agents have disappeared in it.
    """

    solid = False

    def __init__(
        self,
        chains: Sequence[np.ndarray],
        *,
        name: str = "",
        behaviour: str | Callable = "repulse",
        velocity: Sequence[float] = (0.0, 0.0),
        spin: float = 0.0,
        path: Callable | None = None,
        pivot: Sequence[float] | None = None,
    ):
        self.name = name or f"a {type(self).__name__.lower()}"
        self.chains = tuple(chains)
        self.walls = np.concatenate(
            [np.concatenate([chain[:-1], chain[1:]], axis=1) for chain in self.chains]
        )
        self.behaviour = checked_behaviour(self.name, behaviour)
        self.velocity = tuple(finite_number(f"velocity of {self.name}", v) for v in velocity)
        if len(self.velocity) != 2:
            raise ValueError(f"velocity of {self.name} is {velocity!r}; it must be two numbers")
        self.spin = finite_number(f"spin of {self.name}", spin)
        self.path = path
        if path is not None and (self.spin or any(self.velocity)):
            raise ValueError(f"{self.name} has a path, and a velocity or a spin; give one of them")
        low, high = self.chains[0].min(axis=0), self.chains[0].max(axis=0)
        self.pivot = np.array(0.5 * (low + high) if pivot is None else pivot, float)
        if self.pivot.shape != (2,) or not np.isfinite(self.pivot).all():
            raise ValueError(f"pivot of {self.name} is {pivot!r}; it must be two finite numbers")
        self.absorbed = 0
        self.pose(0.0)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name!r}, {len(self.walls)} walls>"

    @property
    def free(self) -> np.ndarray:
        """For each wall, where agents can be: 1 to the left of it, -1 right, 0 both."""
        return np.zeros(len(self.walls), np.int8)

    @property
    def moves(self) -> bool:
        """Whether it may be elsewhere at another time."""
        return self.path is not None or self.spin != 0.0 or any(self.velocity)

    def pose(self, time: float) -> tuple[float, float, float]:
        """Where it is at a time: displacement x and y of its pivot, and its turn."""
        if self.path is None:
            return self.velocity[0] * time, self.velocity[1] * time, self.spin * time
        try:
            x, y, *turn = (float(value) for value in self.path(time))
            pose = x, y, (turn[0] if turn else 0.0)
        except (TypeError, ValueError) as error:
            raise ValueError(
                f"path of {self.name} is {self.path!r}; path(t) must give (x, y) or "
                f"(x, y, angle): {error}"
            ) from None
        if not np.isfinite(pose).all():
            raise ValueError(f"path of {self.name} gives {pose} at time {time:g}")
        return pose


class Polygon(Obstacle):
    """A solid obstacle: a ring of corners, convex or not, with or without holes.

    Args:
        corners: (n, 2), in either direction; the last may repeat the first.
        holes: rings inside of it that are free.
        options: see `Obstacle`.

    Raises:
        ValueError: for corners that are not finite, rings that cross or touch themselves
            or each other, and holes that are not inside.
    """

    solid = True

    def __init__(self, corners: Points, holes: Sequence[Points] = (), **options: Any):
        name = options.get("name") or "a polygon"
        rings = [ring_of(name, corners), *(ring_of(f"a hole of {name}", hole) for hole in holes)]
        super().__init__(rings, **options)
        sizes = np.array([len(ring) - 1 for ring in rings])
        first, second = crossing(self.walls, np.cumsum(sizes), np.zeros(2, np.int64)).tolist()
        if first >= 0:
            one, other = (
                f"{w[:2].tolist()} to {w[2:].tolist()}" for w in self.walls[[first, second]]
            )
            raise ValueError(f"sides of {self.name} cross or touch: {one} and {other}")
        for hole in rings[1:]:
            if not inside(hole[:1], rings[0])[0]:
                raise ValueError(
                    f"a hole of {self.name}, at {hole[0].tolist()}, is not inside of it"
                )

    @property
    def free(self) -> np.ndarray:
        """Right of a ring that goes round to the left, and the other way in holes."""
        sides = []
        for number, ring in enumerate(self.chains):
            x, y = (ring[:-1] - ring[0]).T
            turn = np.sign(x @ np.roll(y, -1) - y @ np.roll(x, -1))
            sides.append(np.full(len(x), turn if number else -turn, np.int8))
        return np.concatenate(sides)


class Polyline(Obstacle):
    """A thin wall along a line of points; it may end where it began, and cross itself.

    Args:
        points: (n, 2).
        options: see `Obstacle`.
    """

    def __init__(self, points: Points, **options: Any):
        name = options.get("name") or "a polyline"
        chain = points_of(name, points, least=2)
        refuse_repeated(name, chain)
        super().__init__([chain], **options)


def square(centre: Sequence[float], side: float, **options: Any) -> Polygon:
    """A square with sides along the axes."""
    half = 0.5 * finite_number("side", side, above=0.0)
    corners = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    return Polygon(np.asarray(centre, float) + corners, **options)


def disc(centre: Sequence[float], radius: float, corners: int = 64, **options: Any) -> Polygon:
    """A disc, as the regular polygon of so many corners with the disc's area."""
    count = whole_number("corners", corners, least=3)
    angles = 2.0 * np.pi / count * np.arange(count)
    area = 0.5 * count * np.sin(2.0 * np.pi / count)
    reach = finite_number("radius", radius, above=0.0) * np.sqrt(np.pi / area)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    return Polygon(np.asarray(centre, float) + reach * circle, **options)
