"""Planes that follow the moving walls they touch, without a new tree (paper 2.5.3).

A plane of the tree touches the bounds of a wall, its owner.  When the owner moves, the
plane goes along, and with it the limits of the domains on both of its sides.  Walls are
listed anew in the domains whose limits have changed, and moving walls where they are now.

Only when a plane has to pass another one does a domain disappear.  Then the domain that the
one of them cuts is built again from the walls that are in it now, and no other.  A leaf in
which walls gather, as planes leave them behind, is cut further.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from apmethod.move.obstacles.borrowing import borrowing
from apmethod.move.obstacles.cutting import cut_leaves, touches
from apmethod.move.obstacles.tree import LEAF, Rules, Tree

#: A leaf is cut further if it has so many times as many walls as when it was made, and more.
_CROWDED, _FEW = 2, 8


def follow(
    tree: Tree,
    walls: np.ndarray,
    bounds: np.ndarray,
    whole: np.ndarray,
    moving: np.ndarray,
    root: Callable[[], np.ndarray],
    rules: Rules,
) -> tuple[Tree, int]:
    """A tree with its planes where moving walls are now.

    Args:
        tree: the tree as it was; it is not changed.
        walls, bounds, whole, rules: as for `cut`, the bounds as they are now.
        moving: (n,) which walls have other bounds than the tree was made or moved for.
        root: gives that of `cut`, if a part has to be built.

    Returns:
        (tree, how many parts of it had to be built again).
    """
    axis, plane, limits = tree.axis.copy(), tree.plane.copy(), tree.limits.copy()
    changed, stays = np.empty(len(axis), np.bool_), np.ones(len(axis), np.bool_)
    broken = _move(tree, bounds, moving, rules.least, axis, plane, limits, changed, stays)
    moved = tree._replace(plane=plane, limits=limits)
    number = np.arange(len(axis), dtype=np.int32)
    torn = number[:0]
    if broken:
        number = np.where(stays, np.cumsum(stays, dtype=np.int32) - 1, -1)
        torn = number[(axis != tree.axis) & stays]
        moved, changed = _without(moved._replace(axis=axis), number), changed[stays]
    moved = _listed(tree, moved, walls, bounds, whole, moving, number, changed)
    crowded = moved.last - moved.first > _CROWDED * moved.had + _FEW
    crowded[torn] = True
    if crowded.any():
        leaves = np.flatnonzero(crowded)
        moved = cut_leaves(moved, leaves, walls, bounds, whole, root(), rules)
    return moved, broken


@borrowing
def _move(tree, bounds, moving, least, axis, plane, limits, changed, stays):
    """Move the planes, and their domains' limits; how many have to pass another one.

    Domains that are cut by such a plane become leaves, and what was in them does not stay.
    """
    broken = 0
    for domain in range(len(axis)):
        changed[domain] = False
        for side in range(4):
            if limits[domain, side] != tree.limits[domain, side]:
                changed[domain] = True
        across = axis[domain]
        if across == LEAF:
            continue
        low, high = tree.sons[domain, 0], tree.sons[domain, 1]
        if stays[domain]:
            owner = tree.owner[domain]
            if owner >= 0 and moving[owner]:
                plane[domain] = bounds[owner, tree.owner_side[domain]]
            first, last = limits[domain, across] + least, limits[domain, across + 2] - least
            if first < plane[domain] and plane[domain] < last:
                for side in range(4):
                    limits[low, side] = limits[high, side] = limits[domain, side]
                limits[low, across + 2] = limits[high, across] = plane[domain]
                continue
            axis[domain], changed[domain] = LEAF, True
            broken += 1
        stays[low] = stays[high] = False
    return broken


def _without(tree: Tree, number: np.ndarray) -> Tree:
    """The tree without the domains whose new number is -1."""
    kept = tree.axis[number >= 0]
    parts = Tree(*(array[number >= 0] for array in tree[:-1]), tree.listed)
    sons = np.where((kept == LEAF)[:, None], np.int32(-1), number[parts.sons])
    father = np.where(parts.father < 0, np.int32(-1), number[parts.father])
    return parts._replace(sons=sons, father=father)


def _listed(
    tree: Tree,
    moved: Tree,
    walls: np.ndarray,
    bounds: np.ndarray,
    whole: np.ndarray,
    moving: np.ndarray,
    number: np.ndarray,
    changed: np.ndarray,
) -> Tree:
    """``moved`` with its walls listed, where they were in ``tree`` if nothing has changed."""
    moved = moved._replace(first=np.empty_like(moved.first), last=np.empty_like(moved.last))
    room = 2 * len(tree.listed) + 64
    scratch = np.empty(len(moved.axis), np.int32)
    while True:
        pairs, again = np.empty((2, room), np.int32), moving.copy()
        count = _pairs(
            tree, moved, walls, bounds, whole, moving, number, changed, again, scratch, pairs
        )
        if count >= 0:
            break
        room *= 2
    moved = moved._replace(listed=np.empty(count, np.int32))
    _list(moved, pairs, count)
    return moved


@borrowing
def _pairs(tree, moved, walls, bounds, whole, moving, number, changed, again, waiting, pairs):
    """Collect (leaf, wall) for every wall of every leaf; -1 if there was no room for them."""
    room, count = pairs.shape[1], 0
    for domain in range(len(tree.axis)):
        if tree.axis[domain] != LEAF:
            continue
        leaf = number[domain]
        anew = leaf < 0 or changed[leaf]
        for k in range(tree.first[domain], tree.last[domain]):
            wall = tree.listed[k]
            if anew:
                again[wall] = True
            elif not moving[wall]:
                if count == room:
                    return -1
                pairs[0, count], pairs[1, count] = leaf, wall
                count += 1
    for wall in range(len(walls)):
        if not again[wall]:
            continue
        waiting[0] = 0
        left = 1
        while left > 0:
            left -= 1
            domain = waiting[left]
            axis = moved.axis[domain]
            if axis != LEAF:
                if bounds[wall, axis] < moved.plane[domain]:
                    waiting[left] = moved.sons[domain, 0]
                    left += 1
                if bounds[wall, axis + 2] > moved.plane[domain]:
                    waiting[left] = moved.sons[domain, 1]
                    left += 1
            elif (moving[wall] or changed[domain]) and touches(
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
