"""Compiled functions that borrow arrays instead of counting who uses them, large ones too.

numba counts references to an array wherever a function is handed one, by an atomic
operation each.  Rays hand the tree's and the walls' arrays to many functions, small and
large, and the counting took four fifths of their time.  None of them makes arrays or keeps
any, so there is nothing to count: the caller's references outlive the call.  numba's
option for it is ``_nrt``; it has no public name, but is checked: with it a function that
makes an array does not compile.

Large ones are called instead of being inlined everywhere, which compiles in a third of the
time.  Machine code loaded from disk finds what it calls by name, and numba's names are
numbered anew in each process, so a name here tells the content.
"""

from collections.abc import Callable
from uuid import uuid4

import numba
from numba.extending import register_jitable

from apmethod.compile import inlined
from apmethod.compile.cache import ContentCache, NotCacheable, fingerprint

_OPTIONS = {"nogil": True, "error_model": "numpy", "_nrt": False}


#: Decorator of a small function that rounds every operation as Python does.
exact = inlined(exact=True)


def called(function: Callable) -> Callable:
    """The same for a large one: compiled once, and called."""
    register_jitable(**_OPTIONS)(_named_by_content(function))
    return function


def borrowing(function: Callable) -> Callable:
    """As `compiled`: for calls from Python, without the GIL, cached on disk."""
    dispatcher = numba.njit(**_OPTIONS)(_named_by_content(function))
    dispatcher._cache = ContentCache(function)
    return dispatcher


def _named_by_content(function: Callable) -> Callable:
    try:
        content = fingerprint(function)[:16]
    except NotCacheable:
        content = uuid4().hex
    function.__qualname__ += f"_{content}"
    return function
