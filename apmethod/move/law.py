"""Laws: what an agent's velocity (or acceleration) is made of.

A law is a formula for one agent.  A scene adds up as many as it names: a diffusion
velocity, a given flow, a force.  The formula runs in Python on one agent and compiled on
all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from apmethod.checks import finite_number
from apmethod.compile import column_reader, compiled, in_blocks, inlined, namespace
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term
from apmethod.particles import Particles


class Now(NamedTuple):
    """What every law may use besides the agent.

    Where agents have core radii of their own, the last two are arrays, a number for each
    row, and a formula gets those of its agent.
    """

    time: float  #: physical time at which the law is evaluated
    smoothing_length: float | np.ndarray  #: h of the smoothing kernel
    own_w: float | np.ndarray  #: the kernel at distance 0, per area


class Law:
    """A contribution to every agent's velocity, or acceleration.

    Args:
        name: what ``explain`` calls it.
        formula: ``f(agent, p)`` giving (x, y).  ``agent`` has the columns named in
            ``reads``; ``p`` has what `Now` has, and the parameters.
        reads: columns of the agent that the formula uses.
        parameters: numbers that the formula reads from ``p``; changing one needs no
            new compilation.
        terms: what the message bus must exchange for the formula.
    """

    #: How a stable step shrinks with the unevenness of neighbours, and the unevenness from which
    #: on no step is stable; see `apmethod.unevenness`.
    uneven_power, uneven_end = 0.0, np.inf

    def __init__(
        self,
        name: str,
        formula: Callable,
        *,
        reads: Sequence[str] = (),
        parameters: Mapping[str, float] | None = None,
        terms: Sequence[Term] = (),
    ):
        self.name = name
        self.formula = formula
        self.reads = tuple(reads)
        self.parameters = {k: finite_number(k, v) for k, v in (parameters or {}).items()}
        self.terms = tuple(terms)

    def __repr__(self) -> str:
        values = ", ".join(f"{key}={value:g}" for key, value in self.parameters.items())
        return f"{self.name} ({values})" if values else self.name

    @property
    def interacts(self) -> bool:
        """Whether the law needs an agent's neighbours."""
        return bool(self.terms)

    @cached_property
    def _names(self) -> type:
        return namespace("Parameters", (*Now._fields, *self.parameters))

    def check(self, kernel: Kernel) -> None:
        """Refuse a smoothing kernel that the law cannot work with."""

    def largest_step(self, kernel: Kernel, smoothing_length: float, reach: float) -> float:
        """The largest stable time step, for an integrator that is stable down to -reach."""
        return np.inf

    def largest_speed(self, smoothing_length: float) -> float:
        """The speed that the law limits itself to."""
        return np.inf

    def turning(self, positions: np.ndarray, time: float) -> float:
        """How fast the law turns or stretches what it moves, 1/time; it limits chosen steps."""
        return 0.0

    def deforming(self, positions: np.ndarray, time: float) -> float:
        """How fast the law stretches what it moves, 1/time, without what it turns rigidly."""
        return 0.0

    def of(self, agent: Any, now: Now) -> np.ndarray:
        """The law on one agent, in Python: an array of shape (2,)."""
        p = self._names(*now, *self.parameters.values())
        return np.array(self.formula(agent, p), float)

    def add_to(self, total: np.ndarray, particles: Particles, rows: np.ndarray, now: Now) -> None:
        """Add the law's value for the agents in ``rows`` to those rows of ``total``, (n, 2)."""
        columns = tuple(particles.array(name) for name in self.reads) or (total,)
        own_radii = isinstance(now.smoothing_length, np.ndarray)
        lengths = np.column_stack(now[1:]) if own_radii else np.array([now[1:]])
        p = np.array([now.time, *self.parameters.values()])
        widths = tuple((name, particles.columns[name].components) for name in self.reads)
        run = _compile_law(self.formula, widths, self._names._fields, own_radii)
        in_blocks(run, len(rows), rows, columns, p, lengths, total)


@cache
def _compile_law(
    formula: Callable,
    reads: tuple[tuple[str, int | None], ...],
    parameters: tuple[str, ...],
    own_radii: bool,
) -> Callable:
    read = column_reader(reads)
    inlined(formula, arrays=True)
    names = namespace("Parameters", parameters)
    fields = "".join(f", p[{k}]" for k in range(1, len(parameters) - 2))
    unpack = inlined(eval(f"lambda p, h, w: names(p[0], h, w{fields})", {"names": names}))

    @compiled
    def add_law(first, last, rows, columns, p, lengths, total):
        now = unpack(p, lengths[0, 0], lengths[0, 1])
        for k in range(first, last):
            row = rows[k]
            if own_radii:
                now = unpack(p, lengths[row, 0], lengths[row, 1])
            x, y = formula(read(columns, row), now)
            total[row, 0] += x
            total[row, 1] += y

    return add_law
