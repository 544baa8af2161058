"""Mirror images among walls: the ways by which one place sees another in them.

Contributions go along straight lines, and along lines that walls reflect, as light does.
A reflected line from j to i is as long as the straight one from j to the image of i in the
wall, and in several walls to the image of the image.  Each image is seen in a *beam*: the
cone from it through its wall, narrowed to what the walls before let through.  Lines of
sight that walls return this way cover each direction around an agent up to the core radius
exactly once, whatever the walls' shape, so that a constant field has complete sums beside
any of them and diffusion has no flux through them.  Images in an odd number of walls that take
mass have the opposite sign, so that u = 0 there.  Beside straight walls, in boxes and in
wedges of pi/n the images are those of the exact solution; around the outer corners of
obstacles no images are, and these only complete the sums.
"""

from typing import NamedTuple

import numpy as np

from apmethod.compile import inlined
from apmethod.move.obstacles.borrowing import exact
from apmethod.move.obstacles.predicates import MISS, meeting

#: Walls that one line may be reflected by: enough for wedges down to 45 degrees, and for
#: channels down to a quarter of the core radius.
MOST_REFLECTIONS = 4
#: Images of one place; those in more walls are left out first.
MOST_BEAMS = 2048

#: What a wall does to lines: cut them; reflect them, too; reflect only, as the mirrored sides
#: of a domain do, beyond which nobody is; or cut them and reflect them with opposite sign.
CUTS, REFLECTS, SIDE, NEGATES = range(4)


class Beams(NamedTuple):
    """The images of one place; number 0 is the place itself."""

    place: np.ndarray  #: (beams, 2) where the image is
    turn: np.ndarray  #: (beams, 4) matrix by which its frame is turned back to the place's
    right: np.ndarray  #: (beams, 2) the beam's right edge as a vector from the image
    left: np.ndarray  #: (beams, 2) the left edge
    wall: np.ndarray  #: (beams,) the wall that it is the last image in, -1 for the place
    parent: np.ndarray  #: (beams,) what it is the image of
    depth: np.ndarray  #: (beams,) how many walls reflect it
    sign: np.ndarray  #: (beams,) -1 after an odd number of walls that absorb, else 1


@inlined(arrays=True)
def empty_beams():
    """Room for the beams of one place."""
    most = MOST_BEAMS
    return Beams(
        np.empty((most, 2)), np.empty((most, 4)), np.empty((most, 2)), np.empty((most, 2)),
        np.empty(most, np.int32), np.empty(most, np.int32), np.empty(most, np.int32),
        np.empty(most, np.int8),
    )  # fmt: skip


@exact
def cross(ax, ay, bx, by):
    """Above 0 where b is to the left of a."""
    return ax * by - ay * bx


@exact
def put_wall(walls, wall, ax, ay, bx, by, free):
    """Write a wall: ends, its line as unit normal to the left and distance from 0, free side."""
    walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3] = ax, ay, bx, by
    length = np.hypot(bx - ax, by - ay)
    nx, ny = (ay - by) / length, (bx - ax) / length
    walls[wall, 4], walls[wall, 5], walls[wall, 6] = nx, ny, nx * ax + ny * ay
    walls[wall, 7] = free


@exact
def side_of(walls, wall, x, y):
    """How far (x, y) is to the left of a wall's line, to rounding."""
    return walls[wall, 4] * x + walls[wall, 5] * y - walls[wall, 6]


@exact
def clipped(low, high, at_low, at_high):
    """The part of [low, high] in which a linear function, given at 0 and at 1, is above 0."""
    slope = at_high - at_low
    if slope == 0.0:
        return low, (high if at_low > 0.0 else low)
    root = -at_low / slope
    return (max(low, root), high) if slope > 0.0 else (low, min(high, root))


@exact
def window(beams, beam, walls, wall):
    """The part of a wall that a beam falls on, as shares of its length: (low, high)."""
    ax, ay, bx, by = walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
    low, high = 0.0, 1.0
    last = beams.wall[beam]
    if last >= 0:
        x, y = beams.place[beam, 0], beams.place[beam, 1]
        ax, ay, bx, by = ax - x, ay - y, bx - x, by - y
        u, v = beams.right[beam, 0], beams.right[beam, 1]
        low, high = clipped(low, high, cross(u, v, ax, ay), cross(u, v, bx, by))
        u, v = beams.left[beam, 0], beams.left[beam, 1]
        low, high = clipped(low, high, cross(ax, ay, u, v), cross(bx, by, u, v))
        front = -1.0 if side_of(walls, last, x, y) > 0.0 else 1.0
        low, high = clipped(
            low, high, front * side_of(walls, last, x + ax, y + ay),
            front * side_of(walls, last, x + bx, y + by),
        )  # fmt: skip
    return low, high


@exact
def reflect_in(beams, beam, new, walls, wall, low, high):
    """Make the image of an image in a part of a wall."""
    ax, ay = walls[wall, 0], walls[wall, 1]
    along_x, along_y = walls[wall, 2] - ax, walls[wall, 3] - ay
    nx, ny = walls[wall, 4], walls[wall, 5]
    x, y = beams.place[beam, 0], beams.place[beam, 1]
    twice = 2.0 * side_of(walls, wall, x, y)
    x, y = x - twice * nx, y - twice * ny
    beams.place[new, 0], beams.place[new, 1] = x, y
    for line in (0, 2):
        one, two = beams.turn[beam, line], beams.turn[beam, line + 1]
        into = 2.0 * (one * nx + two * ny)
        beams.turn[new, line], beams.turn[new, line + 1] = one - into * nx, two - into * ny
    if twice > 0.0:  # seen from the right of the wall, its second end is the right one
        low, high = high, low
    beams.right[new, 0], beams.right[new, 1] = ax + low * along_x - x, ay + low * along_y - y
    beams.left[new, 0], beams.left[new, 1] = ax + high * along_x - x, ay + high * along_y - y
    beams.wall[new], beams.parent[new] = wall, beam
    beams.depth[new] = beams.depth[beam] + 1


@exact
def reaches(beams, beam, walls, wall, low, high, radius):
    """Whether a part of a wall is nearer to an image than the core radius."""
    x, y = beams.place[beam, 0], beams.place[beam, 1]
    along_x, along_y = walls[wall, 2] - walls[wall, 0], walls[wall, 3] - walls[wall, 1]
    from_x, from_y = x - walls[wall, 0], y - walls[wall, 1]
    share = (from_x * along_x + from_y * along_y) / (along_x * along_x + along_y * along_y)
    share = min(max(share, low), high)
    return np.hypot(from_x - share * along_x, from_y - share * along_y) < radius


@exact
def cuts(walls, wall, px, py, qx, qy, clearance):
    """Whether a wall cuts the line from p to q, ends included: exact.

    Most walls have both ends clearly on one side, which is quick to see.
    """
    sure = 0.1 * clearance
    p_side, q_side = side_of(walls, wall, px, py), side_of(walls, wall, qx, qy)
    if (p_side > sure and q_side > sure) or (p_side < -sure and q_side < -sure):
        return False
    ax, ay, bx, by = walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
    return meeting(px, py, qx, qy, ax, ay, bx, by) != MISS


@exact
def in_sight(walls, kind, count, px, py, qx, qy, clearance):
    """Whether no wall cuts the line from p to q."""
    for wall in range(count):
        if kind[wall] != SIDE and cuts(walls, wall, px, py, qx, qy, clearance):
            return False
    return True


@exact
def turning_place(walls, wall, x, y, image_x, image_y, clearance):
    """Where a line from (x, y) to an image turns: a little in front of the wall."""
    here, there = side_of(walls, wall, x, y), side_of(walls, wall, image_x, image_y)
    share = here / (here - there)
    ax, ay = walls[wall, 0], walls[wall, 1]
    nx, ny = walls[wall, 4], walls[wall, 5]
    length = (walls[wall, 2] - ax) * ny - (walls[wall, 3] - ay) * nx
    at = (x + share * (image_x - x) - ax) * ny - (y + share * (image_y - y) - ay) * nx
    at = min(max(at, 2.0 * clearance), length - 2.0 * clearance)
    off = 0.25 * clearance if here > 0.0 else -0.25 * clearance
    return ax + at * ny + off * nx, ay - at * nx + off * ny


@exact
def hidden(beams, beam, walls, kind, count, wall, low, high, clearance):
    """Whether a single wall hides a part of a wall from a beam: it cuts the lines to both ends."""
    x, y, last = beams.place[beam, 0], beams.place[beam, 1], beams.wall[beam]
    ax, ay = walls[wall, 0], walls[wall, 1]
    along_x, along_y = walls[wall, 2] - ax, walls[wall, 3] - ay
    off = 0.25 * clearance if side_of(walls, wall, x, y) > 0.0 else -0.25 * clearance
    ax, ay = ax + off * walls[wall, 4], ay + off * walls[wall, 5]
    one_x, one_y = ax + low * along_x, ay + low * along_y
    two_x, two_y = ax + high * along_x, ay + high * along_y
    from_x, from_y, at_x, at_y = x, y, x, y
    if last >= 0:
        from_x, from_y = turning_place(walls, last, one_x, one_y, x, y, clearance)
        at_x, at_y = turning_place(walls, last, two_x, two_y, x, y, clearance)
    for other in range(count):
        if (
            kind[other] != SIDE
            and other != wall
            and other != last
            and cuts(walls, other, from_x, from_y, one_x, one_y, clearance)
            and cuts(walls, other, at_x, at_y, two_x, two_y, clearance)
        ):
            return True
    return False


@exact
def put_facing_first(walls, kind, count, x, y, clearance):
    """Put the walls first that may be seen from (x, y), outside of all obstacles; their number.

    The other walls of solid obstacles are seen from inside: lines from here that meet one
    have met another before.
    """
    facing = 0
    for wall in range(count):
        if side_of(walls, wall, x, y) * walls[wall, 7] >= -clearance:
            if facing < wall:
                for part in range(8):
                    walls[facing, part], walls[wall, part] = walls[wall, part], walls[facing, part]
                kind[facing], kind[wall] = kind[wall], kind[facing]
            facing += 1
    return facing


@exact
def find_beams(beams, x, y, walls, kind, count, radius, clearance):
    """Find the images of (x, y) in ``count`` walls, and images of those; how many there are."""
    beams.place[0, 0], beams.place[0, 1] = x, y
    beams.turn[0, 0], beams.turn[0, 1], beams.turn[0, 2], beams.turn[0, 3] = 1.0, 0.0, 0.0, 1.0
    beams.wall[0], beams.parent[0], beams.depth[0], beams.sign[0] = -1, -1, 0, 1
    found, beam = 1, 0
    while beam < found:
        if beams.depth[beam] < MOST_REFLECTIONS:
            for wall in range(count):
                if kind[wall] == CUTS or wall == beams.wall[beam] or found == MOST_BEAMS:
                    continue
                side = side_of(walls, wall, beams.place[beam, 0], beams.place[beam, 1])
                if side * walls[wall, 7] < 0.0:
                    continue  # it would be met from inside
                low, high = window(beams, beam, walls, wall)
                if not (low < high and reaches(beams, beam, walls, wall, low, high, radius)):
                    continue
                if not hidden(beams, beam, walls, kind, count, wall, low, high, clearance):
                    reflect_in(beams, beam, found, walls, wall, low, high)
                    beams.sign[found] = (
                        -beams.sign[beam] if kind[wall] == NEGATES else beams.sign[beam]
                    )
                    found += 1
        beam += 1
    return found


@exact
def in_beam(beams, beam, walls, x, y, edge):
    """Whether (x, y) is in a beam, in front of its wall.

    A line through the end of a wall, as from a place to its image in a corner, is that of
    the beam which it is the right edge of: of one beam only, whatever the rounding.  The
    beam's edges are turned by ``edge``, an area far above the rounding.
    """
    image_x, image_y = beams.place[beam, 0], beams.place[beam, 1]
    u, v = x - image_x, y - image_y
    if cross(beams.right[beam, 0], beams.right[beam, 1], u, v) <= -edge:
        return False
    if cross(u, v, beams.left[beam, 0], beams.left[beam, 1]) <= edge:
        return False
    wall = beams.wall[beam]
    return side_of(walls, wall, x, y) * side_of(walls, wall, image_x, image_y) < 0.0


@exact
def seen_in(beams, beam, walls, kind, count, x, y, clearance):
    """Whether (x, y), in a beam, sees its place: no wall cuts the line from wall to wall.

    The line turns a little in front of each wall.  All of its legs are then tried exactly
    on all walls, so that nothing leaks where walls touch.
    """
    while beam > 0:
        wall = beams.wall[beam]
        next_x, next_y = turning_place(
            walls, wall, x, y, beams.place[beam, 0], beams.place[beam, 1], clearance
        )
        if not in_sight(walls, kind, count, x, y, next_x, next_y, clearance):
            return False
        x, y = next_x, next_y
        beam = beams.parent[beam]
    return in_sight(walls, kind, count, x, y, beams.place[0, 0], beams.place[0, 1], clearance)
