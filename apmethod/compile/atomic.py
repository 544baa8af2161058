"""Numbers in memory that several threads read and write at once, from compiled functions."""

from numba.core import types
from numba.extending import intrinsic


@intrinsic
def read_now(typingctx, numbers, place):
    """numbers[place] as it is in memory now; a plain read in a loop is made once."""

    def read(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.load_atomic(builder.gep(array.data, [arguments[1]]), "acquire", 8)

    return types.int64(numbers, types.intp), read


@intrinsic
def claim(typingctx, numbers, place):
    """numbers[place], which grows by one: no two threads get the same."""

    def add(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        one = context.get_constant(types.int64, 1)
        return builder.atomic_rmw("add", builder.gep(array.data, [arguments[1]]), one, "monotonic")

    return types.int64(numbers, types.intp), add
