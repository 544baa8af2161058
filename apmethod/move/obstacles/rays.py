"""The first wall that a displacement meets, found from domain to domain (paper 2.5.1, 2.5.3).

A ray starts in the domain that its agent remembers, tries the walls listed there, and goes
on through the side by which it leaves, to the brother, or an uncle, beyond it.  In an empty
domain that it does not leave there is nothing to try.
"""

from typing import NamedTuple

import numpy as np

from apmethod.compile import compiled
from apmethod.move.obstacles.borrowing import borrowing, exact
from apmethod.move.obstacles.predicates import MISS, meeting
from apmethod.move.obstacles.tree import LEAF

#: When a ray is shot: before any obstacle has moved, or after all have.  A number k between
#: is while the k-th moving obstacle moves: those before it have, and it is not in the way.
BEFORE, AFTER = -1, 2**30 - 1
#: The walls as they stand in their own obstacle's frame.
OWN = -2
#: Turn of walls that never move.
STILL = 2**30

#: Rays that are worth a thread of their own.
RAYS_A_BLOCK = 5000


class Walls(NamedTuple):
    """The obstacles' sides, by number."""

    ends: np.ndarray  #: (3, walls, 4) ax, ay, bx, by: before the step, after it, in own frame
    turn: np.ndarray  #: (walls,) when in a step its obstacle moves, or `STILL`
    obstacle: np.ndarray  #: (walls,) number of the obstacle
    free: np.ndarray  #: (walls,) where agents can be: 1 to the left of it, -1 right, 0 both


@exact
def place_of(walls, wall, now):
    """Which of `Walls.ends` holds at a time; -1 for a wall that is not in the way."""
    if now == BEFORE:
        return 0
    if now == OWN:
        return 2
    turn = walls.turn[wall]
    if turn == now:
        return -1
    return 1 if turn < now else 0


@exact
def contains(limits, domain, x, y):
    """Whether a domain has (x, y), its limits included."""
    return (
        limits[domain, 0] <= x
        and x <= limits[domain, 2]
        and limits[domain, 1] <= y
        and y <= limits[domain, 3]
    )


@exact
def in_empty_leaf(tree, domain, px, py, qx, qy):
    """Whether ``domain`` is an empty leaf that has two places."""
    return (
        domain >= 0
        and domain < len(tree.axis)
        and tree.first[domain] == tree.last[domain]
        and tree.axis[domain] == LEAF
        and contains(tree.limits, domain, px, py)
        and contains(tree.limits, domain, qx, qy)
    )


@exact
def find_domain(tree, domain, x, y):
    """The leaf that has (x, y): ``domain``, if it does, or found from the root."""
    known = domain >= 0 and domain < len(tree.axis) and tree.axis[domain] == LEAF
    if known and contains(tree.limits, domain, x, y):
        return domain
    domain = 0
    while tree.axis[domain] != LEAF:
        coordinate = x if tree.axis[domain] == 0 else y
        domain = tree.sons[domain, 0 if coordinate < tree.plane[domain] else 1]
    return domain


@exact
def way_out(limits, domain, px, py, dx, dy):
    """(share of the way, side) where a ray from p leaves a domain; the share may be inf."""
    share, side = np.inf, -1
    if dx > 0.0:
        share, side = (limits[domain, 2] - px) / dx, 2
    elif dx < 0.0:
        share, side = (limits[domain, 0] - px) / dx, 0
    if dy > 0.0:
        up = (limits[domain, 3] - py) / dy
        if up < share:
            share, side = up, 3
    elif dy < 0.0:
        down = (limits[domain, 1] - py) / dy
        if down < share:
            share, side = down, 1
    return share, side


@exact
def next_domain(tree, domain, side, x, y, dx, dy):
    """The leaf beyond a side of ``domain`` at the point (x, y) of that side; -1 for none."""
    other = tree.beyond[domain, side]
    while other >= 0 and tree.axis[other] != LEAF:
        axis = tree.axis[other]
        coordinate, ahead = (x, dx) if axis == 0 else (y, dy)
        plane = tree.plane[other]
        if axis == side % 2:
            above = side < 2
        else:  # a ray on the plane itself goes to the domain that lies ahead
            above = coordinate > plane or (coordinate == plane and ahead > 0.0)
        other = tree.sons[other, 1 if above else 0]
    return other


@exact
def first_hit(tree, walls, now, domain, px, py, qx, qy):
    """The first wall on the way from p to q, ends included.

    Args:
        tree: the tree over the walls.
        walls: the walls.
        now: when, see `BEFORE`.
        domain: the leaf that p is in.
        px, py, qx, qy: the way.

    Returns:
        (share of the way or `MISS`, wall or -1, walls tried).  Of walls that are met at
        the same share it is the one of the lowest number.
    """
    dx, dy = qx - px, qy - py
    x, y = px, py
    entered = 0.0
    best, hit, tried = MISS, -1, 0
    while domain >= 0:
        for k in range(tree.first[domain], tree.last[domain]):
            wall = tree.listed[k]
            place = place_of(walls, wall, now)
            if place < 0:
                continue
            tried += 1
            a_x, a_y = walls.ends[place, wall, 0], walls.ends[place, wall, 1]
            b_x, b_y = walls.ends[place, wall, 2], walls.ends[place, wall, 3]
            share = meeting(px, py, qx, qy, a_x, a_y, b_x, b_y)
            if share < best or (share == best and share <= 1.0 and wall < hit):
                best, hit = share, wall
        if contains(tree.limits, domain, qx, qy):
            break
        # Shares and places only grow, whatever the rounding, so that no domain comes twice.
        share, side = way_out(tree.limits, domain, px, py, dx, dy)
        entered = max(entered, share)
        if best <= entered or side < 0:
            break  # walls are listed a margin around domains: none in the next comes before
        x = max(x, px + entered * dx) if dx > 0.0 else min(x, px + entered * dx)
        y = max(y, py + entered * dy) if dy > 0.0 else min(y, py + entered * dy)
        if side % 2 == 0:
            x = tree.limits[domain, side]
        else:
            y = tree.limits[domain, side]
        domain = next_domain(tree, domain, side, x, y, dx, dy)
    return best, hit, tried


# -- for many rays ---------------------------------------------------------------------


@borrowing
def first_hits(first, last, tree, walls, now, starts, ends, domains, shares, hits, tried):
    """`first_hit` for rays ``first`` to ``last``; remembers the domain where each starts."""
    for k in range(first, last):
        px, py = starts[k, 0], starts[k, 1]
        domain = find_domain(tree, domains[k], px, py)
        domains[k] = domain
        shares[k], hits[k], tried[k] = MISS, -1, 0
        empty = tree.first[domain] == tree.last[domain]
        if not (empty and contains(tree.limits, domain, ends[k, 0], ends[k, 1])):
            shares[k], hits[k], tried[k] = first_hit(
                tree, walls, now, domain, px, py, ends[k, 0], ends[k, 1]
            )


@borrowing
def brute_force_hits(first, last, walls, now, starts, ends, shares, hits):
    """The same by trying every wall: the oracle of `first_hits`."""
    for k in range(first, last):
        shares[k], hits[k] = MISS, -1
        for wall in range(len(walls.turn)):
            place = place_of(walls, wall, now)
            if place < 0:
                continue
            a_x, a_y = walls.ends[place, wall, 0], walls.ends[place, wall, 1]
            b_x, b_y = walls.ends[place, wall, 2], walls.ends[place, wall, 3]
            share = meeting(starts[k, 0], starts[k, 1], ends[k, 0], ends[k, 1], a_x, a_y, b_x, b_y)
            if share < shares[k]:
                shares[k], hits[k] = share, wall


# -- what sums over pairs ask ----------------------------------------------------------


@exact
def blocked(tree, walls, x_i, y_i, x_j, y_j):
    """Whether a wall cuts the line of sight between two places, its ends included.

    For compiled passes, between two steps or in a step before obstacles have moved.
    """
    domain = find_domain(tree, -1, x_i, y_i)
    _, hit, _ = first_hit(tree, walls, BEFORE, domain, x_i, y_i, x_j, y_j)
    return hit >= 0


@borrowing
def pairs_blocked(first, last, tree, walls, positions, i, j, result):
    """`blocked` for pairs of rows of ``positions``."""
    for k in range(first, last):
        result[k] = blocked(
            tree, walls, positions[i[k], 0], positions[i[k], 1],
            positions[j[k], 0], positions[j[k], 1],
        )  # fmt: skip


@exact
def to_wall(x, y, ax, ay, bx, by):
    """From the nearest point of a wall to (x, y): a vector, and where that point is, 0 to 1."""
    along_x, along_y = bx - ax, by - ay
    share = ((x - ax) * along_x + (y - ay) * along_y) / (along_x * along_x + along_y * along_y)
    share = min(max(share, 0.0), 1.0)
    if share <= 0.5:  # counted from the nearer end, where it is more exact
        return (x - ax) - share * along_x, (y - ay) - share * along_y, share
    return (x - bx) + (1.0 - share) * along_x, (y - by) + (1.0 - share) * along_y, share


@exact
def leaves_near(tree, x, y, distance, waiting, leaves):
    """Write down the leaves in the square of that half side around (x, y); how many.

    ``waiting`` is scratch; it and ``leaves`` have room for all domains.
    """
    waiting[0] = 0
    left, count = 1, 0
    while left > 0:
        left -= 1
        domain = waiting[left]
        axis = tree.axis[domain]
        if axis == LEAF:
            leaves[count] = domain
            count += 1
            continue
        coordinate = x if axis == 0 else y
        if coordinate - distance <= tree.plane[domain]:
            waiting[left] = tree.sons[domain, 0]
            left += 1
        if coordinate + distance >= tree.plane[domain]:
            waiting[left] = tree.sons[domain, 1]
            left += 1
    return count


@compiled
def near_walls(first, last, tree, walls, points, distance, result):
    """Which points have a wall at most ``distance`` away, ends of the step included."""
    waiting, leaves = np.empty(len(tree.axis), np.int32), np.empty(len(tree.axis), np.int32)
    known = -1  # points come in an order, often: the next one may be in the same leaf
    for k in range(first, last):
        x, y = points[k, 0], points[k, 1]
        result[k] = False
        if in_empty_leaf(tree, known, x - distance, y - distance, x + distance, y + distance):
            continue
        count = leaves_near(tree, x, y, distance, waiting, leaves)
        known = leaves[0] if count == 1 else -1
        for number in range(count):
            leaf = leaves[number]
            for item in range(tree.first[leaf], tree.last[leaf]):
                wall = tree.listed[item]
                for place in range(2):
                    side = walls.ends[place, wall]
                    dx, dy, _ = to_wall(x, y, side[0], side[1], side[2], side[3])
                    if dx * dx + dy * dy <= distance * distance:
                        result[k] = True
            if result[k]:
                break
