"""The kd-tree over walls, and its leaves, the kd-tree-domains (paper 2.5.2, 2.5.3)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from apmethod.move.obstacles.borrowing import borrowing

#: How planes are chosen: by eq 2.4, halfway ("horizontal or vertical" in turn), or not at all.
RULES = {"surface_area": 0, "median": 1, "none": 2}

LEAF = 2  #: where a domain's axis would be, if it has been cut no further


class Tree(NamedTuple):
    """Domains by number; 0 is the plane, a father comes before his sons.

    A side is the place of its limit in ``limits``: 0 west, 1 south, 2 east, 3 north.
    """

    axis: np.ndarray  #: (domains,) axis that the domain is cut across, or `LEAF`
    plane: np.ndarray  #: (domains,) where
    sons: np.ndarray  #: (domains, 2) below and above the plane
    father: np.ndarray  #: (domains,) or -1
    limits: np.ndarray  #: (domains, 4) lower x and y, upper x and y
    beyond: np.ndarray  #: (domains, 4) the domain on each side, of which a leaf is next; or -1
    owner: np.ndarray  #: (domains,) the wall whose bounds the plane touches, or -1
    owner_side: np.ndarray  #: (domains,) which of its four bounds
    first: np.ndarray  #: (domains,) a leaf's walls are listed[first:last]
    last: np.ndarray
    had: np.ndarray  #: (domains,) how many walls a leaf had when it was made
    listed: np.ndarray


class Rules(NamedTuple):
    """What a tree is built by.

    Attributes:
        rule: one of `RULES`.
        cut_cost: K_t, the cost of passing a plane, in tests of a wall.
        favour: what a cut that leaves one side empty may save, as a share of its cost.
        threshold: a domain whose surface area is below this share of the mean of its
            walls' is cut no further.
        least: how wide a domain must be at least, a length.
    """

    rule: int = RULES["surface_area"]
    cut_cost: float = 1.0
    favour: float = 0.5
    threshold: float = 0.1
    least: float = 0.0


def leaves_of(walls: Sequence[np.ndarray]) -> Tree:
    """A leaf for each list of walls, all as wide as the plane and without neighbours."""
    count = len(walls)
    none, last = np.full(count, -1, np.int32), np.cumsum([0, *map(len, walls)], dtype=np.int32)
    return Tree(
        axis=np.full(count, LEAF, np.int8),
        plane=np.zeros(count),
        sons=np.full((count, 2), -1, np.int32),
        father=none,
        limits=np.tile([-np.inf, -np.inf, np.inf, np.inf], (count, 1)),
        beyond=np.full((count, 4), -1, np.int32),
        owner=none,
        owner_side=np.zeros(count, np.int8),
        first=last[:-1],
        last=last[1:],
        had=np.diff(last),
        listed=np.concatenate([np.empty(0, np.int32), *walls]).astype(np.int32),
    )


@borrowing
def beyond_sides(tree):
    """Find for each domain and side the largest domain beyond that touches all of the side.

    It is a brother, a father's brother, a grandfather's, or a descendant of theirs whose
    father is cut along the side.  Planes that move do not change it.
    """
    for side in range(4):
        tree.beyond[0, side] = -1
    for domain in range(len(tree.axis)):
        axis = tree.axis[domain]
        if axis == LEAF:
            continue
        low, high = tree.sons[domain, 0], tree.sons[domain, 1]
        for side in range(4):
            tree.beyond[low, side] = tree.beyond[domain, side]
            tree.beyond[high, side] = tree.beyond[domain, side]
        tree.beyond[low, axis + 2] = high
        tree.beyond[high, axis] = low
    for domain in range(len(tree.axis)):
        for side in range(4):
            other = tree.beyond[domain, side]
            while other >= 0 and tree.axis[other] == side % 2:
                other = tree.sons[other, 0 if side >= 2 else 1]
            tree.beyond[domain, side] = other
