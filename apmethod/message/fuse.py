"""All terms of a round as one function of a pair, for compiled passes."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from apmethod.compile import inlined, keep, table_reader
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Pair, Term, pair_maker


class Ingredients(NamedTuple):
    """What a compiled pass over pairs is put together from."""

    make_pair: Callable  #: pair(dx, dy, h), with the kernel evaluated
    read: Callable  #: read(table, k), the columns of one agent by name
    evaluate: Callable  #: f(pair, i, j), what j gives i
    evaluate_own: Callable  #: the same for the terms that count an agent itself
    add: Callable  #: add(total, value, near)
    zero: tuple[float, ...]  #: what totals start from


def ingredients(
    terms: tuple[Term, ...], kernel: Kernel, reads: tuple[tuple[str, int | None], ...]
) -> Ingredients:
    """The parts of a pass for the terms of a round.

    Args:
        terms: the terms of the round.
        kernel: smoothing kernel.
        reads: name and components of each column that the terms read.
    """
    own = [term for term in terms if term.own]
    return Ingredients(
        pair_maker(kernel),
        table_reader(reads),
        evaluator(terms),
        evaluator(own, among=terms),
        *adder(width_of(terms)),
    )


def width_of(terms: Sequence[Term]) -> int:
    """How many numbers a message has."""
    return sum(term.components or 1 for term in terms)


def evaluator(terms: Sequence[Term], among: Sequence[Term] | None = None) -> Callable:
    """A compiled ``f(pair, i, j)``: what j gives i, weighed, of all terms in one tuple.

    Terms of ``among`` that are not in ``terms`` give zeros.
    """
    return _tuple_of(
        [
            (term, "pair, i, j", f"j.{term.weight} * " if term.weight else "")
            if term in terms
            else (term, None, "")
            for term in among or terms
        ]
    )


def mirror_evaluator(terms: Sequence[Term]) -> Callable:
    """A compiled ``f(pair, i, j)``: what i gives j, the other half of each message."""
    pieces = []
    for term in terms:
        weight = f"i.{term.weight} * " if term.weight else ""
        if term.sign:
            pieces.append((term, "pair, i, j", f"{term.sign} * {weight}"))
        else:
            pieces.append((term, "mirrored(pair), j, i", weight))
    return _tuple_of(pieces)


def adder(width: int) -> tuple[Callable, tuple[float, ...]]:
    """A compiled ``total + value if near``, part by part, and the zero it starts from."""
    parts = ", ".join(f"total[{n}] + keep(near, value[{n}])" for n in range(width))
    add = eval(f"lambda total, value, near: ({parts},)", {"keep": keep})
    return inlined(add), (0.0,) * width


@inlined
def mirrored(pair):
    """A pair from its other end."""
    return Pair(-pair.x, -pair.y, pair.distance, pair.w, -pair.grad_x, -pair.grad_y)


def _tuple_of(pieces: Sequence[tuple[Term, str | None, str]]) -> Callable:
    """A compiled tuple of terms, each with its arguments (None: zeros) and a factor."""
    formulas, values = {"mirrored": mirrored}, []
    for number, (term, arguments, factor) in enumerate(pieces):
        if arguments is None:
            values += ["0.0"] * (term.components or 1)
            continue
        formulas[f"f{number}"] = inlined(term.formula, arrays=True)
        parts = [""] if term.components is None else [f"[{n}]" for n in range(term.components)]
        values += [f"{factor}f{number}({arguments}){part}" for part in parts]
    # The number of terms is a scene's own, and numba needs each call spelled out.
    return inlined(eval(f"lambda pair, i, j: ({', '.join(values)},)", formulas))
