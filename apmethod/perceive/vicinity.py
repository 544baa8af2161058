"""What is around single agents: the sorted sub-domains as Python lists (paper 2.4.2)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import repeat
from typing import TYPE_CHECKING

import numpy as np

from apmethod.perceive.cells import SortedCells
from apmethod.perceive.images import MIRROR, REAL

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle


class Vicinity:
    """Sorted cells for agents that look around in Python; each list is made when asked for."""

    def __init__(self, cells: SortedCells, agents: Sequence[AgentParticle]):
        self.cells = cells
        self._agents = agents
        self._potential: dict[int, list[tuple]] = {}

    @cached_property
    def places(self) -> list[tuple[float, float, int]]:
        """By row of the table: x, y, and which of the occupied sub-domains they are in."""
        cells = self.cells
        cell = np.repeat(np.arange(len(cells.number)), np.diff(cells.start))
        real = cells.image == REAL if len(cells.image) else slice(None)
        order = np.argsort(cells.row[real])
        columns = (column[real][order].tolist() for column in (cells.x, cells.y, cell))
        return list(zip(*columns, strict=True))

    def potential(self, cell: int) -> list[tuple]:
        """LpN of an occupied sub-domain, made once and shared by all agents in it.

        Returns:
            (agent, x, y, shift_x, shift_y) of each agent in the sub-domains that Table 1 of
            the paper names; the shift is that of an image across a periodic side.
        """
        potential = self._potential.get(cell)
        if potential is None:
            potential = self._potential[cell] = []
            for begin, end in zip(*self._runs[cell], strict=True):
                potential += self._entries[begin:end]
        return potential

    @cached_property
    def _runs(self) -> list[tuple[list[int], list[int]]]:
        """By sub-domain: where the runs around it begin and end."""
        return list(zip(self.cells.low.tolist(), self.cells.high.tolist(), strict=True))

    @cached_property
    def _entries(self) -> list[tuple]:
        """All entries in order, of which a sub-domain's LpN is a few slices."""
        cells = self.cells
        agents = map(self._agents.__getitem__, cells.row.tolist())
        if len(cells.image):
            # A mirror image is nobody that an agent perceives: it stands out of reach.
            shift_x = np.where(cells.image == MIRROR, np.inf, cells.shift_x)
            shifts = shift_x.tolist(), cells.shift_y.tolist()
        else:
            shifts = repeat(0.0), repeat(0.0)
        return list(zip(agents, cells.x.tolist(), cells.y.tolist(), *shifts, strict=False))
