"""The compiled pass of the bus: every agent sums over its potential neighbours.

The potential neighbours of a sub-domain are copied once into a short contiguous buffer,
shared by all agents in it (the list LpN of paper 2.4.2).  Each agent then runs over that
buffer without a branch, which the compiler turns into vector instructions, and adds up
all terms of the round in one pass.  An agent's sum has one order, so the result has the
same bits however the agents are cut into blocks for threads.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cache

import numpy as np

from apmethod.compile import compiled, in_blocks, inlined, table_reader
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term, pair_maker
from apmethod.particles import Particles
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.domain import distance_2
from apmethod.perceive.sorting import take


class GatherPass:
    """All terms of one round, compiled into one loop over agents and candidates.

    Args:
        terms: the terms of the round.
        kernel: the scene's smoothing kernel.
        particles: the table; its columns say what is scalar and what is a vector.
        periodic: whether sorted cells may hold images.
    """

    def __init__(self, terms: Sequence[Term], kernel: Kernel, particles: Particles, periodic: bool):
        self.terms = tuple(terms)
        self.kernel = kernel
        self.particles = particles
        names = dict.fromkeys(name for term in self.terms for name in term.columns)
        self.reads = {name: particles.columns[name].components for name in names}
        self.width = sum(term.components or 1 for term in self.terms)
        self._rows = sum(components or 1 for components in self.reads.values())
        self._run = _compile_gather(self.terms, kernel, tuple(self.reads.items()), periodic)

    def __call__(self, cells: SortedCells, sums: np.ndarray, rows: np.ndarray | None) -> None:
        """Write each agent's sums to its row of ``sums``, of shape (agents, width).

        ``rows`` are the rows of the table that the cells were made from, None for all.
        """
        where = cells.row if rows is None else rows[cells.row]
        table = np.empty((self._rows, len(where)))
        for line, component in enumerate(self._components()):
            in_blocks(take, len(where), where, component, table[line])
        in_blocks(
            self._run, len(cells.number), cells.start, cells.low, cells.high, where, cells.image,
            cells.x, cells.y, cells.shift_x, cells.shift_y, table, cells.longest,
            cells.core_radius, cells.core_radius / self.kernel.support, sums, least=200,
        )  # fmt: skip

    def _components(self) -> Iterator[np.ndarray]:
        """The columns that the terms read, vectors by component."""
        for name in self.reads:
            values = self.particles.array(name)
            yield from values.T if values.ndim == 2 else (values,)


def evaluator(terms: Sequence[Term], among: Sequence[Term] | None = None) -> Callable:
    """A compiled ``f(pair, i, j)``: what j gives i, weighed, of all terms in one tuple.

    Terms of ``among`` that are not in ``terms`` give zeros.
    """
    formulas, pieces = {}, []
    for number, term in enumerate(among or terms):
        if term not in terms:
            pieces += ["0.0"] * (term.components or 1)
            continue
        formulas[f"f{number}"] = inlined(term.formula)
        weight = f"j.{term.weight} * " if term.weight else ""
        call = f"f{number}(pair, i, j)"
        parts = [""] if term.components is None else [f"[{n}]" for n in range(term.components)]
        pieces += [f"{weight}{call}{part}" for part in parts]
    # The number of terms is a scene's own, and numba needs each call spelled out.
    return inlined(eval(f"lambda pair, i, j: ({', '.join(pieces)},)", formulas))


def _adder(width: int) -> tuple[Callable, tuple[float, ...]]:
    """A compiled ``total + value if near``, part by part, and the zero it starts from."""
    parts = ", ".join(f"total[{n}] + (value[{n}] if near else 0.0)" for n in range(width))
    return inlined(eval(f"lambda total, value, near: ({parts},)")), (0.0,) * width


@cache
def _compile_gather(
    terms: tuple[Term, ...],
    kernel: Kernel,
    reads: tuple[tuple[str, int | None], ...],
    periodic: bool,
) -> Callable:
    make_pair = pair_maker(kernel)
    read = table_reader(reads)
    evaluate = evaluator(terms)
    evaluate_own = evaluator([term for term in terms if term.own], among=terms)
    width = sum(term.components or 1 for term in terms)
    add, zero = _adder(width)

    @compiled
    def gather(
        first, last, start, low, high, row, image, x, y, shift_x, shift_y, table, longest,
        core_radius, smoothing_length, sums,
    ):  # fmt: skip
        near_x, near_y = np.empty(longest), np.empty(longest)
        over_x, over_y = np.empty(longest), np.empty(longest)
        near = np.empty((table.shape[0], longest))
        middle = low.shape[1] // 2
        radius_2 = core_radius * core_radius
        for cell in range(first, last):
            # LpN: the runs of the surrounding sub-domains, one after the other.
            count = 0
            mine = 0
            for run in range(low.shape[1]):
                begin = low[cell, run]
                length = high[cell, run] - begin
                if run == middle:
                    mine = count + start[cell] - begin
                for k in range(length):
                    near_x[count + k] = x[begin + k]
                    near_y[count + k] = y[begin + k]
                if periodic:
                    for k in range(length):
                        over_x[count + k] = shift_x[begin + k]
                        over_y[count + k] = shift_y[begin + k]
                for line in range(table.shape[0]):
                    for k in range(length):
                        near[line, count + k] = table[line, begin + k]
                count += length
            others = count - 1
            for i in range(start[cell], start[cell + 1]):
                if periodic and image[i]:
                    continue
                # The last candidate takes the agent's own place while it sums.
                own = mine + i - start[cell]
                near_x[own], near_y[own] = near_x[others], near_y[others]
                if periodic:
                    over_x[own], over_y[own] = over_x[others], over_y[others]
                for line in range(table.shape[0]):
                    near[line, own] = near[line, others]
                me = read(table, i)
                x_i, y_i = x[i], y[i]
                total = add(zero, evaluate_own(make_pair(0.0, 0.0, smoothing_length), me, me), True)
                for j in range(others):
                    dx, dy = x_i - near_x[j], y_i - near_y[j]
                    if periodic:
                        dx, dy = dx - over_x[j], dy - over_y[j]
                    value = evaluate(make_pair(dx, dy, smoothing_length), me, read(near, j))
                    total = add(total, value, distance_2(dx, dy) < radius_2)
                near_x[own], near_y[own] = x_i, y_i
                if periodic:
                    over_x[own], over_y[own] = 0.0, 0.0
                for line in range(table.shape[0]):
                    near[line, own] = table[line, i]
                for part in range(width):
                    sums[row[i], part] = total[part]

    return gather
