"""Which cluster of now is which group of before: by the members that they have in common."""

from __future__ import annotations

import numpy as np


def overlap(
    label: np.ndarray, column: np.ndarray, known: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Who has most in common with whom.

    Returns:
        For each of ``count`` clusters the place in ``known`` of the group it has most
        members from (-1: none) and their share of the cluster; for each known group the
        cluster most of its members are in (-1: none) and their share of the group.
    """
    both = np.flatnonzero((label >= 0) & (column >= 0))
    place = np.searchsorted(known, column[both])
    pair, common = np.unique(label[both] * max(len(known), 1) + place, return_counts=True)
    cluster, group = np.divmod(pair, max(len(known), 1))
    from_old, from_most = _best(cluster, group, common, count)
    into_new, into_most = _best(group, cluster, common, len(known))
    sizes = np.bincount(label[label >= 0], minlength=count)
    before = np.bincount(np.searchsorted(known, column[column >= 0]), minlength=len(known))
    return from_old, from_most / sizes, into_new, into_most / np.maximum(before, 1)


def _best(
    one: np.ndarray, other: np.ndarray, common: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """For each ``one`` the ``other`` with most in common, the first of equals; -1: none."""
    best, most = np.full(count, -1), np.zeros(count, np.int64)
    order = np.lexsort((-other, common))  # the last to be written is the best
    best[one[order]], most[one[order]] = other[order], common[order]
    return best, most
