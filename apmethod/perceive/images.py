"""Images: agents near a side, seen a second time beyond it.

Beyond a periodic side stand the agents of the opposite one, beyond a mirrored side the
mirror images of its own.  Sorted among the agents, they spare every search and sum from
knowing the domain.
"""

import numpy as np

from apmethod.compile import compiled, inlined, memory
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
    reach = core_radius * (1.0 + 1e-9)  # one image too many is better than one too few
    agents = len(positions)
    entries = agents + _count(positions, reach, *domain.limits)
    row = memory.empty(entries, np.int64)
    shift = memory.empty((entries, 2))
    kind = np.empty(entries, np.int8)
    row[:agents], shift[:agents], kind[:agents] = np.arange(agents), 0.0, REAL
    _fill(positions, reach, *domain.limits, row, shift, kind, agents)
    return row, shift, kind


@inlined
def _sides(place, reach, along):
    """Whether a coordinate has an image beyond the lower side, and beyond the upper one."""
    lower, upper, kind = along
    if kind != PERIODIC and kind != MIRRORED:
        return False, False
    at_lower, at_upper = place <= lower + reach, place >= upper - reach
    return (at_lower, at_upper) if kind == MIRRORED else (at_upper, at_lower)


@inlined
def _step(place, along, side):
    """From a coordinate to that of its image beyond the lower (0) or upper (1) side."""
    lower, upper, kind = along
    if kind == MIRRORED:
        return 2.0 * ((lower if side == 0 else upper) - place)
    return lower - upper if side == 0 else upper - lower


@compiled
def _count(positions, reach, along_x, along_y):
    """How many images there are."""
    count = 0
    for agent in range(positions.shape[0]):
        west, east = _sides(positions[agent, 0], reach, along_x)
        south, north = _sides(positions[agent, 1], reach, along_y)
        count += (1 + west + east) * (1 + south + north) - 1
    return count


@compiled
def _fill(positions, reach, along_x, along_y, row, shift, kind, count):
    """Write the images, those of an agent one after the other, from entry ``count`` on."""
    for agent in range(positions.shape[0]):
        x, y = positions[agent, 0], positions[agent, 1]
        west, east = _sides(x, reach, along_x)
        south, north = _sides(y, reach, along_y)
        for column in range(-1, 2):
            if (column < 0 and not west) or (column > 0 and not east):
                continue
            for line in range(-1, 2):
                if (line < 0 and not south) or (line > 0 and not north):
                    continue
                if column == 0 and line == 0:
                    continue
                row[count] = agent
                shift[count, 0] = _step(x, along_x, (column + 1) // 2) if column else 0.0
                shift[count, 1] = _step(y, along_y, (line + 1) // 2) if line else 0.0
                mirrored = (column and along_x[2] == MIRRORED) or (line and along_y[2] == MIRRORED)
                kind[count] = MIRROR if mirrored else WRAPPED
                count += 1


def on_sides(lowest: tuple[float, float], side: float, domain: Domain) -> tuple[float, float]:
    """A corner at or below ``lowest``; sub-domains from there on begin at the lower sides.

    At such a side a sub-domain holds agents or images and not both, and a pair of images
    concerns nobody.
    """
    corner = list(lowest)
    for axis in range(2):
        if domain.kinds[axis] in (PERIODIC, MIRRORED):
            corner[axis] -= float((lowest[axis] - domain.lower[axis]) % side)
    return tuple(corner)
