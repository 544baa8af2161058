"""Carrying agents along their displacements, from wall to wall (paper 2.5).

No agent ends up inside an obstacle or behind a wall, by two rules that hold for every leg
of its way:

* a leg is gone only if the exact test says that it meets no wall, ends included;
* it ends at least half the *clearance* away from every wall, a length far below the size of
  the scene (1e-9 of it) and far above the rounding of a place.

Where a leg meets a wall, the agent goes on from a clearance in front of it.  If no place
keeps the rules, because a corner is too narrow, the agent stays where the leg began, which
keeps them.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from apmethod.move.obstacles.behaviour import ABSORB, SLIDE, STICK, answer_of
from apmethod.move.obstacles.borrowing import borrowing, called, exact
from apmethod.move.obstacles.predicates import orientation
from apmethod.move.obstacles.rays import BEFORE, find_domain, first_hit, place_of, to_wall

#: An agent that is still bouncing after so many legs rests where it is.
MOST_LEGS = 64
#: Instead of a behaviour's code: each wall's own, or to stop there as trial places do.
BEHAVE, STOP = -1, -2
#: Fate of an agent that goes on; absorbed ones have their obstacle's number.
FREE = -1


class Bodies(NamedTuple):
    """What the obstacles do, by their number."""

    code: np.ndarray  #: (obstacles,) behaviour
    drift: np.ndarray  #: (obstacles, 5) velocity x and y, spin, pivot x and y
    clearance: float  #: how far in front of a wall an agent goes on


@exact
def leg_end(x, y, to_x, to_y, along_x, along_y):
    """Where a leg ends: (x, y, share of the displacement, side of the domain's border or -1)."""
    share, side = 1.0, -1
    for axis in range(2):
        lower, upper, kind = along_x if axis == 0 else along_y
        here, there = (x, to_x) if axis == 0 else (y, to_y)
        if kind == 0 or (lower <= there and there <= upper):
            continue
        border = lower if there < here else upper
        part = max((border - here) / (there - here), 0.0)
        if part < share or side < 0:
            share, side = part, (axis if there < here else axis + 2)
    if side < 0:
        return to_x, to_y, share, side
    end_x, end_y = x + share * (to_x - x), y + share * (to_y - y)
    if side == 0 or side == 2:
        end_x = along_x[0] if side == 0 else along_x[1]
    elif side == 1 or side == 3:
        end_y = along_y[0] if side == 1 else along_y[1]
    return end_x, end_y, share, side


@exact
def within(x, y, along_x, along_y):
    """Whether a place is inside the domain's borders."""
    in_x = along_x[2] == 0 or (along_x[0] <= x and x <= along_x[1])
    in_y = along_y[2] == 0 or (along_y[0] <= y and y <= along_y[1])
    return in_x and in_y


@called
def nearest_wall(tree, walls, now, domain, x, y):
    """The nearest wall listed in the leaf of (x, y): (from it to there, distance squared)."""
    best, best_x, best_y = np.inf, 0.0, 0.0
    for k in range(tree.first[domain], tree.last[domain]):
        wall = tree.listed[k]
        place = place_of(walls, wall, now)
        if place < 0:
            continue
        ax, ay = walls.ends[place, wall, 0], walls.ends[place, wall, 1]
        bx, by = walls.ends[place, wall, 2], walls.ends[place, wall, 3]
        from_x, from_y, _ = to_wall(x, y, ax, ay, bx, by)
        square = from_x * from_x + from_y * from_y
        if square < best:
            best, best_x, best_y = square, from_x, from_y
    return best_x, best_y, best


@called
def may_go(tree, walls, now, clearance, domain, px, py, qx, qy, along_x, along_y):
    """Whether the leg from p, in ``domain``, to q keeps the rules; and the leaf of q."""
    there = find_domain(tree, domain, qx, qy)
    _, _, square = nearest_wall(tree, walls, now, there, qx, qy)
    if square < 0.25 * clearance * clearance or not within(qx, qy, along_x, along_y):
        return False, there
    _, wall, _ = first_hit(tree, walls, now, domain, px, py, qx, qy)
    return wall < 0, there


@called
def landing(tree, walls, now, clearance, domain, x, y, dx, dy, wall, share, along_x, along_y):
    """Where an agent goes on from that meets ``wall`` after ``share`` of its displacement.

    Returns:
        (x, y, its leaf, the wall's unit normal x and y on the agent's side).
    """
    place = place_of(walls, wall, now)
    ax, ay = walls.ends[place, wall, 0], walls.ends[place, wall, 1]
    bx, by = walls.ends[place, wall, 2], walls.ends[place, wall, 3]
    length, way = np.hypot(bx - ax, by - ay), np.hypot(dx, dy)
    side = orientation(ax, ay, bx, by, x, y)
    apart = abs(side) / length
    # First a little before the wall along the way, then a clearance before it at right angles.
    best_x, best_y, there, found = x, y, domain, False
    for attempt in range(2):
        if found or way == 0.0:
            break
        if attempt == 0:
            part = share - 2.0 * clearance / way
        else:
            part = share * (1.0 - clearance / apart) if apart > clearance else 0.0
        if part > 0.0:
            try_x, try_y = x + part * dx, y + part * dy
            found, leaf = may_go(
                tree, walls, now, clearance, domain, x, y, try_x, try_y, along_x, along_y
            )
            if found:
                best_x, best_y, there = try_x, try_y, leaf
    _, _, at = to_wall(best_x, best_y, ax, ay, bx, by)
    if way > 0.0 and (side == 0.0 or (found and (at == 0.0 or at == 1.0))):
        return best_x, best_y, there, -dx / way, -dy / way  # onto the wall's end
    turn = 1.0 if side >= 0.0 else -1.0
    return best_x, best_y, there, turn * (ay - by) / length, turn * (bx - ax) / length


@exact
def wall_velocity(drift, obstacle, x, y):
    """How fast the place (x, y) of an obstacle moves."""
    spin = drift[obstacle, 2]
    return (
        drift[obstacle, 0] - spin * (y - drift[obstacle, 4]),
        drift[obstacle, 1] + spin * (x - drift[obstacle, 3]),
    )


@cache
def carry_with(functions: tuple[Callable, ...]) -> Callable:
    """`carry` for obstacles whose own behaviours are ``functions``."""
    answer = answer_of(functions)

    @called
    def carry(tree, walls, bodies, now, how, domain, x, y, to_x, to_y, u, v, along_x, along_y):
        """Carry an agent in leaf ``domain`` to (to_x, to_y); (u, v) is its velocity.

        Returns:
            (x, y, u, v, its leaf, fate, obstacle that it sticks to or -1, walls tried, whether
            a wall was touched).
        """
        fate, held, tried, touched = FREE, -1, 0, False
        clearance = bodies.clearance
        for _ in range(MOST_LEGS):
            dx, dy = to_x - x, to_y - y
            if dx == 0.0 and dy == 0.0:
                break
            qx, qy, part, side = leg_end(x, y, to_x, to_y, along_x, along_y)
            share, wall, count = first_hit(tree, walls, now, domain, x, y, qx, qy)
            tried += count
            if wall < 0:
                there = find_domain(tree, domain, qx, qy)
                off_x, off_y, square = nearest_wall(tree, walls, now, there, qx, qy)
                if square < 0.25 * clearance * clearance:
                    # It ends too near to a wall that it does not meet: stand off from it.
                    touched = True
                    if square > 0.0:
                        scale = clearance / np.sqrt(square) - 1.0
                        qx, qy = qx + scale * off_x, qy + scale * off_y
                        found, there = may_go(
                            tree, walls, now, clearance, domain, x, y, qx, qy, along_x, along_y
                        )
                        if found:
                            x, y, domain = qx, qy, there
                    break
                x, y, domain = qx, qy, there
                if side < 0:
                    break
                # On from the border: mirrored, along it, or in by the opposite side.
                dx, dy = (1.0 - part) * dx, (1.0 - part) * dy
                kind = along_x[2] if side % 2 == 0 else along_y[2]
                if kind == 2:
                    if side % 2 == 0:
                        x = along_x[1] if side == 0 else along_x[0]
                    else:
                        y = along_y[1] if side == 1 else along_y[0]
                    domain = find_domain(tree, domain, x, y)
                elif side % 2 == 0:
                    dx = 0.0 if how == SLIDE else -dx
                    u = -u
                else:
                    dy = 0.0 if how == SLIDE else -dy
                    v = -v
                to_x, to_y = x + dx, y + dy
                continue
            touched = True
            hit_x, hit_y = x + share * (qx - x), y + share * (qy - y)
            x, y, domain, nx, ny = landing(
                tree, walls, now, clearance, domain, x, y, qx - x, qy - y, wall, share,
                along_x, along_y,
            )  # fmt: skip
            if how == STOP:
                break
            obstacle = walls.obstacle[wall]
            code = bodies.code[obstacle] if how == BEHAVE else how
            if code == ABSORB:
                fate = obstacle
                break
            wall_u, wall_v = wall_velocity(bodies.drift, obstacle, x, y)
            if (u - wall_u) * nx + (v - wall_v) * ny < 0.0:
                after_u, after_v = answer(code, u - wall_u, v - wall_v, nx, ny)
                u, v = wall_u + after_u, wall_v + after_v
            if code == STICK:
                held, u, v = obstacle, wall_u, wall_v
                break
            dx, dy = answer(code, (1.0 - share * part) * dx, (1.0 - share * part) * dy, nx, ny)
            # It has stopped a little before the wall: the way along the wall is not lost.
            along = (hit_y - y) * nx - (hit_x - x) * ny
            dx, dy = dx - along * ny, dy + along * nx
            if not (np.isfinite(dx) and np.isfinite(dy)):
                return dx, dy, u, v, domain, fate, held, tried, touched
            to_x, to_y = x + dx, y + dy
        return x, y, u, v, domain, fate, held, tried, touched

    return carry


@cache
def carry_all_with(functions: tuple[Callable, ...]) -> Callable:
    """`carry` for rows of the table, from ``start`` to where ``position`` says."""
    carry = carry_with(functions)

    @borrowing
    def carry_all(
        first, last, rows, tree, walls, bodies, how, along_x, along_y, start, position, velocity,
        domains, held, fate, tried,
    ):  # fmt: skip
        for k in range(first, last):
            row = rows[k]
            x, y = start[row, 0], start[row, 1]
            qx, qy = position[row, 0], position[row, 1]
            if held[row] >= 0 or fate[row] != FREE:
                position[row, 0], position[row, 1] = x, y
                continue
            if not (np.isfinite(qx) and np.isfinite(qy)):
                continue  # the step fails for it
            domain = find_domain(tree, domains[row], x, y)
            x, y, u, v, domain, fate[row], stuck, count, _ = carry(
                tree, walls, bodies, BEFORE, how, domain, x, y, qx, qy,
                velocity[row, 0], velocity[row, 1], along_x, along_y,
            )  # fmt: skip
            position[row, 0], position[row, 1] = x, y
            domains[row] = domain
            tried[row] += count
            if how == BEHAVE:
                velocity[row, 0], velocity[row, 1] = u, v
                held[row] = stuck

    return carry_all
