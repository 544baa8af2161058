"""Cutting domains, until each has few walls or none.

Planes are chosen by the surface area heuristic (eq 2.4).  Cutting a domain D into S and T
with n_S and n_T walls costs

    K_t + K_i (n_S SA(S) / SA(D) + n_T SA(T) / SA(D))

where SA, the surface area, is in the plane half the circumference, to which the chance of
a line crossing D to cross S is proportional.  The plane costs less if it cuts off an empty
domain, so that empty domains become as large as they can.  All planes that touch a wall's
bounds are tried, in O(N log N): bounds are sorted once, and their order is handed down
(Wald and Havran 2006).
"""

from __future__ import annotations

import numpy as np

from apmethod.move.obstacles.borrowing import borrowing, called, exact
from apmethod.move.obstacles.tree import LEAF, Rules, Tree, beyond_sides, leaves_of


@exact
def touches(limits, domain, walls, bounds, whole, wall):
    """Whether a wall is in a domain: its bounds are, and the domain is not all beside it."""
    x_low, x_high = max(limits[domain, 0], bounds[wall, 0]), min(limits[domain, 2], bounds[wall, 2])
    y_low, y_high = max(limits[domain, 1], bounds[wall, 1]), min(limits[domain, 3], bounds[wall, 3])
    if x_low > x_high or y_low > y_high:
        return False
    if whole[wall]:
        return True
    ax, ay, bx, by = walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
    # The bounds are wider than the wall by a margin, and the domain is taken so much wider.
    margin = min(ax, bx) - bounds[wall, 0]
    across, along = by - ay, bx - ax  # a normal is (across, -along)
    middle = across * (0.5 * (x_low + x_high) - ax) - along * (0.5 * (y_low + y_high) - ay)
    x_reach, y_reach = 0.5 * (x_high - x_low) + margin, 0.5 * (y_high - y_low) + margin
    return abs(middle) <= abs(across) * x_reach + abs(along) * y_reach


@called
def best_plane(tree, domain, lists, first, count, bounds, rules):
    """The cheapest plane of a domain.

    Returns:
        (cost, axis, plane, owner, side of the owner); the axis is `LEAF` without a plane.
    """
    width = tree.limits[domain, 2] - tree.limits[domain, 0]
    height = tree.limits[domain, 3] - tree.limits[domain, 1]
    best, best_axis, best_plane_at, best_owner, best_side = np.inf, LEAF, 0.0, -1, 0
    for axis in range(2):
        low, high = tree.limits[domain, axis], tree.limits[domain, axis + 2]
        first_plane, last_plane = low + rules.least, high - rules.least
        other = height if axis == 0 else width
        i, j = 0, 0
        while i < count or j < count:
            lower = bounds[lists[axis, first + i], axis] if i < count else np.inf
            upper = bounds[lists[axis + 2, first + j], axis + 2]
            # Walls below the plane are those that begin before it, above those that end after.
            if lower <= upper:
                plane, owner, side = lower, lists[axis, first + i], axis
                below, above = i, count - j
                i += 1
            else:
                plane, owner, side = upper, lists[axis + 2, first + j], axis + 2
                j += 1
                below, above = i, count - j
            if plane <= first_plane or plane >= last_plane:
                continue
            chance_below = (plane - low + other) / (width + height)
            chance_above = (high - plane + other) / (width + height)
            cost = rules.cut_cost + chance_below * below + chance_above * above
            if below == 0 or above == 0:
                cost *= 1.0 - rules.favour
            if cost < best:
                best, best_axis, best_plane_at = cost, axis, plane
                best_owner, best_side = owner, side
    return best, best_axis, best_plane_at, best_owner, best_side


@called
def chosen_plane(tree, domain, lists, first, count, depth, most_depth, bounds, rules):
    """The plane to cut a domain at: (axis, plane, owner, side); the axis is `LEAF` for none."""
    if count == 0 or depth >= most_depth or rules.rule == 2:
        return LEAF, 0.0, -1, 0
    if rules.rule == 1:
        axis = depth % 2
        low, high = tree.limits[domain, axis], tree.limits[domain, axis + 2]
        if count <= 4 or high - low <= 3.0 * rules.least:
            return LEAF, 0.0, -1, 0
        return axis, 0.5 * (low + high), -1, 0
    size, walls_size = 0.0, 0.0
    for axis in range(2):
        size += tree.limits[domain, axis + 2] - tree.limits[domain, axis]
        for k in range(first, first + count):
            wall = lists[0, k]
            walls_size += bounds[wall, axis + 2] - bounds[wall, axis]
    if size * count < rules.threshold * walls_size:
        return LEAF, 0.0, -1, 0
    cost, axis, plane, owner, side = best_plane(tree, domain, lists, first, count, bounds, rules)
    if cost >= count:
        return LEAF, 0.0, -1, 0
    return axis, plane, owner, side


@borrowing
def cut(tree, domains, listed, left, walls, bounds, whole, root, rules, lists, waiting, goes):
    """Cut leaves as the rules say; fills in a `Tree` of enough room, but for ``beyond``.

    Args:
        tree: arrays that hold some domains already, and have room for more.
        domains, listed: how many, and how many walls are listed.
        left: how many leaves to cut.
        walls: (n, 4) ends of the walls, ax, ay, bx, by.
        bounds: (n, 4) boxes that hold them with a margin, and for a moving wall the way
            it goes in a step.
        whole: (n,) whether a wall takes up all of its bounds, as a moving one does.
        root: (4,) box in which areas count; the domains at its sides have no limit there.
        rules: see `Rules`.
        lists: (8, room) begins with the walls of the leaves, one leaf's behind another's,
            sorted by each of their four bounds.
        waiting: (room, 4) begins with the leaves: number, where in ``lists``, how many.
        goes: (n,) scratch.

    Returns:
        (domains, walls listed); no domains if there was no room.
    """
    most_depth = 8 + int(2.6 * np.log2(len(walls) + 1.0))
    for k in range(left):
        domain = waiting[k, 0]
        for side in range(4):
            if np.isinf(tree.limits[domain, side]):
                tree.limits[domain, side] = root[side]
        waiting[k, 3] = 0
        while tree.father[domain] >= 0:
            domain = tree.father[domain]
            waiting[k, 3] += 1
    while left > 0:
        left -= 1
        domain, first, count, depth = waiting[left]
        axis, plane, owner, side = chosen_plane(
            tree, domain, lists, first, count, depth, most_depth, bounds, rules
        )
        tree.axis[domain], tree.plane[domain] = axis, plane
        tree.owner[domain], tree.owner_side[domain] = owner, side
        tree.first[domain], tree.last[domain], tree.had[domain] = listed, listed, count
        tree.sons[domain, 0], tree.sons[domain, 1] = -1, -1
        if axis == LEAF:
            if listed + count > len(tree.listed):
                return 0, 0
            for k in range(first, first + count):
                tree.listed[listed] = lists[0, k]
                listed += 1
            tree.last[domain] = listed
            continue
        if domains + 2 > len(tree.axis) or first + 2 * count > lists.shape[1]:
            return 0, 0
        for son in range(2):
            tree.sons[domain, son] = domains + son
            tree.father[domains + son] = domain
            for side in range(4):
                tree.limits[domains + son, side] = tree.limits[domain, side]
        tree.limits[domains, axis + 2] = plane
        tree.limits[domains + 1, axis] = plane
        below, above = hand_down(
            tree, domains, axis, walls, bounds, whole, lists, first, count, goes
        )
        for son in range(2):
            waiting[left, 0], waiting[left, 3] = domains + son, depth + 1
            waiting[left, 1] = first if son == 0 else first + below
            waiting[left, 2] = below if son == 0 else above
            left += 1
        domains += 2
    for domain in range(domains):
        for side in range(4):
            if tree.limits[domain, side] == root[side]:
                tree.limits[domain, side] = -np.inf if side < 2 else np.inf
    return domains, listed


@called
def hand_down(tree, sons, axis, walls, bounds, whole, lists, first, count, goes):
    """Give each of two sons the walls it has, in the four orders; how many each has got."""
    plane = tree.limits[sons, axis + 2]
    below, above = 0, 0
    for k in range(first, first + count):
        wall = lists[0, k]
        goes[wall] = 0
        if bounds[wall, axis] < plane and touches(tree.limits, sons, walls, bounds, whole, wall):
            goes[wall] += 1
            below += 1
        if bounds[wall, axis + 2] > plane and touches(
            tree.limits, sons + 1, walls, bounds, whole, wall
        ):
            goes[wall] += 2
            above += 1
    for order in range(4):
        for k in range(first, first + count):
            lists[order + 4, k] = lists[order, k]
        to_below, to_above = first, first + below
        for k in range(first, first + count):
            wall = lists[order + 4, k]
            if goes[wall] & 1:
                lists[order, to_below] = wall
                to_below += 1
            if goes[wall] & 2:
                lists[order, to_above] = wall
                to_above += 1
    return below, above


def build_tree(
    walls: np.ndarray, bounds: np.ndarray, whole: np.ndarray, root: np.ndarray, rules: Rules
) -> Tree:
    """The tree over some walls; the arguments are those of `cut`."""
    n = len(walls)
    plane = leaves_of([np.arange(n)])
    return cut_leaves(plane, np.zeros(1, np.intp), walls, bounds, whole, root, rules)


def cut_leaves(
    tree: Tree,
    leaves: np.ndarray,
    walls: np.ndarray,
    bounds: np.ndarray,
    whole: np.ndarray,
    root: np.ndarray,
    rules: Rules,
) -> Tree:
    """The tree with some leaves cut further; the other arguments are those of `cut`."""
    counts = tree.last[leaves] - tree.first[leaves]
    begin = np.cumsum(counts) - counts
    dealt = np.concatenate([tree.listed[tree.first[k] : tree.last[k]] for k in leaves])
    leaf = np.repeat(np.arange(len(leaves)), counts)
    room = 8 * len(dealt) + 64
    goes = np.empty(len(walls), np.int8)
    while True:
        larger = Tree(*(_with_room(array, room) for array in tree))
        lists, waiting = np.empty((8, room), np.int32), np.empty((room, 4), np.int32)
        for side in range(4):
            lists[side, : len(dealt)] = dealt[np.lexsort((bounds[dealt, side], leaf))]
        waiting[: len(leaves), :3] = np.column_stack([leaves, begin, counts])
        domains, listed = cut(
            larger, len(tree.axis), len(tree.listed), len(leaves), walls, bounds, whole, root,
            rules, lists, waiting, goes,
        )  # fmt: skip
        if domains:
            break
        room *= 2
    grown = Tree(*(array[:domains].copy() for array in larger[:-1]), larger.listed[:listed].copy())
    beyond_sides(grown)
    return grown


def _with_room(array: np.ndarray, room: int) -> np.ndarray:
    return np.concatenate([array, np.empty((room, *array.shape[1:]), array.dtype)])
