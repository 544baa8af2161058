"""How plain Python functions become machine code: compilation, its cache, and threads."""

from apmethod.compile import memory
from apmethod.compile.atomic import claim
from apmethod.compile.jit import compiled, inlined, plain
from apmethod.compile.rows import column_reader, namespace, table_reader
from apmethod.compile.threads import in_blocks, set_threads, threads
from apmethod.compile.vectors import LANES

__all__ = [
    "LANES",
    "claim",
    "column_reader",
    "compiled",
    "in_blocks",
    "inlined",
    "memory",
    "namespace",
    "plain",
    "set_threads",
    "table_reader",
    "threads",
]
