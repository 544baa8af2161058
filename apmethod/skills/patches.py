"""The patches that a signal lives on: a grid of squares, and who borders on whom."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from apmethod.checks import finite_number
from apmethod.perceive.domain import OPEN, PERIODIC, Domain

if TYPE_CHECKING:
    from apmethod.move.obstacles.collection import Obstacles

    #: Which patches are blocked: f(x, y) of their centres, booleans of their shape, or a
    #: model's obstacles, which block the patches whose centres no agent can have.
    Blocked = Callable[[np.ndarray, np.ndarray], np.ndarray] | np.ndarray | Obstacles | None

#: So many patches take some 50 gigabytes.
_MOST = 1_000_000_000


@dataclass(frozen=True)
class Patches:
    """Squares that fill a domain, numbered [east, north] as Mesa's property layers are.

    Attributes:
        side: length of a patch's side.
        shape: number of patches along x and y.
        lower: south-west corner of patch [0, 0].
        periodic: whether the first and the last patch along x, and y, border on each other.
        free: 1.0 where a patch is no obstacle, of ``shape``.
        home: for each patch the flat number of the free patch nearest to it, of ``shape``:
            what is laid on or read from an obstacle is that of its home.
        east: 1.0 where a patch exchanges with its eastern neighbour, 0.0 across a border
            or an obstacle, of ``shape``.
        north: the same with the northern neighbour.
    """

    side: float
    shape: tuple[int, int]
    lower: tuple[float, float]
    periodic: tuple[bool, bool]
    free: np.ndarray
    home: np.ndarray
    east: np.ndarray
    north: np.ndarray

    @property
    def area(self) -> float:
        """Area of a patch."""
        return self.side * self.side

    @property
    def grid(self) -> tuple:
        """(south-west x, y, side, periodic along x, y), as compiled passes take it."""
        return (*self.lower, self.side, *self.periodic)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """x_min, x_max, y_min, y_max: what matplotlib's ``imshow`` takes."""
        (west, south), (wide, high) = self.lower, self.shape
        return west, west + wide * self.side, south, south + high * self.side

    def centres(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y of the patches' centres, each of ``shape``."""
        x, y = (
            low + (np.arange(count) + 0.5) * self.side
            for low, count in zip(self.lower, self.shape, strict=True)
        )
        return np.meshgrid(x, y, indexing="ij")


def lay_patches(domain: Domain, side: float, obstacles: Blocked = None) -> Patches:
    """Patches of a side that fill a domain; its periodic sides border on each other.

    Raises:
        ValueError: for an open domain, a side that does not divide it or makes too many
            patches, or obstacles of a wrong shape or everywhere.
    """
    side = finite_number("patch", side, above=0.0)
    if OPEN in domain.kinds:
        raise ValueError(
            f"the scene has an {domain!r}; a signal needs one that is bounded or periodic along "
            "x and y, for its patches to fill"
        )
    shape = tuple(
        _count(length, side, axis)
        for length, axis in zip(domain.upper - domain.lower, "xy", strict=True)
    )
    if math.prod(shape) > _MOST:
        raise ValueError(
            f"patch is {side:g}, which makes {math.prod(shape):.3g} patches; {_MOST:.0e} is the "
            "most"
        )
    lower = (float(domain.lower[0]), float(domain.lower[1]))
    periodic = tuple(kind == PERIODIC for kind in domain.kinds)
    bare = Patches(side, shape, lower, periodic, *[np.empty((0, 0))] * 4)
    free = _free(bare, obstacles)
    # Two patches exchange where both are free; the last one has a neighbour if periodic.
    east, north = free * np.roll(free, -1, axis=0), free * np.roll(free, -1, axis=1)
    if not periodic[0]:
        east[-1] = 0.0
    if not periodic[1]:
        north[:, -1] = 0.0
    return Patches(side, shape, lower, periodic, free, _homes(free), east, north)


def _count(length: float, side: float, axis: str) -> int:
    count = round(length / side)
    if count < 1 or abs(count * side - length) > 1e-9 * length:
        near = length / max(1, count)
        raise ValueError(
            f"patch is {side:g} and the domain is {length:g} long along {axis}; a whole number "
            f"of patches must fill it, so {near:.6g} would do"
        )
    return count


def _free(patches: Patches, obstacles: Blocked) -> np.ndarray:
    if obstacles is None:
        return np.ones(patches.shape)
    x, y = patches.centres()
    if hasattr(obstacles, "occupied"):
        blocked = obstacles.occupied(np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)
    else:
        blocked = np.asarray(obstacles(x, y) if callable(obstacles) else obstacles)
    if blocked.shape != patches.shape:
        raise ValueError(
            f"obstacles has shape {blocked.shape}; it must be that of the patches, {patches.shape}"
        )
    if blocked.all():
        raise ValueError("obstacles is everywhere; some patch must be free")
    return 1.0 - blocked.astype(bool)


def _homes(free: np.ndarray) -> np.ndarray:
    """Flat numbers of each patch's nearest free patch."""
    number = np.arange(free.size).reshape(free.shape)
    if free.all():
        return number
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(free == 0.0, return_distances=False, return_indices=True)
    return number[tuple(nearest)]
