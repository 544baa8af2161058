"""What is around single agents: the sorted sub-domains as Python lists (paper 2.4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.perceive.bands import Slices, places_of_own, slices_around
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
        x, y: by row of the table, where the agent stood.
        cell: by row, which of the occupied sub-domains the agent is in.
        potential: (agent, x, y) of agents, each as often as there are bands that it is in.
        begin, end: by sub-domain, its slice of ``potential``.
        own: by row, the agent's own place in that slice.
        images: (agent, x, y, shift_x, shift_y) of images across periodic sides, alike.
        first, last: by sub-domain, its slice of ``images``.
    """

    def __init__(self, cells: SortedCells, agents: Sequence[AgentParticle]):
        self._cells = cells
        self._agents = agents
        real = cells.of_kind(REAL)
        around = slices_around(cells, real)
        start = np.searchsorted(real, cells.start)
        own = places_of_own(*around, start)
        self.potential, self.begin, self.end = self._listed(real, around, cells.x, cells.y)
        # A mirror image is nobody that an agent perceives.
        wrapped = cells.of_kind(WRAPPED)
        shifted = cells.x, cells.y, cells.shift_x, cells.shift_y
        self.images, self.first, self.last = self._listed(
            wrapped, slices_around(cells, wrapped), *shifted
        )
        by_row = np.empty(len(real), np.int64)
        by_row[cells.row[real]] = np.arange(len(real))
        cell = np.repeat(np.arange(len(cells.number)), np.diff(start))
        # Lists of numbers, which Python's collector of garbage has not to look through.
        self.x, self.y = cells.x[real][by_row].tolist(), cells.y[real][by_row].tolist()
        self.cell, self.own = cell[by_row].tolist(), own[by_row].tolist()

    def _listed(
        self, chosen: np.ndarray, around: Slices, *columns: np.ndarray
    ) -> tuple[list[tuple], list[int], list[int]]:
        """Entries as tuples, and where the slice around each sub-domain begins and ends."""
        order, begin, end = around
        agents = map(self._agents.__getitem__, self._cells.row[chosen].tolist())
        parts = (column[chosen].tolist() for column in columns)
        entries = np.fromiter(zip(agents, *parts, strict=True), object, len(chosen))
        return entries[order].tolist(), begin.tolist(), end.tolist()
