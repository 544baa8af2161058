"""Whom agents near walls see, directly and in walls: what their sums are taken over.

Only agents with a wall within the core radius are looked at; all others have nothing
between them and those they perceive.  Their lists of whom they see, with the
displacement to each as the line goes, replace the plain search for them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from apmethod.compile import in_blocks
from apmethod.move.obstacles.beams import CUTS, NEGATES, REFLECTS
from apmethod.move.obstacles.behaviour import ABSORB
from apmethod.move.obstacles.look import CHUNK, look_around
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import MIRRORED, Domain
from apmethod.perceive.images import REAL

if TYPE_CHECKING:
    from apmethod.move.obstacles.collection import Obstacles


class Lines(NamedTuple):
    """An agent's lines of sight.

    Attributes:
        straight: rows of the agents that it sees directly.
        mirrored: (row, dx, dy, sign) of each image, the displacement from it to the agent.
    """

    straight: set[int]
    mirrored: list[tuple[int, float, float, int]]


@dataclass(frozen=True)
class Sights:
    """Whom places near walls see.

    Attributes:
        place: (places,) number of each place: an entry of the sorted cells, or a point.
        begin, end: (places,) where the list of each is in the arrays below.
        other: entries of the sorted cells that are seen.
        dx, dy: from them to the place, as the line of sight goes.
        sign: 0 of a straight line; of an image 1, or -1 where an odd number of the walls that
            it is seen in absorb.
    """

    place: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    other: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    sign: np.ndarray

    def lines(self, row: np.ndarray) -> dict[int, Lines]:
        """The lists of agents by their rows, of which ``row`` has that of each entry."""
        found = {}
        lists = zip(row[self.place].tolist(), self.begin, self.end, strict=True)
        for me, begin, end in lists:
            chosen = slice(begin, end)
            parts = row[self.other[chosen]], self.dx[chosen], self.dy[chosen], self.sign[chosen]
            entries = list(zip(*(part.tolist() for part in parts), strict=True))
            found[me] = Lines(
                {row for row, _, _, sign in entries if sign == 0},
                [entry for entry in entries if entry[3] != 0],
            )
        return found

    def see_each_other(self, pairs: np.ndarray, row: np.ndarray) -> np.ndarray:
        """Which pairs, (m, 2) rows of agents closer than the core radius, no wall separates."""
        count = int(row.max(initial=0)) + 1
        looks = np.zeros(count, np.bool_)
        looks[row[self.place]] = True
        lengths = self.end - self.begin
        places = np.repeat(self.begin - np.cumsum(lengths) + lengths, lengths)
        places += np.arange(len(places))
        seen = np.repeat(row[self.place], lengths) * count + row[self.other[places]]
        both = pairs[:, 0] * count + pairs[:, 1]
        return ~looks[pairs[:, 0]] | np.isin(both, seen[self.sign[places] == 0])


def sights_of(obstacles: Obstacles, cells: SortedCells, domain: Domain) -> Sights | None:
    """Whom the agents in ``cells`` see that are near walls; None if nobody is."""
    # All of them, then sub-domains first: only those that a wall is near to pay for more.
    if _all_clear(obstacles, cells, domain):
        return None
    line, column = np.divmod(cells.number, cells.grid[0])
    middle = (np.column_stack([column, line]) + 0.5) * cells.side + np.array(cells.origin)
    reach = cells.core_radius + np.sqrt(0.5) * cells.side
    chosen = np.flatnonzero(_near(obstacles, middle, reach, domain))
    if not len(chosen):
        return None
    cell = np.repeat(chosen, np.diff(cells.start)[chosen])
    entry = np.concatenate([np.arange(*cells.start[k : k + 2]) for k in chosen])
    kept = _near(obstacles, _entries(cells, entry), cells.core_radius, domain)
    if len(cells.image):
        kept &= cells.image[entry] == REAL
    entry, cell = entry[kept], cell[kept]
    points = _entries(cells, entry)
    runs = (each.reshape(len(cells.number), -1)[cell] for each in (cells.low, cells.high))
    return _look(obstacles, cells, domain, entry, points, entry, *runs)


def _all_clear(obstacles: Obstacles, cells: SortedCells, domain: Domain) -> bool:
    """Whether the whole lattice is far from all walls."""
    (west, south), reach = cells.origin, cells.core_radius
    east, north = west + cells.side * cells.grid[0], south + cells.side * cells.grid[1]
    return all(
        obstacles.clear_of(west - reach - x, south - reach - y, east + reach - x, north + reach - y)
        for x, y in shifts_of(domain)
    )


def sights_from(
    obstacles: Obstacles, points: np.ndarray, cells: SortedCells, domain: Domain
) -> Sights | None:
    """Whom any points, (n, 2), would see that are near walls; None if none is."""
    near = np.flatnonzero(_near(obstacles, points, cells.core_radius, domain))
    if not len(near):
        return None
    low, high = cells.around(points[near])
    nobody = np.full(len(near), -1)
    return _look(obstacles, cells, domain, near, points[near], nobody, low, high)


def _entries(cells: SortedCells, entry: np.ndarray) -> np.ndarray:
    return np.column_stack([cells.x[entry], cells.y[entry]])


def kinds_of(obstacles: Obstacles) -> np.ndarray:
    """What each obstacle's walls do to lines of sight."""
    if obstacles.contributions == "blocked":
        return np.full(len(obstacles), CUTS, np.int8)
    absorbing = NEGATES if obstacles.absorbing == "mass" else CUTS
    return np.where(obstacles.bodies.code == ABSORB, absorbing, REFLECTS).astype(np.int8)


def shifts_of(domain: Domain) -> list[tuple[float, float]]:
    """By how much walls are seen elsewhere than where they are: across periodic sides."""
    along = [(0.0, period, -period) if period else (0.0,) for period in domain.periods]
    return [(x, y) for x in along[0] for y in along[1]]


def _near(obstacles: Obstacles, points: np.ndarray, reach: float, domain: Domain) -> np.ndarray:
    shifted = [obstacles.near(points - shift, reach) for shift in shifts_of(domain)]
    return np.logical_or.reduce(shifted)


def _look(
    obstacles: Obstacles, cells: SortedCells, domain: Domain, place: np.ndarray,
    points: np.ndarray, own: np.ndarray, low: np.ndarray, high: np.ndarray,
) -> Sights | None:  # fmt: skip
    """The lists of some places, of whose candidates ``low`` and ``high`` tell the runs."""
    count = len(place)
    if not count:
        return None
    limits = np.array([domain.lower, domain.upper])
    mirrored = np.array([kind == MIRRORED for kind in domain.kinds])
    chunks = -(-count // CHUNK)
    room = CHUNK * (int((high - low).sum(axis=1).max()) + 8)
    begin, end = np.empty(count, np.int64), np.empty(count, np.int64)
    while True:
        # Memory that nobody writes to is never taken.
        other, sign = np.empty(chunks * room, np.int32), np.empty(chunks * room, np.int8)
        dx, dy = np.empty(chunks * room), np.empty(chunks * room)
        taken = np.empty(chunks, np.int64)
        in_blocks(
            look_around, chunks, room, points, own, low, high, cells.x, cells.y, cells.shift_x,
            cells.shift_y, cells.image, cells.core_radius, obstacles.tree, obstacles.walls,
            kinds_of(obstacles), np.array(shifts_of(domain)), limits, mirrored,
            obstacles.clearance, begin, end, other, dx, dy, sign, taken, least=12,
        )  # fmt: skip
        if taken.max() <= room:
            return Sights(place, begin, end, other, dx, dy, sign)
        room = int(taken.max())
