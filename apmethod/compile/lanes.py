"""Whole vectors at a time, spelled out for the compiler.

A loop over a few numbers is compiled into one for many of them, one for whole vectors, one
for the rest, and tests of which one will do; for runs of some twenty agents these tests take
longer than the work.  These functions are one instruction, or one for each narrower vector
of a processor that has no wider ones.  They look at `LANES` numbers even where fewer count:
arrays need so much room behind them.
"""

from llvmlite import ir
from numba.core import types
from numba.core.errors import TypingError
from numba.extending import intrinsic

from apmethod.compile.vectors import LANES


def _vector():
    return ir.VectorType(ir.DoubleType(), LANES)


def _place(context, builder, kind, array, place):
    """Where in memory the vector at array[place] begins."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [place]), _vector().as_pointer())


def _splat(builder, number, vector):
    """A vector of one and the same number."""
    index = ir.IntType(32)
    nothing = ir.Constant(vector, ir.Undefined)
    first = builder.insert_element(nothing, number, ir.Constant(index, 0))
    everywhere = ir.Constant(ir.VectorType(index, LANES), [0] * LANES)
    return builder.shuffle_vector(first, nothing, everywhere)


def _must_be_columns(*arrays):
    """Whole vectors are read from memory as it is: floats that lie side by side."""
    for array in arrays:
        if (array.ndim, array.layout, array.dtype) != (1, "C", types.float64):
            raise TypingError(f"{array}: must be a contiguous column of floats")


@intrinsic
def fill_lanes(typingctx, target, at, value):
    """target[at : at + LANES] = value."""
    _must_be_columns(target)

    def fill(context, builder, signature, arguments):
        array, place, number = arguments
        pointer = _place(context, builder, signature.args[0], array, place)
        builder.store(_splat(builder, number, _vector()), pointer, align=8)
        return context.get_dummy_value()

    return types.none(target, types.intp, types.float64), fill


@intrinsic
def copy_lanes(typingctx, target, at, source, start):
    """target[at : at + LANES] = source[start : start + LANES]."""
    _must_be_columns(target, source)

    def copy(context, builder, signature, arguments):
        to, at, source, start = arguments
        values = builder.load(_place(context, builder, signature.args[2], source, start), align=8)
        builder.store(values, _place(context, builder, signature.args[0], to, at), align=8)
        return context.get_dummy_value()

    return types.none(target, types.intp, source, types.intp), copy


@intrinsic
def add_lanes(typingctx, target, at, source, start, count):
    """target[at : at + LANES] += source[start : start + LANES], of which ``count`` count."""
    _must_be_columns(target, source)

    def add(context, builder, signature, arguments):
        to, at, source, start, count = arguments
        numbers = ir.VectorType(ir.IntType(64), LANES)
        counts = builder.icmp_signed(
            "<", ir.Constant(numbers, list(range(LANES))), _splat(builder, count, numbers)
        )
        nothing = ir.Constant(_vector(), [0.0] * LANES)
        values = builder.load(_place(context, builder, signature.args[2], source, start), align=8)
        values = builder.select(counts, values, nothing)
        pointer = _place(context, builder, signature.args[0], to, at)
        builder.store(builder.fadd(builder.load(pointer, align=8), values), pointer, align=8)
        return context.get_dummy_value()

    return types.none(target, types.intp, source, types.intp, types.intp), add


@intrinsic
def keep(typingctx, condition, value):
    """``value`` if the condition holds, else 0, without a branch."""

    def select(context, builder, signature, arguments):
        nothing = context.get_constant(types.float64, 0.0)
        return builder.select(arguments[0], arguments[1], nothing)

    return types.float64(types.boolean, types.float64), select
