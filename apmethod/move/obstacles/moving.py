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
from apmethod.move.obstacles.tree import Tree

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


def movers_of(
    begin: np.ndarray, end: np.ndarray, obstacles: Sequence[int], homes: Tree, bodies: Bodies
) -> Movers:
    """The obstacles that move in a step, before `place_all` has filled in their poses.

    Args:
        begin, end: (movers, 3) their poses, as they tell, where the step begins and ends.
        obstacles: their numbers.
        homes: a leaf for the walls of each.
        bodies: what all obstacles do.
    """
    pieces = np.maximum(1, np.ceil(np.abs(end[:, 2] - begin[:, 2]) / TURN)).astype(np.int32)
    poses = np.empty((len(pieces), pieces.max() + 1, 4))
    at_rest = bodies._replace(drift=np.zeros_like(bodies.drift))
    return Movers(poses, pieces, np.array(obstacles, np.int32), at_rest, homes)


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


@borrowing
def place_all(movers, begin, end, pivots, ends, bounds, margin):
    """Write the poses of a step, in which place and turn change evenly, and what they imply.

    Args:
        movers: see `movers_of`; their poses are written.
        begin, end: as for `movers_of`.
        pivots: (movers, 2) where the pivots are at time 0.
        ends: of all walls; where they are before and after the step is written.
        bounds: (walls, 4) written: boxes that hold them with a margin all through the step,
            as resting agents see them.
        margin: that margin.
    """
    for mover in range(len(movers.pieces)):
        last = movers.pieces[mover]
        for piece in range(last + 1):
            share = piece / last
            turn = (1.0 - share) * begin[mover, 2] + share * end[mover, 2]
            for axis in range(2):
                off = (1.0 - share) * begin[mover, axis] + share * end[mover, axis]
                movers.poses[mover, piece, axis] = pivots[mover, axis] + off
            movers.poses[mover, piece, 2] = np.cos(turn)
            movers.poses[mover, piece, 3] = np.sin(turn)
        low_x, low_y, high_x, high_y, reach_2 = np.inf, np.inf, -np.inf, -np.inf, 0.0
        for k in range(movers.homes.first[mover], movers.homes.last[mover]):
            wall = movers.homes.listed[k]
            for corner in (0, 2):
                own_x, own_y = ends[2, wall, corner], ends[2, wall, corner + 1]
                reach_2 = max(reach_2, own_x * own_x + own_y * own_y)
                for piece in range(last + 1):
                    x, y = from_own(movers.poses, mover, piece, own_x, own_y)
                    low_x, low_y = min(low_x, x), min(low_y, y)
                    high_x, high_y = max(high_x, x), max(high_y, y)
                    if piece == 0:
                        ends[0, wall, corner], ends[0, wall, corner + 1] = x, y
                    if piece == last:
                        ends[1, wall, corner], ends[1, wall, corner + 1] = x, y
        arc = np.sqrt(reach_2) * TURN * TURN / 8.0 if begin[mover, 2] != end[mover, 2] else 0.0
        around = margin + arc
        for k in range(movers.homes.first[mover], movers.homes.last[mover]):
            wall = movers.homes.listed[k]
            bounds[wall, 0], bounds[wall, 1] = low_x - around, low_y - around
            bounds[wall, 2], bounds[wall, 3] = high_x + around, high_y + around


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
                    tree, walls, bodies, turn, SLIDE, domain, x, y, to_x, to_y, 0.0, 0.0, along_x,
                    along_y,
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
                    to_x, to_y, own_u, own_v, NO_BORDER, NO_BORDER,
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
