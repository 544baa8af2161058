"""The compiled evaluations of a round behind one call.

All three give the same sums: each agent's sum has one order, so the bits do not depend on
the number of threads, and the three differ from each other by rounding only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.compile import LANES, in_blocks, memory
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term
from apmethod.message.fuse import width_of
from apmethod.message.gather import gather
from apmethod.message.scatter import scatter
from apmethod.message.stored import sum_over_lists
from apmethod.particles import Particles
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.lists import NeighbourLists
from apmethod.perceive.sorting import take

if TYPE_CHECKING:
    from apmethod.move.obstacles.sight import Sights

#: How compiled sums can be taken.
EVALUATIONS = ("gathered", "scattered", "stored")
#: The quickest one for every kernel, number of neighbours, number of rounds and kind of core
#: radii measured: a scattered round takes 0.5 to 0.8 of a gathered one and about as long as a
#: stored one whose lists are there already.
BEST_EVALUATION = "scattered"


class RoundPass:
    """All terms of one round over all agents, compiled.

    Args:
        terms: the terms of the round.
        kernel: the scene's smoothing kernel.
        particles: the table; its columns say what is scalar and what is a vector.
        evaluation: "gathered", "scattered" or "stored".
        odd: columns that have the opposite sign in images in walls that absorb.
    """

    def __init__(
        self,
        terms: Sequence[Term],
        kernel: Kernel,
        particles: Particles,
        evaluation: str,
        odd: frozenset[str] = frozenset(),
    ):
        self.terms = tuple(terms)
        self.kernel = kernel
        self.particles = particles
        self.evaluation = evaluation
        self.odd = odd
        names = dict.fromkeys(name for term in self.terms for name in term.columns)
        self.reads = tuple((name, particles.columns[name].components) for name in names)
        self.width = width_of(self.terms)
        self._lines = sum(components or 1 for _, components in self.reads)

    def __call__(
        self,
        cells: SortedCells,
        lists: NeighbourLists | None,
        sums: np.ndarray,
        rows: np.ndarray | None = None,
        sights: Sights | None = None,
    ) -> None:
        """Write each agent's sums to its row of ``sums``, of shape (agents, width).

        Args:
            cells: the agents, sorted.
            lists: their neighbours, for the stored evaluation.
            sums: where to write.
            rows: rows of the table that the cells were made from, None for all.
            sights: whom agents near walls see, None where that is nothing special.
        """
        row = cells.row if rows is None else rows[cells.row]
        table = memory.empty((self._lines, len(row) + LANES))
        for line, component in enumerate(self._components()):
            in_blocks(take, len(row), row, component, table[line])
        # Formulas run on whole vectors: what is behind the last agent must be an agent's, too.
        table[:, len(row) :] = table[:, len(row) - 1 : len(row)] if len(row) else 0.0
        scene = (self.terms, self.kernel, self.reads, cells)
        if self.evaluation == "gathered":
            gather(*scene, row, table, sums)
        elif self.evaluation == "scattered":
            scatter(*scene, row, table, sums)
        else:
            sum_over_lists(*scene, lists, row, table, sums)
        if sights is not None:
            from apmethod.message.sighted import sum_over_sights  # where there are obstacles

            sum_over_sights(*scene[:3], self.odd, sights, cells.core_radius, row, table, sums)

    def _components(self) -> Iterator[np.ndarray]:
        """The columns that the terms read, vectors by component."""
        for name, _ in self.reads:
            values = self.particles.array(name)
            yield from values.T if values.ndim == 2 else (values,)
