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
from apmethod.compile import column_reader, compiled, in_blocks, inlined, namespace, plain
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term
from apmethod.particles import Particles


class Now(NamedTuple):
    """What every law may use besides the agent."""

    time: float  #: physical time at which the law is evaluated
    smoothing_length: float  #: h of the smoothing kernel
    own_w: float  #: the kernel at distance 0, per area


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

    def turning(self, positions: np.ndarray, time: float) -> float:
        """How fast the law turns what it moves, 1/time; it limits chosen steps."""
        return 0.0

    def of(self, agent: Any, now: Now) -> np.ndarray:
        """The law on one agent, in Python: an array of shape (2,)."""
        p = self._names(*now, *self.parameters.values())
        return np.array(self.formula(agent, p), float)

    def add_to(self, total: np.ndarray, particles: Particles, rows: np.ndarray, now: Now) -> None:
        """Add the law's value for the agents in ``rows`` to those rows of ``total``, (n, 2)."""
        columns = tuple(particles.array(name) for name in self.reads) or (total,)
        p = np.array([*now, *self.parameters.values()])
        widths = tuple((name, particles.columns[name].components) for name in self.reads)
        run = _compile_law(self.formula, widths, self._names._fields)
        in_blocks(run, len(rows), rows, columns, p, total)


@cache
def _compile_law(
    formula: Callable, reads: tuple[tuple[str, int | None], ...], parameters: tuple[str, ...]
) -> Callable:
    read = column_reader(reads)
    inlined(formula)
    names = namespace("Parameters", parameters)
    fields = ", ".join(f"p[{k}]" for k in range(len(parameters)))
    unpack = inlined(eval(f"lambda p: names({fields})", {"names": names}))

    @compiled
    def add_law(first, last, rows, columns, p, total):
        now = unpack(p)
        for k in range(first, last):
            row = rows[k]
            x, y = formula(read(columns, row), now)
            total[row, 0] += x
            total[row, 1] += y

    return add_law


class Flow(Law):
    """A given velocity field V(x, y, t), of which each agent takes the value where it is.

    Args:
        field: ``V(x, y, t)`` giving (x, y); plain Python that numba compiles.
        name: what ``explain`` calls it.
    """

    def __init__(self, field: Callable, name: str = "flow"):
        self.field = inlined(field)
        try:
            value = tuple(float(part) for part in field(0.5, 0.25, 0.0))
        except TypeError as error:
            raise ValueError(f"flow {field!r} is not V(x, y, t) giving (x, y): {error}") from None
        if len(value) != 2:
            raise ValueError(f"flow {field!r} gives {len(value)} numbers; it must give (x, y)")
        super().__init__(name, _at_position(self.field), reads=("position",))

    def turning(self, positions: np.ndarray, time: float) -> float:
        """How fast the flow turns or stretches: the largest |grad V| at ``positions``, 1/time."""
        extent = float(np.ptp(positions, axis=0).max()) if len(positions) else 0.0
        return _compile_turning(self.field)(positions, 1e-4 * extent or 1e-4, time)

    def carry(
        self,
        arrived: np.ndarray,
        places: np.ndarray,
        rows: np.ndarray,
        time: float,
        span: float,
        turning: float,
        *,
        in_python: bool,
    ) -> None:
        """Carry ``places[rows]``, of shape (n, 2), by the flow alone to ``arrived[rows]``.

        Classical Runge-Kutta, in as many steps as keep the turn of each below 0.05.
        """
        steps = max(1, int(np.ceil(abs(span) * turning / 0.05)))
        run = _compile_carry(self.field)
        if in_python:
            plain(run)(0, len(rows), rows, places, time, span, steps, arrived)
        else:
            in_blocks(run, len(rows), rows, places, time, span, steps, arrived)


@cache
def _at_position(field: Callable) -> Callable:
    def formula(agent, p):
        return field(agent.position[0], agent.position[1], p.time)

    return formula


@cache
def _compile_turning(field: Callable) -> Callable:
    @compiled
    def turning(positions, step, time):
        largest = 0.0
        for k in range(positions.shape[0]):
            x, y = positions[k, 0], positions[k, 1]
            east, west = field(x + step, y, time), field(x - step, y, time)
            north, south = field(x, y + step, time), field(x, y - step, time)
            a, b = east[0] - west[0], north[0] - south[0]
            c, d = east[1] - west[1], north[1] - south[1]
            # Half the squared Frobenius norm: the squared angular velocity of a rotation.
            largest = max(largest, 0.5 * (a * a + b * b + c * c + d * d))
        return np.sqrt(largest) / (2.0 * step)

    return turning


@cache
def _compile_carry(field: Callable) -> Callable:
    @compiled
    def carry(first, last, rows, places, time, span, steps, arrived):
        dt = span / steps
        for k in range(first, last):
            x, y = places[rows[k], 0], places[rows[k], 1]
            for step in range(steps):
                t = time + step * dt
                u1, v1 = field(x, y, t)
                u2, v2 = field(x + 0.5 * dt * u1, y + 0.5 * dt * v1, t + 0.5 * dt)
                u3, v3 = field(x + 0.5 * dt * u2, y + 0.5 * dt * v2, t + 0.5 * dt)
                u4, v4 = field(x + dt * u3, y + dt * v3, t + dt)
                x += dt / 6.0 * (u1 + 2.0 * u2 + 2.0 * u3 + u4)
                y += dt / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4)
            arrived[rows[k], 0], arrived[rows[k], 1] = x, y

    return carry
