"""Images: agents near a side, seen a second time beyond it.

Beyond a periodic side stand the agents of the opposite one, beyond a mirrored side the
mirror images of its own.  Sorted among the agents, they spare every search and sum from
knowing the domain.
"""

from typing import NamedTuple

import numpy as np

from apmethod.compile import compiled, inlined, memory
from apmethod.perceive.domain import MIRRORED, PERIODIC, Domain

#: What an entry of sorted cells is.
REAL, WRAPPED, MIRROR = 0, 1, 2


class Entries(NamedTuple):
    """Agents, and after them their images; all but the places are empty where there are none.

    Attributes:
        places: where each one is seen, of shape (entries, 2).
        row: the agent of each.
        shift: what was added to the agent's position, of shape (entries, 2).
        kind: REAL, WRAPPED or MIRROR.
    """

    places: np.ndarray
    row: np.ndarray
    shift: np.ndarray
    kind: np.ndarray


_NO_ROW, _NO_SHIFT, _NO_KIND = np.empty(0, np.int64), np.empty((0, 2)), np.empty(0, np.int8)


def with_images(positions: np.ndarray, core_radius: float, domain: Domain) -> Entries:
    """The agents, positions of shape (n, 2), and their images within a core radius outside."""
    if not domain.makes_images:
        return Entries(positions, _NO_ROW, _NO_SHIFT, _NO_KIND)
    reach = core_radius * (1.0 + 1e-9)  # one image too many is better than one too few
    count = len(positions) + _count(positions, reach, *domain.limits)
    entries = Entries(
        memory.empty((count, 2)),
        memory.empty(count, np.int64),
        memory.empty((count, 2)),
        memory.empty(count, np.int8),
    )
    _fill(positions, reach, *domain.limits, *entries)
    return entries


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
def _fill(positions, reach, along_x, along_y, places, row, shift, kind):
    """Write the agents, then the images, those of an agent one after the other."""
    agents = count = positions.shape[0]
    for agent in range(agents):
        x, y = positions[agent, 0], positions[agent, 1]
        places[agent, 0], places[agent, 1] = x, y
        row[agent], kind[agent] = agent, REAL
        shift[agent, 0], shift[agent, 1] = 0.0, 0.0
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
                dx = _step(x, along_x, (column + 1) // 2) if column else 0.0
                dy = _step(y, along_y, (line + 1) // 2) if line else 0.0
                places[count, 0], places[count, 1] = x + dx, y + dy
                shift[count, 0], shift[count, 1] = dx, dy
                mirrored = (column and along_x[2] == MIRRORED) or (line and along_y[2] == MIRRORED)
                row[count], kind[count] = agent, MIRROR if mirrored else WRAPPED
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
