"""Whom agents near walls see, directly and in walls: what their sums are taken over.

Only agents with a wall within the core radius are looked at; all others have nothing
between them and those they perceive.  Their lists of whom they see, with the
displacement to each as the line goes, replace the plain search for them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from apmethod.compile import compiled, in_blocks
from apmethod.move.obstacles.beams import (
    CUTS,
    REFLECTS,
    SIDE,
    empty_beams,
    find_beams,
    in_beam,
    in_sight,
    put_facing_first,
    put_wall,
    seen_in,
)
from apmethod.move.obstacles.behaviour import ABSORB
from apmethod.move.obstacles.borrowing import exact
from apmethod.move.obstacles.rays import to_wall
from apmethod.move.obstacles.tree import LEAF
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import MIRRORED, Domain, distance_2
from apmethod.perceive.images import MIRROR, REAL

if TYPE_CHECKING:
    from apmethod.move.obstacles.collection import Obstacles

#: Places whose lists share a piece of the table.
_CHUNK = 32


class Lines(NamedTuple):
    """An agent's lines of sight.

    Attributes:
        straight: rows of the agents that it sees directly.
        mirrored: (row, dx, dy) of each image, the displacement from it to the agent.
    """

    straight: set[int]
    mirrored: list[tuple[int, float, float]]


@dataclass(frozen=True)
class Sights:
    """Whom places near walls see.

    Attributes:
        place: (places,) number of each place: an entry of the sorted cells, or a point.
        begin, end: (places,) where the list of each is in the arrays below.
        other: entries of the sorted cells that are seen.
        dx, dy: from them to the place, as the line of sight goes.
        straight: whether it is a straight line.
    """

    place: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    other: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    straight: np.ndarray

    def lines(self, row: np.ndarray) -> dict[int, Lines]:
        """The lists of agents by their rows, of which ``row`` has that of each entry."""
        found = {}
        lists = zip(row[self.place].tolist(), self.begin, self.end, strict=True)
        for me, begin, end in lists:
            chosen = slice(begin, end)
            rows, direct = row[self.other[chosen]].tolist(), self.straight[chosen].tolist()
            entries = zip(rows, self.dx[chosen].tolist(), self.dy[chosen].tolist(), strict=True)
            found[me] = Lines(
                {r for r, is_direct in zip(rows, direct, strict=True) if is_direct},
                [entry for entry, is_direct in zip(entries, direct, strict=True) if not is_direct],
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
        return ~looks[pairs[:, 0]] | np.isin(both, seen[self.straight[places]])


def sights_of(obstacles: Obstacles, cells: SortedCells, domain: Domain) -> Sights | None:
    """Whom the agents in ``cells`` see that are near walls; None if nobody is."""
    # Sub-domains first: only those that a wall is near to pay for more.
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
    return _look(obstacles, cells, domain, entry, points, entry, cells.low[cell], cells.high[cell])


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


def _shifts(domain: Domain) -> np.ndarray:
    """Where walls are seen besides where they are: across periodic sides."""
    along = [(0.0, period, -period) if period else (0.0,) for period in domain.periods]
    return np.array([(x, y) for x in along[0] for y in along[1]])


def _near(obstacles: Obstacles, points: np.ndarray, reach: float, domain: Domain) -> np.ndarray:
    shifted = [obstacles.near(points - shift, reach) for shift in _shifts(domain)]
    return np.logical_or.reduce(shifted)


def _look(
    obstacles: Obstacles, cells: SortedCells, domain: Domain, place: np.ndarray,
    points: np.ndarray, own: np.ndarray, low: np.ndarray, high: np.ndarray,
) -> Sights | None:  # fmt: skip
    """The lists of some places, of whose candidates ``low`` and ``high`` tell the runs."""
    count = len(place)
    if not count:
        return None
    kinds = np.where(obstacles.bodies.code == ABSORB, CUTS, REFLECTS).astype(np.int8)
    if obstacles.contributions == "blocked":
        kinds[:] = CUTS
    limits = np.array([domain.lower, domain.upper])
    mirrored = np.array([kind == MIRRORED for kind in domain.kinds])
    chunks = -(-count // _CHUNK)
    room = _CHUNK * (int((high - low).sum(axis=1).max()) + 8)
    begin, end = np.empty(count, np.int64), np.empty(count, np.int64)
    while True:
        # Memory that nobody writes to is never taken.
        other, straight = np.empty(chunks * room, np.int32), np.empty(chunks * room, np.bool_)
        dx, dy = np.empty(chunks * room), np.empty(chunks * room)
        taken = np.empty(chunks, np.int64)
        in_blocks(
            look_around, chunks, room, points, own, low, high, cells.x, cells.y, cells.shift_x,
            cells.shift_y, cells.image, cells.core_radius, obstacles.tree, obstacles.walls, kinds,
            _shifts(domain), limits, mirrored, obstacles.clearance, begin, end, other, dx, dy,
            straight, taken, least=12,
        )  # fmt: skip
        if taken.max() <= room:
            return Sights(place, begin, end, other, dx, dy, straight)
        room = int(taken.max())


@compiled
def look_around(
    first, last, room, points, own, low, high, x, y, shift_x, shift_y, image, radius, tree, walls,
    kinds, shifts, limits, mirrored, clearance, begin, end, other, dx, dy, straight, taken,
):  # fmt: skip
    """List whom the places of each chunk see; what there is no room for is only counted."""
    waiting, tried = np.empty(len(tree.axis), np.int32), np.full(len(walls.turn), -1, np.int64)
    most = len(shifts) * len(walls.turn) + 4
    near, kind = np.empty((most, 8)), np.empty(most, np.int8)
    beams = empty_beams()
    radius_2, edge = radius * radius, clearance * radius
    for chunk in range(first, last):
        start, full = chunk * room, (chunk + 1) * room
        at = start
        for k in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(points))):
            here_x, here_y = points[k, 0], points[k, 1]
            count = 0
            for shift in range(len(shifts)):
                count = walls_near(
                    here_x, here_y, shifts[shift, 0], shifts[shift, 1], radius, tree, walls, kinds,
                    waiting, tried, k * len(shifts) + shift, near, kind, count,
                )  # fmt: skip
            count = sides_near(here_x, here_y, radius, limits, mirrored, near, kind, count)
            facing = put_facing_first(near, kind, count, here_x, here_y, clearance)
            images = find_beams(beams, here_x, here_y, near, kind, count, radius, clearance)
            begin[k] = at
            for run in range(low.shape[1]):
                for j in range(low[k, run], high[k, run]):
                    there_x, there_y = x[j], y[j]
                    if image.size:
                        if image[j] == MIRROR:
                            continue  # it is found in the domain's side, as in walls
                        there_x, there_y = there_x + shift_x[j], there_y + shift_y[j]
                    apart_x, apart_y = here_x - there_x, here_y - there_y
                    if not distance_2(apart_x, apart_y) < radius_2:
                        continue  # a reflected line is longer still
                    if j != own[k] and in_sight(
                        near, kind, facing, here_x, here_y, there_x, there_y, clearance
                    ):
                        if at < full:
                            other[at], straight[at] = j, True
                            dx[at], dy[at] = apart_x, apart_y
                        at += 1
                    for beam in range(1, images):
                        u, v = beams.place[beam, 0] - there_x, beams.place[beam, 1] - there_y
                        apart_x = beams.turn[beam, 0] * u + beams.turn[beam, 1] * v
                        apart_y = beams.turn[beam, 2] * u + beams.turn[beam, 3] * v
                        if not distance_2(apart_x, apart_y) < radius_2:
                            continue
                        if not in_beam(beams, beam, near, there_x, there_y, edge):
                            continue
                        if seen_in(beams, beam, near, kind, count, there_x, there_y, clearance):
                            if at < full:
                                other[at], straight[at] = j, False
                                dx[at], dy[at] = apart_x, apart_y
                            at += 1
            end[k] = at
        taken[chunk] = at - start


@exact
def walls_near(
    x, y, shift_x, shift_y, radius, tree, walls, kinds, waiting, tried, turn, near, kind, count
):
    """Add the walls within the radius, moved by a shift, to ``near``; how many there are now."""
    x, y = x - shift_x, y - shift_y
    waiting[0] = 0
    depth = 1
    while depth > 0:
        depth -= 1
        domain = waiting[depth]
        axis = tree.axis[domain]
        if axis != LEAF:
            coordinate = x if axis == 0 else y
            if coordinate - radius <= tree.plane[domain]:
                waiting[depth] = tree.sons[domain, 0]
                depth += 1
            if coordinate + radius >= tree.plane[domain]:
                waiting[depth] = tree.sons[domain, 1]
                depth += 1
            continue
        for item in range(tree.first[domain], tree.last[domain]):
            wall = tree.listed[item]
            if tried[wall] == turn:
                continue
            tried[wall] = turn
            ax, ay = walls.ends[0, wall, 0], walls.ends[0, wall, 1]
            bx, by = walls.ends[0, wall, 2], walls.ends[0, wall, 3]
            off_x, off_y, _ = to_wall(x, y, ax, ay, bx, by)
            if distance_2(off_x, off_y) <= radius * radius:
                put_wall(
                    near, count, ax + shift_x, ay + shift_y, bx + shift_x, by + shift_y,
                    walls.free[wall],
                )  # fmt: skip
                kind[count] = kinds[walls.obstacle[wall]]
                count += 1
    return count


@exact
def sides_near(x, y, radius, limits, mirrored, near, kind, count):
    """Add the mirrored sides of the domain that are within the radius, as far as they matter."""
    for axis in range(2):
        if not mirrored[axis]:
            continue
        here, along = (x, y) if axis == 0 else (y, x)
        low, high = along - 2.0 * radius, along + 2.0 * radius
        if mirrored[1 - axis]:
            low, high = max(low, limits[0, 1 - axis]), min(high, limits[1, 1 - axis])
        for side in range(2):
            border = limits[side, axis]
            if abs(border - here) < radius:
                if axis == 0:
                    put_wall(near, count, border, low, border, high, 0.0)
                else:
                    put_wall(near, count, low, border, high, border, 0.0)
                kind[count] = SIDE
                count += 1
    return count
