"""Agents that have nothing to meet: the quick test before all others (paper 2.5).

An agent whose displacement stays in an empty domain tests nothing, and one that crosses
from an empty domain to another one does not either: only the domains that the box around
its displacement touches are looked at.  The agents that are left are carried along.
"""

import numpy as np

from apmethod.compile import compiled
from apmethod.move.obstacles.borrowing import borrowing, called, exact
from apmethod.move.obstacles.carry import FREE, within
from apmethod.move.obstacles.rays import find_domain, in_empty_leaf
from apmethod.move.obstacles.tree import LEAF

#: Agents, one after the other in the table, that are tested together.
GROUP = 256


@called
def clear(tree, west, south, east, north):
    """Whether every leaf that a box touches is empty; not so for a box of NaN."""
    if not (west <= east and south <= north):
        return False
    domain = 0
    while True:
        axis = tree.axis[domain]
        if axis != LEAF:
            low = west if axis == 0 else south
            domain = tree.sons[domain, 0 if low <= tree.plane[domain] else 1]
            continue
        if tree.first[domain] != tree.last[domain]:
            return False
        # On to the next domain above a plane that the box reaches.
        above = False
        while not above:
            father = tree.father[domain]
            if father < 0:
                return True
            high = east if tree.axis[father] == 0 else north
            above = tree.sons[father, 0] == domain and high >= tree.plane[father]
            domain = tree.sons[father, 1] if above else father


@borrowing
def box_clear(tree, west, south, east, north):
    """`clear`, for calls from Python."""
    return clear(tree, west, south, east, north)


@compiled
def apart(boxes, others):
    """Whether the box around some boxes, (n, 4), touches none of some others."""
    west, south, east, north = np.inf, np.inf, -np.inf, -np.inf
    for k in range(len(boxes)):
        west, south = min(west, boxes[k, 0]), min(south, boxes[k, 1])
        east, north = max(east, boxes[k, 2]), max(north, boxes[k, 3])
    for k in range(len(others)):
        beside = east < others[k, 0] or others[k, 2] < west
        if not (beside or north < others[k, 1] or others[k, 3] < south):
            return False
    return True


@exact
def around_ways(start, position):
    """The box around some displacements; those to nowhere do not count."""
    west, south, east, north = np.inf, np.inf, -np.inf, -np.inf
    for k in range(len(start)):
        px, py, qx, qy = start[k, 0], start[k, 1], position[k, 0], position[k, 1]
        # Each agent's own first: processors then need not wait for west before the next one.
        low_x, high_x = (px, qx) if px < qx else (qx, px)
        low_y, high_y = (py, qy) if py < qy else (qy, py)
        west, east = (low_x if low_x < west else west), (high_x if high_x > east else east)
        south, north = (low_y if low_y < south else south), (high_y if high_y > north else north)
    return west, south, east, north


@exact
def all_free(held, fate):
    """Whether no agent sticks to a wall or has been taken by one."""
    bound = 0
    for k in range(len(held)):
        bound += held[k] >= 0 or fate[k] != FREE
    return bound == 0


@borrowing
def who_may_meet(
    first, last, rows, tree, along_x, along_y, start, position, domains, held, fate, may, boxes
):
    """Which agents may meet a wall or a border on their way, or are not free to go.

    Agents are tested in groups first, then one by one.  The latter remember the domain where
    they end.  The rows ascend; those between two of them are tested with their group, around
    which the box is written.
    """
    for group in range(first, last):
        begin, end = group * GROUP, min((group + 1) * GROUP, len(rows))
        low, high = rows[begin], rows[end - 1] + 1
        west, south, east, north = around_ways(start[low:high], position[low:high])
        boxes[group, 0], boxes[group, 1] = west, south
        boxes[group, 2], boxes[group, 3] = east, north
        may[begin:end] = False
        if (
            all_free(held[low:high], fate[low:high])
            and within(west, south, along_x, along_y)
            and within(east, north, along_x, along_y)
            and clear(tree, west, south, east, north)
        ):
            continue
        for k in range(begin, end):
            row = rows[k]
            px, py = start[row, 0], start[row, 1]
            qx, qy = position[row, 0], position[row, 1]
            free = held[row] < 0 and fate[row] == FREE and within(qx, qy, along_x, along_y)
            if free and in_empty_leaf(tree, domains[row], px, py, qx, qy):
                continue
            if free and clear(tree, min(px, qx), min(py, qy), max(px, qx), max(py, qy)):
                domains[row] = find_domain(tree, domains[row], qx, qy)
            else:
                may[k] = True
