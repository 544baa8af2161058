"""How plain Python functions become machine code: compilation, its cache, and threads."""

from apmethod.compile import memory
from apmethod.compile.atomic import claim
from apmethod.compile.jit import compiled, inlined, plain
from apmethod.compile.lanes import add_lanes, copy_lanes, fill_lanes, keep
from apmethod.compile.rows import column_reader, namespace, table_reader
from apmethod.compile.threads import WORTH, in_blocks, set_threads, threads
from apmethod.compile.vectors import LANES

__all__ = [
    "LANES",
    "WORTH",
    "add_lanes",
    "claim",
    "column_reader",
    "compiled",
    "copy_lanes",
    "fill_lanes",
    "in_blocks",
    "inlined",
    "keep",
    "memory",
    "namespace",
    "plain",
    "set_threads",
    "table_reader",
    "threads",
]
