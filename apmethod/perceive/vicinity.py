"""What is around single agents: the sorted sub-domains as Python lists (paper 2.4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.perceive.bands import places_of_own, slices_around
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.images import REAL, WRAPPED

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle


class Vicinity:
    """Sorted cells for agents that look around in Python.

    An agent's potential neighbours, LpN of its sub-domain, are one slice of a list, so that
    it does little else than try them: copying them together would cost what the quad-lattice
    spares.

    Attributes:
        potential: (agent, x, y) of agents, each as often as there are bands that it is in.
        images: (agent, x, y, shift_x, shift_y) of images across periodic sides, alike.
        of_row: by row of the table (x, y, begin, end, own, first, last): where the agent stood,
            its slice of ``potential``, its own place in that slice, its slice of ``images``.
        cell: by row, which of the occupied sub-domains the agent is in.
    """

    def __init__(self, cells: SortedCells, agents: Sequence[AgentParticle]):
        self._cells = cells
        self._agents = agents
        real = cells.of_kind(REAL)
        around = slices_around(cells, real)
        start = np.searchsorted(real, cells.start)
        own = places_of_own(*around, start)
        self.potential = self._listed(real, around[0], cells.x, cells.y)
        # A mirror image is nobody that an agent perceives.
        wrapped = cells.of_kind(WRAPPED)
        beyond = slices_around(cells, wrapped)
        shifted = cells.x, cells.y, cells.shift_x, cells.shift_y
        self.images = self._listed(wrapped, beyond[0], *shifted)
        by_row = np.empty(len(real), np.int64)
        by_row[cells.row[real]] = np.arange(len(real))
        cell = np.repeat(np.arange(len(cells.number)), np.diff(start))[by_row]
        place, (_, begin, end), (_, first, last) = real[by_row], around, beyond
        columns = (
            cells.x[place], cells.y[place], begin[cell], end[cell], own[by_row], first[cell],
            last[cell],
        )  # fmt: skip
        self.of_row = list(zip(*(column.tolist() for column in columns), strict=True))
        self.cell = cell.tolist()

    def _listed(self, chosen: np.ndarray, order: np.ndarray, *columns: np.ndarray) -> list[tuple]:
        """Entries as tuples, in an order of places in ``chosen``."""
        agents = map(self._agents.__getitem__, self._cells.row[chosen].tolist())
        parts = (column[chosen].tolist() for column in columns)
        entries = np.fromiter(zip(agents, *parts, strict=True), object, len(chosen))
        return entries[order].tolist()
