"""Planes that follow the moving walls they touch, without a new tree (paper 2.5.3).

A plane of the tree touches the bounds of a wall, its owner.  When the owner moves, the
plane goes along, and with it the limits of the domains on both of its sides.  Walls are
listed anew in the domains whose limits have changed, and moving walls where they are now.
Only when a plane has to pass another one does a domain disappear: then a tree is built.
"""

from __future__ import annotations

import numpy as np

from apmethod.move.obstacles.borrowing import borrowing, exact
from apmethod.move.obstacles.tree import LEAF, Tree, touches


def follow(
    tree: Tree,
    walls: np.ndarray,
    bounds: np.ndarray,
    whole: np.ndarray,
    moving: np.ndarray,
    least: float,
) -> Tree | None:
    """The tree with its planes where moving walls are now, or None if a domain disappears.

    Args:
        tree: the tree as it was; it is not changed.
        walls, bounds, whole: as for `build`, the bounds as they are now.
        moving: (n,) which walls have other bounds than the tree was made or moved for.
        least: how wide a domain must be at least.
    """
    plane, limits = tree.plane.copy(), tree.limits.copy()
    if not _move(tree, bounds, moving, least, plane, limits):
        return None
    moved = tree._replace(
        plane=plane, limits=limits, first=np.empty_like(tree.first), last=np.empty_like(tree.last)
    )
    room = 2 * len(tree.listed) + 64
    scratch = np.empty(len(plane), np.int32)
    while True:
        pairs = np.empty((2, room), np.int32)
        count = _pairs(tree, moved, walls, bounds, whole, moving, moving.copy(), scratch, pairs)
        if count >= 0:
            break
        room *= 2
    moved = moved._replace(listed=np.empty(count, np.int32))
    _list(moved, pairs, count)
    return moved


@borrowing
def _move(tree, bounds, moving, least, plane, limits):
    """Move the planes, and their domains' limits; False if one has to pass another."""
    for domain in range(len(tree.axis)):
        axis = tree.axis[domain]
        if axis == LEAF:
            continue
        owner = tree.owner[domain]
        if owner >= 0 and moving[owner]:
            plane[domain] = bounds[owner, tree.owner_side[domain]]
        low, high = limits[domain, axis] + least, limits[domain, axis + 2] - least
        if not (low < plane[domain] and plane[domain] < high):
            return False
        for son in range(2):
            for side in range(4):
                limits[tree.sons[domain, son], side] = limits[domain, side]
        limits[tree.sons[domain, 0], axis + 2] = plane[domain]
        limits[tree.sons[domain, 1], axis] = plane[domain]
    return True


@exact
def _changed(tree, moved, domain):
    """Whether a domain has other limits than before."""
    changed = False
    for side in range(4):
        changed = changed or tree.limits[domain, side] != moved.limits[domain, side]
    return changed


@borrowing
def _pairs(tree, moved, walls, bounds, whole, moving, again, waiting, pairs):
    """Collect (leaf, wall) for every wall of every leaf; -1 if there was no room for them."""
    room, count = pairs.shape[1], 0
    for domain in range(len(tree.axis)):
        if tree.axis[domain] != LEAF:
            continue
        changed = _changed(tree, moved, domain)
        for k in range(tree.first[domain], tree.last[domain]):
            wall = tree.listed[k]
            if changed:
                again[wall] = True
            elif not moving[wall]:
                if count == room:
                    return -1
                pairs[0, count], pairs[1, count] = domain, wall
                count += 1
    for wall in range(len(walls)):
        if not again[wall]:
            continue
        waiting[0] = 0
        left = 1
        while left > 0:
            left -= 1
            domain = waiting[left]
            axis = tree.axis[domain]
            if axis != LEAF:
                if bounds[wall, axis] < moved.plane[domain]:
                    waiting[left] = tree.sons[domain, 0]
                    left += 1
                if bounds[wall, axis + 2] > moved.plane[domain]:
                    waiting[left] = tree.sons[domain, 1]
                    left += 1
            elif (moving[wall] or _changed(tree, moved, domain)) and touches(
                moved.limits, domain, walls, bounds, whole, wall
            ):
                if count == room:
                    return -1
                pairs[0, count], pairs[1, count] = domain, wall
                count += 1
    return count


@borrowing
def _list(moved, pairs, count):
    """Put the pairs into the leaves' lists."""
    for domain in range(len(moved.axis)):
        moved.last[domain] = 0
    for k in range(count):
        moved.last[pairs[0, k]] += 1
    total = 0
    for domain in range(len(moved.axis)):
        moved.first[domain] = total
        total += moved.last[domain]
        moved.last[domain] = moved.first[domain]
    for k in range(count):
        moved.listed[moved.last[pairs[0, k]]] = pairs[1, k]
        moved.last[pairs[0, k]] += 1
