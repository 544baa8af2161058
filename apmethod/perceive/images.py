"""Images: agents near a side, seen a second time beyond it.

Beyond a periodic side stand the agents of the opposite one, beyond a mirrored side the
mirror images of its own.  Sorted among the agents, they spare every search and sum from
knowing the domain.
"""

import numpy as np

from apmethod.perceive.domain import MIRRORED, PERIODIC, Domain

#: What an entry of sorted cells is.
REAL, WRAPPED, MIRROR = 0, 1, 2


def with_images(
    positions: np.ndarray, core_radius: float, domain: Domain
) -> tuple[np.ndarray | None, np.ndarray, np.ndarray]:
    """The agents, positions of shape (n, 2), then their images within a core radius outside.

    Returns:
        row, the agent of each entry; shift, what to add to its position, of shape
        (entries, 2); kind, REAL, WRAPPED or MIRROR.  Where the domain makes no images, row
        is None and the others are empty.
    """
    if not domain.makes_images:
        return None, np.empty((0, 2)), np.empty(0, np.int8)
    row = np.arange(len(positions))
    shift = np.zeros((len(positions), 2))
    kind = np.full(len(positions), REAL, np.int8)
    for axis, side in enumerate(domain.kinds):
        if side not in (PERIODIC, MIRRORED):
            continue
        along = positions[row, axis]
        copied, step = _beyond_sides(along, core_radius, domain, axis)
        moved = np.zeros((len(copied), 2))
        moved[:, axis] = step
        shift = np.concatenate([shift, shift[copied] + moved])
        row = np.concatenate([row, row[copied]])
        made = MIRROR if side == MIRRORED else WRAPPED
        kind = np.concatenate([kind, np.maximum(kind[copied], np.int8(made))])
    return row, shift, kind


def _beyond_sides(
    along: np.ndarray, core_radius: float, domain: Domain, axis: int
) -> tuple[np.ndarray, np.ndarray]:
    """Which of the coordinates along an axis have images beyond its sides, and how far off."""
    lower, upper = domain.lower[axis], domain.upper[axis]
    reach = core_radius * (1.0 + 1e-9)  # one image too many is better than one too few
    low, high = np.flatnonzero(along <= lower + reach), np.flatnonzero(along >= upper - reach)
    if domain.kinds[axis] == MIRRORED:
        steps = 2.0 * (lower - along[low]), 2.0 * (upper - along[high])
    else:
        steps = np.full(len(low), upper - lower), np.full(len(high), lower - upper)
    return np.concatenate([low, high]), np.concatenate(steps)
