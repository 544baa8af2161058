"""Reading one agent out of columns, so that a formula sees ``agent.density`` in both tiers.

A pair function or a law reads attributes of the agents it is given.  On one agent in
Python they are the agent's own; in a compiled pass they are fields of a named tuple that
the functions made here build from arrays.  numba compiles that tuple away.
"""

from collections import namedtuple
from collections.abc import Callable, Sequence
from functools import cache

from apmethod.compile.jit import inlined


@cache
def namespace(name: str, fields: tuple[str, ...]) -> type:
    """A named tuple type, with a filler field where numba would refuse an empty one."""
    return namedtuple(name, fields or ("nothing",))


def table_reader(columns: Sequence[tuple[str, int | None]]) -> Callable:
    """A compiled ``read(table, k)`` for a table of one row a component, (rows, agents).

    Args:
        columns: for each column its name and number of components, None for a scalar.
    """
    row = 0
    fields = []
    for _, components in columns:
        if components is None:
            fields.append(f"table[{row}, k]")
            row += 1
        else:
            parts = (f"table[{row + part}, k]" for part in range(components))
            fields.append(f"({', '.join(parts)},)")
            row += components
    return _reader("table", columns, fields)


def column_reader(columns: Sequence[tuple[str, int | None]]) -> Callable:
    """A compiled ``read(columns, k)`` for a tuple of arrays, (agents,) or (agents, n)."""
    fields = []
    for place, (_, components) in enumerate(columns):
        if components is None:
            fields.append(f"columns[{place}][k]")
        else:
            parts = (f"columns[{place}][k, {part}]" for part in range(components))
            fields.append(f"({', '.join(parts)},)")
    return _reader("columns", columns, fields)


def _reader(argument: str, columns: Sequence, fields: list[str]) -> Callable:
    # The number of fields is a scene's own, and numba needs each spelled out.
    row = namespace("Row", tuple(name for name, _ in columns))
    source = f"lambda {argument}, k: Row({', '.join(fields) or '0.0'})"
    return inlined(eval(source, {"Row": row}))
