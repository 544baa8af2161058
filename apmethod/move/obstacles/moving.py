"""Obstacles that move: first the agents go while obstacles stand, then the other way round.

A moving obstacle meets a resting agent as an agent meets a resting obstacle: in the
obstacle's own frame the agent is displaced the other way, and is carried along that ray by
the very same rules.  Nothing tunnels, however large the step.  A turn is taken in pieces of
at most 0.1 radian, within which a wall at distance r from the pivot is off its true arc by
at most r * 0.1^2 / 8, about a thousandth of r; where a step ends it is off by nothing.

An agent that an obstacle pushes against another one slides along that one; if it cannot
get out of the way it is *squeezed*: it stays where it is, and is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from apmethod.move.obstacles.behaviour import SLIDE
from apmethod.move.obstacles.borrowing import borrowing, called, exact
from apmethod.move.obstacles.carry import (
    BEHAVE,
    FREE,
    Bodies,
    carry_with,
    may_go,
    nearest_wall,
    wall_velocity,
)
from apmethod.move.obstacles.predicates import orientation
from apmethod.move.obstacles.rays import OWN, find_domain, first_hit
from apmethod.move.obstacles.tree import LEAF, Tree

#: Largest turn that is taken as one piece, in radians.
TURN = 0.1

#: An agent that is still in the way after so many pushes is squeezed.
MOST_PUSHES = 100

#: The plane without borders, as passes take limits.
NO_BORDER = (-np.inf, np.inf, 0)


class Movers(NamedTuple):
    """The moving obstacles, by turn."""

    poses: np.ndarray  #: (movers, pieces + 1, 4) pivot x and y, cosine and sine of the turn
    pieces: np.ndarray  #: (movers,) pieces of a step
    obstacle: np.ndarray  #: (movers,) number of the obstacle
    bodies: Bodies  #: all obstacles as they are in their own frames, at rest
    homes: Tree  #: for each a leaf as wide as the plane, in its own frame


def poses_of(pivot: np.ndarray, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The poses of a step, of shape (pieces + 1, 4); place and turn change evenly in it.

    Args:
        pivot: where the pivot is at time 0.
        begin, end: the obstacle's pose, as it tells, where the step begins and ends.
    """
    pieces = max(1, int(np.ceil(abs(end[2] - begin[2]) / TURN)))
    share = np.arange(pieces + 1)[:, None] / pieces
    x, y, turn = ((1.0 - share) * begin + share * end).T
    return np.column_stack([pivot[0] + x, pivot[1] + y, np.cos(turn), np.sin(turn)])


def placed(own_walls: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Walls of an obstacle's own frame, (n, 4), where poses put them, (poses, n, 4)."""
    result = np.empty((len(poses), *own_walls.shape))
    x, y, cosine, sine = (part[:, None] for part in poses.T)
    for end in (0, 2):
        own_x, own_y = own_walls[:, end], own_walls[:, end + 1]
        result[:, :, end] = x + (cosine * own_x - sine * own_y)
        result[:, :, end + 1] = y + (sine * own_x + cosine * own_y)
    return result


def swept_bounds(ends: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """A box, (4,), that holds walls, (poses, n, 4), all through a step as resting agents see it."""
    corners = ends.reshape(-1, 2)
    turns = len(poses) > 2 or poses[0, 3] != poses[-1, 3]
    reach = np.abs(ends[0].reshape(-1, 2) - poses[0, :2]).max() * 2.0**0.5
    arc = reach * TURN**2 / 8.0 if turns else 0.0
    return np.concatenate([corners.min(axis=0) - arc, corners.max(axis=0) + arc])


def movers_of(
    poses: Sequence[np.ndarray], obstacles: Sequence[int], homes: Tree, bodies: Bodies
) -> Movers:
    """The obstacles that move in a step.

    Args:
        poses: of each, see `poses_of`.
        obstacles: their numbers.
        homes: see `homes_of`.
        bodies: what all obstacles do.
    """
    table = np.zeros((len(poses), max(map(len, poses)), 4))
    for k, pose in enumerate(poses):
        table[k, : len(pose)] = pose
    pieces = np.array([len(pose) - 1 for pose in poses], np.int32)
    at_rest = bodies._replace(drift=np.zeros_like(bodies.drift))
    return Movers(table, pieces, np.array(obstacles, np.int32), at_rest, homes)


def homes_of(walls: Sequence[np.ndarray]) -> Tree:
    """A leaf for each list of walls, all the plane wide and without neighbours."""
    count = len(walls)
    last = np.cumsum([len(numbers) for numbers in walls], dtype=np.int32)
    none = np.full(count, -1, np.int32)
    return Tree(
        axis=np.full(count, LEAF, np.int8),
        plane=np.zeros(count),
        sons=np.full((count, 2), -1, np.int32),
        father=none,
        limits=np.tile([-np.inf, -np.inf, np.inf, np.inf], (count, 1)),
        beyond=np.full((count, 4), -1, np.int32),
        owner=none,
        owner_side=np.zeros(count, np.int8),
        first=np.concatenate([[0], last])[:-1].astype(np.int32),
        last=last,
        listed=np.concatenate([np.empty(0, np.int32), *walls]).astype(np.int32),
    )


@exact
def to_own(poses, mover, piece, x, y):
    """A place as it is in a moving obstacle's own frame."""
    cosine, sine = poses[mover, piece, 2], poses[mover, piece, 3]
    x, y = x - poses[mover, piece, 0], y - poses[mover, piece, 1]
    return cosine * x + sine * y, cosine * y - sine * x


@exact
def from_own(poses, mover, piece, x, y):
    """The place of the plane that is (x, y) in a moving obstacle's own frame."""
    cosine, sine = poses[mover, piece, 2], poses[mover, piece, 3]
    return (
        poses[mover, piece, 0] + (cosine * x - sine * y),
        poses[mover, piece, 1] + (sine * x + cosine * y),
    )


@called
def out_of_the_way(homes, walls, clearance, turn, px, py, qx, qy):
    """The place nearest to q in front of the wall of a mover that is between p and q."""
    _, wall, _ = first_hit(homes, walls, OWN, turn, px, py, qx, qy)
    if wall < 0:  # it is in front of all of them, but too near to one
        off_x, off_y, square = nearest_wall(homes, walls, OWN, turn, qx, qy)
        scale = clearance / np.sqrt(square) - 1.0 if square > 0.0 else 0.0
        return qx + scale * off_x, qy + scale * off_y
    ax, ay = walls.ends[2, wall, 0], walls.ends[2, wall, 1]
    bx, by = walls.ends[2, wall, 2], walls.ends[2, wall, 3]
    length = np.hypot(bx - ax, by - ay)
    nx, ny = (ay - by) / length, (bx - ax) / length
    if orientation(ax, ay, bx, by, px, py) < 0.0:
        nx, ny = -nx, -ny
    behind = (ax - qx) * nx + (ay - qy) * ny
    return qx + (behind + clearance) * nx, qy + (behind + clearance) * ny


@exact
def next_mover(tree, walls, domain, after):
    """The next obstacle to move after turn ``after`` whose way touches a leaf; -1 for none."""
    found = -1
    for k in range(tree.first[domain], tree.last[domain]):
        turn = walls.turn[tree.listed[k]]
        if after < turn and turn < 2**30 and (found < 0 or turn < found):
            found = turn
    return found


@cache
def sweep_all_with(functions: tuple[Callable, ...]) -> Callable:
    """A pass that moves the obstacles while the agents in ``rows`` rest.

    It writes the fate of an agent that is squeezed as -2 - obstacle.
    """
    carry = carry_with(functions)

    @called
    def pushed(tree, walls, bodies, movers, turn, piece, domain, x, y, to_x, to_y, limits):
        """Push an agent from (x, y) to a place, by a piece of a mover's way.

        Where other walls are in between it slides along them, as far as the mover wants it.

        Returns:
            (x, y, leaf, whether there was a way).
        """
        along_x, along_y = limits
        clearance = bodies.clearance
        own_x, own_y = to_own(movers.poses, turn, piece, x, y)
        for _ in range(MOST_PUSHES):
            free, there = may_go(
                tree, walls, turn, clearance, domain, x, y, to_x, to_y, along_x, along_y
            )
            if free:
                x, y, domain = to_x, to_y, there
            else:
                slid = carry(
                    tree, walls, bodies, turn, SLIDE, domain, x, y, to_x - x, to_y - y, 0.0, 0.0,
                    along_x, along_y,
                )  # fmt: skip
                x, y, domain = slid[0], slid[1], slid[4]
            end_x, end_y = to_own(movers.poses, turn, piece + 1, x, y)
            free, _ = may_go(
                movers.homes, walls, OWN, clearance, turn, own_x, own_y, end_x, end_y,
                NO_BORDER, NO_BORDER,
            )  # fmt: skip
            if free:
                return x, y, domain, True
            end_x, end_y = out_of_the_way(
                movers.homes, walls, clearance, turn, own_x, own_y, end_x, end_y
            )
            to_x, to_y = from_own(movers.poses, turn, piece + 1, end_x, end_y)
        return x, y, domain, False

    @called
    def sweep(tree, walls, bodies, movers, turn, domain, x, y, u, v, stuck, limits):
        """Move one obstacle while an agent rests; as `carry` gives, with a squeezed fate."""
        fate, held, tried = FREE, stuck, 0
        obstacle = movers.obstacle[turn]
        for piece in range(movers.pieces[turn]):
            own_x, own_y = to_own(movers.poses, turn, piece, x, y)
            if held == obstacle:
                end_x, end_y = own_x, own_y
            else:
                to_x, to_y = to_own(movers.poses, turn, piece + 1, x, y)
                wall_u, wall_v = wall_velocity(bodies.drift, obstacle, x, y)
                cosine, sine = movers.poses[turn, piece, 2], movers.poses[turn, piece, 3]
                own_u = cosine * (u - wall_u) + sine * (v - wall_v)
                own_v = cosine * (v - wall_v) - sine * (u - wall_u)
                end_x, end_y, own_u, own_v, _, fate, now_held, count, touched = carry(
                    movers.homes, walls, movers.bodies, OWN, BEHAVE, turn, own_x, own_y,
                    to_x - own_x, to_y - own_y, own_u, own_v, NO_BORDER, NO_BORDER,
                )  # fmt: skip
                tried += count
                if fate != FREE:
                    break
                if not touched:
                    continue
                held = now_held  # what it has stuck to before has lost it
                u = wall_u + cosine * own_u - sine * own_v
                v = wall_v + sine * own_u + cosine * own_v
            to_x, to_y = from_own(movers.poses, turn, piece + 1, end_x, end_y)
            to_x, to_y, there, free = pushed(
                tree, walls, bodies, movers, turn, piece, domain, x, y, to_x, to_y, limits
            )
            if not free:
                fate = -2 - obstacle
                break
            x, y, domain = to_x, to_y, there
        return x, y, u, v, domain, fate, held, tried

    @borrowing
    def sweep_all(
        first, last, rows, tree, walls, bodies, movers, along_x, along_y, position, velocity,
        domains, held, fate, tried,
    ):  # fmt: skip
        for k in range(first, last):
            row = rows[k]
            x, y = position[row, 0], position[row, 1]
            if fate[row] != FREE or not (np.isfinite(x) and np.isfinite(y)):
                continue
            domain = find_domain(tree, domains[row], x, y)
            domains[row] = domain
            if tree.first[domain] == tree.last[domain]:
                continue
            turn = next_mover(tree, walls, domain, -1)
            while turn >= 0 and fate[row] == FREE:
                x, y, u, v, domain, fate[row], held[row], count = sweep(
                    tree, walls, bodies, movers, turn, domain, x, y,
                    velocity[row, 0], velocity[row, 1], held[row], (along_x, along_y),
                )  # fmt: skip
                velocity[row, 0], velocity[row, 1] = u, v
                tried[row] += count
                turn = next_mover(tree, walls, domain, turn)
            position[row, 0], position[row, 1] = x, y
            domains[row] = domain

    return sweep_all
