"""Terms: what the two agents of a pair give each other (paper 2.2, 2.3).

A term is a formula for one pair and a parity, which says what the other end gets:

* even: the same, as with W_ij = W_ji;
* odd: the opposite, as with grad W_ij = -grad W_ji;
* directed: a value of its own, never mirrored.

Each end weighs what it gets by a column of the agent it comes from (``weight``, most often
the mass), and the message bus delivers the sum to the column named like the term:

    term_i = sum_j weight_j f(pair, i, j)
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from functools import cache
from math import sqrt
from typing import Any, NamedTuple

from apmethod.compile import inlined, namespace
from apmethod.contribute.smoothing import Kernel
from apmethod.particles import Column
from apmethod.perceive.domain import distance_2

#: A density that is zero, in any unit: what is divided by it is zero itself.
NOTHING = 1e-200

PARITIES = {"even": 1.0, "odd": -1.0, "directed": 0.0}


class Pair(NamedTuple):
    """What every formula may use of a pair: x_i - x_j and the kernel there."""

    x: float
    y: float
    distance: float
    w: float  #: W_ij, per area
    grad_x: float  #: x component of grad_i W_ij
    grad_y: float  #: y component of grad_i W_ij

    def mirrored(self) -> Pair:
        """The same pair from the other end."""
        return Pair(-self.x, -self.y, self.distance, self.w, -self.grad_x, -self.grad_y)


@cache
def pair_maker(kernel: Kernel) -> Callable[[float, float, float], Pair]:
    """``pair(dx, dy, h)`` of one kernel, in Python and in compiled passes."""
    shape, slope = inlined(kernel.shape), inlined(kernel.slope)

    @inlined
    def pair(dx, dy, h):
        square = distance_2(dx, dy)
        per_area = 1.0 / (h * h)  # the same for all pairs, so a compiled loop divides once
        q_2 = square * per_area
        w = shape(q_2) * per_area
        dw = slope(q_2) * (per_area * per_area)
        return Pair(dx, dy, sqrt(square), w, dw * dx, dw * dy)

    return pair


class Term(Column):
    """A sum over neighbours that the message bus delivers to a column.

    Declared in an agent class (by `term`), it is exchanged in every step of that class's
    scenes, and the agent reads it as an attribute.

    Args:
        formula: ``f(pair, i, j)``, a number, or a tuple for a vector term; ``pair`` is a
            `Pair`, and ``i`` and ``j`` have the columns named in ``reads``.  Plain Python
            that numba compiles.  The formula need not care about the core radius: what it
            gives agents further apart, or infinitely far, is dropped (a table that it looks
            a distance up in must have an end for those).
        parity: "even", "odd" or "directed".
        reads: columns of either agent that the formula uses.  One that another term
            delivers puts this term in a later round of messages.
        weight: column of the sending agent by which what it gives is multiplied.
        components: length of the tuple, None for a number.
        own: whether an agent counts itself (r = 0) in the sum.
        unit: physical unit, for people.

    Raises:
        ValueError: for a parity that is missing or unknown.
    """

    def __init__(
        self,
        formula: Callable,
        parity: str | None = None,
        *,
        reads: Sequence[str] = (),
        weight: str | None = None,
        components: int | None = None,
        own: bool = False,
        unit: str = "",
    ):
        super().__init__(components, unit=unit, kept=False)
        self.name = formula.__name__
        if parity not in PARITIES:
            raise ValueError(
                f"term {self.name!r} has parity {parity!r}; declare it as one of "
                f"{', '.join(map(repr, PARITIES))}"
            )
        self.formula = formula
        self.parity = parity
        self.sign = PARITIES[parity]
        self.reads = tuple(reads)
        self.weight = weight
        self.own = own
        self.__doc__ = formula.__doc__

    def __repr__(self) -> str:
        return f"<{self.parity} term {self.name!r}>"

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns that evaluating the term takes."""
        return self.reads + ((self.weight,) if self.weight else ())

    def values(self, pair: Pair, i: Any, j: Any) -> tuple[float, ...]:
        """f(pair, i, j) as a tuple, before weighing; ``i`` and ``j`` may be agents."""
        value = self.formula(pair, i, j)
        return (value,) if self.components is None else tuple(value)

    def check(self, widths: dict[str, int | None]) -> None:
        """Try the formula on a random pair: its length, the columns it reads, its parity.

        Args:
            widths: components of every column that the scene has, None for a scalar.
        """
        draw = random.Random(1)  # the check must not disturb, nor depend on, a run's streams
        row = namespace("Agent", self.reads)

        def someone() -> Any:
            values = []
            for name in self.reads:
                width = widths[name]
                vector = tuple(draw.uniform(0.5, 1.5) for _ in range(width or 1))
                values.append(vector if width else vector[0])
            return row(*values or (0.0,))

        pair = Pair(0.3, -0.4, 0.5, 0.7, -0.9, 1.2)
        i, j = someone(), someone()
        try:
            here, there = self.values(pair, i, j), self.values(pair.mirrored(), j, i)
        except AttributeError as error:
            raise ValueError(
                f"term {self.name!r} reads what it does not declare ({error}); "
                f"name every column it uses in reads, now {self.reads}"
            ) from None
        if len(here) != (self.components or 1):
            raise ValueError(
                f"term {self.name!r} gives {len(here)} numbers; components says {self.components}"
            )
        for a, b in zip(here, there, strict=True):
            if self.sign and abs(a - self.sign * b) > 1e-9 * max(abs(a), abs(b)):
                raise ValueError(
                    f"term {self.name!r} is declared {self.parity} but gives {a:.6g} to one end "
                    f"of a pair and {b:.6g} to the other; declare what it is, or 'directed'"
                )


def term(parity: str | None = None, **options: Any) -> Callable[[Callable], Term]:
    """Decorate a pair formula as a `Term`, at module level or in an agent class::

    class Sheep(AgentParticle):
        @term("even")
        def crowd(pair, i, j):
            return pair.w
    """
    return lambda formula: Term(formula, parity, **options)


def odd_columns(terms: Sequence[Term]) -> frozenset[str]:
    """Columns that have the opposite sign in images in walls that absorb.

    These are the mass, and sums that are weighed by it, or by such a sum.
    """
    odd = {"mass"}
    for _ in terms:  # each may wait for all others
        odd |= {term.name for term in terms if term.weight in odd}
    return frozenset(odd)


@term("even", weight="mass", own=True, unit="mass/area")
def density(pair, i, j):
    """rho_i = sum_j m_j W_ij, the agent itself included (paper eq 2.2 with f = rho)."""
    return pair.w


@term("odd", weight="mass", components=2, unit="mass/volume")
def density_gradient(pair, i, j):
    """sum_j m_j grad_i W_ij: the gradient of the smoothed density."""
    return pair.grad_x, pair.grad_y


@term("even", weight="mass", components=2, reads=("density",), unit="mass^2/length^5")
def density_difference(pair, i, j):
    """sum_j m_j (rho_j - rho_i) grad_i W_ij, rho_i times the gradient of paper eq 2.3."""
    difference = j.density - i.density
    return difference * pair.grad_x, difference * pair.grad_y


@term("odd", weight="mass", components=2, reads=("density",), unit="1/length")
def blob_gradient(pair, i, j):
    """sum_j m_j (1/rho_i + 1/rho_j) grad_i W_ij (Carrillo, Craig and Patacchini 2019)."""
    both = 1.0 / (i.density + NOTHING) + 1.0 / (j.density + NOTHING)
    return both * pair.grad_x, both * pair.grad_y
