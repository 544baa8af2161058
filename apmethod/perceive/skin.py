"""A skin around the core radius, by which one search serves several steps (Verlet 1967).

The search reaches further than the core radius R, to R (1 + s).  While no agent is further
than s R / 2 from where it stood then, two agents that have come closer than R were closer
than R (1 + s): the sub-domains, and any list of neighbours made from them, still hold every
pair.  All sums go on testing the distance against R itself.

It is not for domains with images, which move otherwise than their agents.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from apmethod.checks import finite_number
from apmethod.compile import compiled
from apmethod.perceive.cells import SortedCells, sort_into_cells
from apmethod.perceive.domain import Domain
from apmethod.perceive.images import with_images
from apmethod.perceive.sorting import in_order


class Skin:
    """Searches as far as a skin, and remembers the last search.

    Args:
        share: s, from 0 (every step searches anew) to 1.

    Raises:
        ValueError: for a share outside of these.
    """

    def __init__(self, share: float):
        self.share = finite_number("skin", share, least=0.0)
        if self.share > 1.0:
            raise ValueError(f"skin is {share:g}; it must be from 0 to 1, a share of the radius")
        #: How many searches were made, and how many were spared.
        self.searches = self.spared = 0
        self.forget()

    def forget(self) -> None:
        """Search anew the next time: the agents have other rows now."""
        self._found: SortedCells | None = None

    def search(
        self, positions: np.ndarray, changes: int, core_radius: float, level: int, domain: Domain
    ) -> SortedCells:
        """`sort_into_cells`, or what that gave before, with the agents where they are now.

        Args:
            positions: of shape (n, 2).
            changes: a number that grows when agents come or go.
            core_radius, level, domain: see `sort_into_cells`.
        """
        if self._serves(positions, changes, core_radius):
            self.spared += 1
            found = self._found
            moved = in_order(found.row, positions, with_images(positions, core_radius, domain))
            return replace(found, core_radius=core_radius, searched=found, **moved)
        found = sort_into_cells(positions, core_radius * (1.0 + self.share), level, domain)
        self.searches += 1
        self._found, self._from = found, positions.copy()
        self._changes = changes
        return replace(found, core_radius=core_radius, searched=found)

    def _serves(self, positions: np.ndarray, changes: int, core_radius: float) -> bool:
        """Whether the last search has found all pairs of agents at ``positions``."""
        if self._found is None or changes != self._changes:
            return False
        slack = 0.5 * (self._found.core_radius - core_radius) * (1.0 - 1e-9)
        return slack > 0.0 and furthest(positions, self._from) <= slack


@compiled
def furthest(positions, before):
    """The largest distance of positions, of shape (n, 2), from where they were; NaN is far."""
    largest = 0.0
    for k in range(positions.shape[0]):
        dx, dy = positions[k, 0] - before[k, 0], positions[k, 1] - before[k, 1]
        apart_2 = dx * dx + dy * dy
        if np.isnan(apart_2):
            return np.inf
        largest = max(largest, apart_2)
    return np.sqrt(largest)
