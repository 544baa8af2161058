"""What is around single agents: the sorted sub-domains as Python lists (paper 2.4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.perceive.bands import slices_around
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.images import REAL, WRAPPED

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle


Listed = tuple[list[tuple], list[int], list[int]]


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
        images: (agent, x, y, shift_x, shift_y) of images across periodic sides, alike.
        first, last: by sub-domain, its slice of ``images``.
    """

    def __init__(self, cells: SortedCells, agents: Sequence[AgentParticle]):
        self._cells = cells
        self._agents = agents
        self.potential, self.begin, self.end = self._listed(REAL, cells.x, cells.y)
        # A mirror image is nobody that an agent perceives.
        shifted = cells.x, cells.y, cells.shift_x, cells.shift_y
        self.images, self.first, self.last = self._listed(WRAPPED, *shifted)
        real = cells.of_kind(REAL)
        entry = np.empty(len(real), np.int64)
        entry[cells.row[real]] = real
        cell = np.repeat(np.arange(len(cells.number)), np.diff(cells.start))[entry]
        # Lists of numbers, which Python's collector of garbage has not to look through.
        self.x, self.y, self.cell = cells.x[entry].tolist(), cells.y[entry].tolist(), cell.tolist()

    def _listed(self, kind: int, *columns: np.ndarray) -> Listed:
        """Entries of one kind, and where the slice around each sub-domain begins and ends."""
        chosen = self._cells.of_kind(kind)
        order, begin, end = slices_around(self._cells, chosen)
        agents = map(self._agents.__getitem__, self._cells.row[chosen].tolist())
        parts = (column[chosen].tolist() for column in columns)
        entries = np.fromiter(zip(agents, *parts, strict=True), object, len(chosen))
        return entries[order].tolist(), begin.tolist(), end.tolist()
