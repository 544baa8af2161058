"""The compiled search for whom places near walls see, directly and in walls."""

import numpy as np

from apmethod.compile import compiled
from apmethod.move.obstacles.beams import (
    SIDE,
    empty_beams,
    find_beams,
    in_beam,
    in_sight,
    put_facing_first,
    put_wall,
    seen_in,
)
from apmethod.move.obstacles.borrowing import exact
from apmethod.move.obstacles.rays import leaves_near, to_wall
from apmethod.perceive.domain import distance_2
from apmethod.perceive.images import MIRROR

#: Places whose lists share a piece of the table.
CHUNK = 32


@compiled
def look_around(
    first, last, room, points, own, low, high, x, y, shift_x, shift_y, image, radius, tree, walls,
    kinds, shifts, limits, mirrored, clearance, begin, end, other, dx, dy, image_sign, taken,
):  # fmt: skip
    """List whom the places of each chunk see; what there is no room for is only counted."""
    waiting, leaves = np.empty(len(tree.axis), np.int32), np.empty(len(tree.axis), np.int32)
    tried = np.full(len(walls.turn), -1, np.int64)
    most = len(shifts) * len(walls.turn) + 4
    near, kind = np.empty((most, 8)), np.empty(most, np.int8)
    beams = empty_beams()
    radius_2, edge = radius * radius, clearance * radius
    for chunk in range(first, last):
        start, full = chunk * room, (chunk + 1) * room
        at = start
        for k in range(chunk * CHUNK, min((chunk + 1) * CHUNK, len(points))):
            here_x, here_y = points[k, 0], points[k, 1]
            count = 0
            for shift in range(len(shifts)):
                count = walls_near(
                    here_x, here_y, shifts[shift, 0], shifts[shift, 1], radius, tree, walls, kinds,
                    waiting, leaves, tried, k * len(shifts) + shift, near, kind, count,
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
                            other[at], image_sign[at] = j, 0
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
                                other[at], image_sign[at] = j, beams.sign[beam]
                                dx[at], dy[at] = apart_x, apart_y
                            at += 1
            end[k] = at
        taken[chunk] = at - start


@exact
def walls_near(
    x, y, shift_x, shift_y, radius, tree, walls, kinds, waiting, leaves, tried, turn, near, kind,
    count,
):  # fmt: skip
    """Add the walls within the radius, moved by a shift, to ``near``; how many there are now."""
    x, y = x - shift_x, y - shift_y
    for number in range(leaves_near(tree, x, y, radius, waiting, leaves)):
        leaf = leaves[number]
        for item in range(tree.first[leaf], tree.last[leaf]):
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
