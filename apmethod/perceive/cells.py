"""Agents sorted into the sub-domains of a lattice: the arrays behind every search.

A cell is as wide as the core radius and is split in 4^p sub-domains (paper 2.4.1, Table
2).  An agent's potential neighbours lie in the (2*2^p + 1)^2 sub-domains around its own.
Sub-domains are numbered row by row from the south, so that those of one row of that
square follow each other, and the agents in them are one run of the sorted arrays.

Agents near a periodic or mirrored side appear a second time as images beyond it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from apmethod.compile import inlined
from apmethod.perceive.domain import Domain
from apmethod.perceive.images import REAL, on_sides, with_images
from apmethod.perceive.sorting import (
    corners,
    counting_sort,
    in_order,
    longest_of,
    occupied,
    runs_around,
)

#: A dense table of sub-domains may hold this many for each agent; beyond, it is searched.
_DENSE = 16
#: What numbering a sub-domain may be off by, over how many there are.
_ROUNDING = 8.0 * float(np.finfo(float).eps)
#: Sub-domains along one axis at the most, so that their numbers fit in 64 bits.
_LONGEST = 2**31


class SortedEntries(NamedTuple):
    """Agents and their images in the order of their sub-domains, for passes; see `SortedCells`."""

    x: np.ndarray
    y: np.ndarray
    shift_x: np.ndarray
    shift_y: np.ndarray
    image: np.ndarray
    radius: np.ndarray


class Runs(NamedTuple):
    """The entries of each sub-domain, and the runs around it, for passes; see `SortedCells`."""

    start: np.ndarray
    first: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True)
class SortedCells:
    """Agents in the order of their sub-domains, with the runs around each of these.

    Attributes:
        core_radius: the search radius, and the side of a cell.
        level: p, each cell is split in 4^p sub-domains.
        side: side of a sub-domain, core_radius / 2^p (and a rounding margin).
        origin: x and y of the south-west corner of sub-domain 0.
        grid: number of sub-domains along x and y.
        row: the agent's row in the positions that were sorted, (n + images,).
        image: whether the entry is an image, WRAPPED or MIRROR, or the agent itself, REAL
            (0); empty, as are the shifts, where the domain makes no images.
        x, y: the agents' positions, not shifted.
        shift_x, shift_y: what to add to an image's position.  Behind these four and the radii
            there is memory for `LANES` more, so that they can be read in whole vectors.
        number: of each occupied sub-domain, ascending, (cells,).
        start: where each occupied sub-domain begins in the sorted arrays, (cells + 1,).
        first: where the runs around each occupied sub-domain begin, and those of the last one
            end, in the following, (cells + 1,).
        low, high: where each run of potential neighbours begins and ends in the sorted arrays,
            (runs,).  A sub-domain has 2*2^p + 1 of them, the rows of its surrounding square, its
            own row in the middle; where agents have radii of their own as many as they need, the
            first of which it lies in itself.
        radius: core radius of each entry where agents have their own, as `sort_by_radius`
            sorts them; else empty.
        searched: the cells that neighbours are to be listed from, where those reach further
            than the core radius (see `Skin`); None for these ones.
    """

    core_radius: float
    level: int
    side: float
    origin: tuple[float, float]
    grid: tuple[int, int]
    row: np.ndarray
    image: np.ndarray
    x: np.ndarray
    y: np.ndarray
    shift_x: np.ndarray
    shift_y: np.ndarray
    number: np.ndarray
    start: np.ndarray
    first: np.ndarray
    low: np.ndarray
    high: np.ndarray
    radius: np.ndarray = field(default_factory=lambda: np.empty(0))
    searched: SortedCells | None = None

    @property
    def entries(self) -> SortedEntries:
        """What compiled passes read of the entries."""
        return SortedEntries(self.x, self.y, self.shift_x, self.shift_y, self.image, self.radius)

    @property
    def runs(self) -> Runs:
        """Which entries a sub-domain has, and which may be neighbours of them."""
        return Runs(self.start, self.first, self.low, self.high)

    @cached_property
    def longest(self) -> int:
        """The largest number of potential neighbours that any sub-domain has."""
        return longest_of(self.first, self.low, self.high)

    @property
    def potential(self) -> np.ndarray:
        """How many potential neighbours each sub-domain has, (cells,)."""
        lengths = self.high - self.low
        return np.add.reduceat(lengths, self.first[:-1]) if len(lengths) else lengths

    def around(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """low and high for any points, of shape (n, 2): the runs of agents near each."""
        place = np.floor((points - np.array(self.origin)) / self.side)
        east, north = np.clip(place, -(2.0**40), 2.0**40).astype(np.int64).T
        return _sparse_runs(east, north, self.grid, self.level, self.start, self.number)

    def of_kind(self, kind: int) -> np.ndarray:
        """The entries of a kind, REAL, WRAPPED or MIRROR."""
        if len(self.image):
            return np.flatnonzero(self.image == kind)
        return np.arange(len(self.row) if kind == REAL else 0)

    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y of all entries, images where they are seen."""
        if not len(self.image):
            return self.x, self.y
        return self.x + self.shift_x, self.y + self.shift_y

    def candidates(self) -> int:
        """Number of distance tests in a search for all agents' neighbours (paper Table 2)."""
        own = np.diff(self.start)
        if len(self.image):
            own = np.add.reduceat(self.image == REAL, self.start[:-1], dtype=np.int64)
        return int((own * self.potential).sum())


def sort_into_cells(
    positions: np.ndarray, core_radius: float, level: int, domain: Domain
) -> SortedCells:
    """Sort agents, positions of shape (n, 2), into sub-domains of side core_radius / 2^level."""
    entries = with_images(positions, core_radius, domain)
    places = np.ascontiguousarray(entries.places)
    lowest, highest = corners(places) if len(places) else ((0.0, 0.0), (0.0, 0.0))
    if domain.makes_images:
        lowest = on_sides(lowest, core_radius / 2**level, domain)
    extent = (highest[0] - lowest[0], highest[1] - lowest[1])
    side, grid = grid_of(extent, core_radius, level)
    if few_enough(grid[0] * grid[1], len(places)):
        order, begin = counting_sort(places, lowest, side, grid)
        number, start = occupied(begin)
        low, high = runs_around(number, grid, 2**level, begin)
    else:
        numbers = _numbers(places, lowest, side, grid)
        order = np.argsort(numbers, kind="stable")
        number, first = np.unique(numbers[order], return_index=True)
        start = np.append(first, len(places))
        low, high = _sparse_runs(*divmod(number, grid[0])[::-1], grid, level, start, number)
    return SortedCells(
        core_radius=core_radius,
        level=level,
        side=side,
        origin=lowest,
        grid=grid,
        number=number,
        start=start,
        first=np.arange(0, low.size + 1, low.shape[1]),
        low=low.ravel(),
        high=high.ravel(),
        **in_order(order, positions, entries),
    )


def few_enough(numbers: int, agents: int) -> bool:
    """Whether so many numbers, of sub-domains or lines, can be tabled, occupied or not."""
    return numbers <= _DENSE * agents + 1024


@inlined
def rounding(count):
    """What numbering one of so many sub-domains along an axis may be off by, and a little more."""
    return max(1e-9, _ROUNDING * count)


def grid_of(
    extent: tuple[float, float], core_radius: float, level: int
) -> tuple[float, tuple[int, int]]:
    """Side of a sub-domain, and how many fit along x and y."""
    # The margin keeps an agent just inside the core radius from being numbered too far.
    widest = max(extent) / core_radius * 2**level
    side = core_radius / 2**level * (1.0 + rounding(widest))
    side = max(side, max(extent) / (_LONGEST - 1))
    return side, tuple(int(length / side) + 1 for length in extent)


def _numbers(where: np.ndarray, lowest: tuple, side: float, grid: tuple) -> np.ndarray:
    """Number of the sub-domain that each position is in."""
    place = ((where - lowest) / side).astype(np.int64)
    np.minimum(place, np.array(grid) - 1, out=place)
    return place[:, 1] * grid[0] + place[:, 0]


def _sparse_runs(
    east: np.ndarray,
    north: np.ndarray,
    grid: tuple[int, int],
    level: int,
    start: np.ndarray,
    known: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """`runs_around` any sub-domains, by column and line, in the grid or not.

    ``start`` is where each of the sub-domains whose numbers are ``known`` begins.
    """
    reach = 2**level
    west_end, east_end = np.maximum(east - reach, 0), np.minimum(east + reach, grid[0] - 1)
    rows = north[:, None] + np.arange(-reach, reach + 1)
    inside = (rows >= 0) & (rows < grid[1]) & (west_end <= east_end)[:, None]
    first = np.where(inside, rows * grid[0] + west_end[:, None], 0)
    last = np.where(inside, rows * grid[0] + east_end[:, None] + 1, 0)
    return start[np.searchsorted(known, first)], start[np.searchsorted(known, last)]
