"""What holds agents off walls that take mass: the field g of `apmethod.move.obstacles.absorption`.

Beside a wall g = grad log f(d), d the distance, with f odd and 1 from a reach on; several walls'
add up.  Near a corner it is grad log phi, phi = r^a sin(a theta) being u there, and goes over
into that of the walls half way along the shorter one, or half the reach away.  Only what sees
the agent holds it off.
"""

import numpy as np

from apmethod.move.obstacles.beams import CUTS, NEGATES, cross, in_sight, side_of
from apmethod.move.obstacles.borrowing import exact
from apmethod.move.obstacles.rays import to_wall


@exact
def hold_off(x, y, walls, kind, count, reach, clearance):
    """g of all walls near (x, y) that absorb, and div g + |g|^2."""
    g_x, g_y, divergence = 0.0, 0.0, 0.0
    for wall in range(count):
        if kind[wall] != NEGATES:
            continue
        if side_of(walls, wall, x, y) * walls[wall, 7] >= -clearance:  # not from inside
            part_x, part_y, part = off_wall(x, y, walls, kind, count, wall, reach, clearance)
            g_x, g_y, divergence = g_x + part_x, g_y + part_y, divergence + part
        for end in range(2):
            part_x, part_y, part = off_corner(x, y, walls, kind, count, wall, end, reach, clearance)
            g_x, g_y, divergence = g_x + part_x, g_y + part_y, divergence + part
    return g_x, g_y, divergence + (g_x * g_x + g_y * g_y)


@exact
def seen(x, y, walls, kind, count, off_x, off_y, clearance):
    """Whether (x, y) sees what is at (x - off_x, y - off_y), on a wall."""
    distance = np.hypot(off_x, off_y)
    share = 1.0 - 2.0 * clearance / distance
    if share <= 0.0:
        return True
    return in_sight(walls, kind, count, x, y, x - share * off_x, y - share * off_y, clearance)


@exact
def off_wall(x, y, walls, kind, count, wall, reach, clearance):
    """grad log f of one wall, away from its ends, and its divergence."""
    off_x, off_y, share = to_wall(
        x, y, walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
    )
    distance = np.hypot(off_x, off_y)
    if distance >= reach or not seen(x, y, walls, kind, count, off_x, off_y, clearance):
        return 0.0, 0.0, 0.0
    # f(z) = (35 z - 35 z^3 + 21 z^5 - 5 z^7) / 16, whose derivatives vanish at z = 1.
    z, z_2 = distance / reach, (distance / reach) ** 2
    per_z = (35.0 - 35.0 * z_2 + 21.0 * z_2 * z_2 - 5.0 * z_2 * z_2 * z_2) / 16.0
    slope = 2.1875 * (1.0 - z_2) ** 3 / (per_z * z * reach)
    bend = -13.125 * (1.0 - z_2) ** 2 / (per_z * reach * reach)
    g_x, g_y = slope * off_x / distance, slope * off_y / distance
    divergence = bend - slope * slope
    if share == 0.0 or share == 1.0:  # round the corner; one of its walls counts it
        if not owns(x, y, walls, kind, count, wall, 0 if share == 0.0 else 2):
            return 0.0, 0.0, 0.0
        divergence += slope / distance
    for end in (0, 2):
        width = extent(walls, count, wall, end, reach)
        from_x, from_y = x - walls[wall, end], y - walls[wall, end + 1]
        away = np.hypot(from_x, from_y)
        if away < width:
            part, steep = faded(away / width)
            along = (g_x * from_x + g_y * from_y) / away
            divergence = part * divergence + steep / width * along
            g_x, g_y = part * g_x, part * g_y
    return g_x, g_y, divergence


@exact
def off_corner(x, y, walls, kind, count, wall, end, reach, clearance):
    """grad log phi near an end of a wall, and its divergence; phi = r^a sin(a theta).

    It is u itself between two walls that take mass at an angle w, with a = pi / w, and
    between one of them and a reflecting one, with a = pi / (2 w).  Past the end of a thin
    wall w = 2 pi.
    """
    at = 2 * end
    width = extent(walls, count, wall, at, reach)
    from_x, from_y = x - walls[wall, at], y - walls[wall, at + 1]
    away = np.hypot(from_x, from_y)
    if away >= width or not owns_corner(walls, kind, count, wall, at):
        return 0.0, 0.0, 0.0
    if not seen(x, y, walls, kind, count, from_x, from_y, clearance):
        return 0.0, 0.0, 0.0
    # The first walls that are met going round the corner from (x, y), to the left and right.
    left, right, left_kind, right_kind = 7.0, 7.0, CUTS, CUTS
    for other in range(count):
        for on in (0, 2):
            if not same_end(walls, wall, at, other, on):
                continue
            along_x = walls[other, 2 - on] - walls[other, on]
            along_y = walls[other, 3 - on] - walls[other, on + 1]
            turn = np.arctan2(cross(from_x, from_y, along_x, along_y),
                              from_x * along_x + from_y * along_y)  # fmt: skip
            turn = turn if turn > 0.0 else turn + 2.0 * np.pi
            if turn < left:
                left, left_kind = turn, kind[other]
            if 2.0 * np.pi - turn < right:
                right, right_kind = 2.0 * np.pi - turn, kind[other]
    if left_kind != NEGATES and right_kind != NEGATES:
        return 0.0, 0.0, 0.0
    both = left_kind == NEGATES and right_kind == NEGATES
    power = np.pi / ((1.0 if both else 2.0) * (left + right))
    if right_kind == NEGATES:
        around = power / np.tan(power * right)
    else:
        around = -power / np.tan(power * left)
    away_2 = away * away
    g_x = (power * from_x - around * from_y) / away_2
    g_y = (power * from_y + around * from_x) / away_2
    part, steep = faded(away / width)
    divergence = -(1.0 - part) * (g_x * g_x + g_y * g_y) - steep / width * power / away
    return (1.0 - part) * g_x, (1.0 - part) * g_y, divergence


@exact
def faded(z):
    """From 0 at z = 0 to 1 at z = 1, smoothly, and the slope."""
    return z * z * z * (10.0 - 15.0 * z + 6.0 * z * z), 30.0 * z * z * (1.0 - z) * (1.0 - z)


@exact
def same_end(walls, wall, at, other, on):
    """Whether the end of a wall that begins at column ``at`` is that of another one at ``on``."""
    x_too = walls[wall, at] == walls[other, on]
    return x_too and walls[wall, at + 1] == walls[other, on + 1]


@exact
def extent(walls, count, wall, at, reach):
    """How far round the end of a wall g is that of the corner."""
    width = 0.5 * reach
    for other in range(count):
        if same_end(walls, wall, at, other, 0) or same_end(walls, wall, at, other, 2):
            along_x = walls[other, 2] - walls[other, 0]
            along_y = walls[other, 3] - walls[other, 1]
            width = min(width, 0.5 * np.hypot(along_x, along_y))
    return width


@exact
def owns_corner(walls, kind, count, wall, at):
    """Whether a wall is the first of those that take mass and meet at its end."""
    for other in range(wall):
        here = same_end(walls, wall, at, other, 0) or same_end(walls, wall, at, other, 2)
        if here and kind[other] == NEGATES:
            return False
    return True


@exact
def owns(x, y, walls, kind, count, wall, at):
    """Whether the end of a wall is nearest to (x, y) of all there is, and this wall counts it."""
    for other in range(count):
        if other == wall or kind[other] != NEGATES:
            continue
        for on in (0, 2):
            if same_end(walls, wall, at, other, on):
                _, _, place = to_wall(
                    x, y, walls[other, 0], walls[other, 1], walls[other, 2], walls[other, 3]
                )
                if place != (0.0 if on == 0 else 1.0) or other < wall:
                    return False
    return True
