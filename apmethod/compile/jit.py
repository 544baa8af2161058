"""The two decorators of the compiled tier.

``inlined`` is for the small functions that a pass is made of: they are compiled into
their callers, and called from Python they stay Python, so that one agent's step runs the
very same lines.  ``compiled`` is for the passes that Python calls: their machine code is
kept on disk (see `apmethod.compile.cache`).

Both let the compiler reorder and fuse sums, which is what makes them fast, and neither
lets it assume that NaN and infinity do not happen: a NaN has to come out.
"""

from collections.abc import Callable
from functools import partial

import numba
from numba.extending import register_jitable

import apmethod.compile.vectors  # noqa: F401  (before anything is compiled)
from apmethod.compile.cache import OPTIONS, ContentCache

_OPTIONS = {
    "nogil": True,
    "error_model": "numpy",
    "forceinline": True,
    # Without "nsz": with it LLVM turns `sum + (value if near else 0)` into a select on
    # the sum, which it can no longer vectorise.
    "fastmath": {"reassoc", "contract"},
}


def inlined(
    function: Callable | None = None, *, exact: bool = False, arrays: bool = False
) -> Callable:
    """Let compiled functions call ``function``, which is compiled into them.

    The function itself stays what it is: called from Python it runs in Python.

    Args:
        function: plain Python that numba compiles; left out where options are given to a
            decorator.
        exact: round every operation as Python does, where a decision hangs on the result.
        arrays: whether it may make arrays.  One that does not only borrows those that it is
            handed: to count who refers to them takes longer than many a function's work.
    """
    if function is None:
        return partial(inlined, exact=exact, arrays=arrays)
    if not hasattr(function, OPTIONS):
        options = _OPTIONS | {"_nrt": arrays} | ({"fastmath": False} if exact else {})
        register_jitable(**options)(function)
        _note(function, options)
    return function


def compiled(function: Callable) -> Callable:
    """Compile ``function`` for calls from Python, without the GIL, cached on disk."""
    _note(function, _OPTIONS)
    dispatcher = numba.njit(**_OPTIONS)(function)
    dispatcher._cache = ContentCache(function)
    return dispatcher


def plain(function: Callable) -> Callable:
    """The Python function behind one that `compiled` made."""
    return function.py_func


def _note(function: Callable, options: dict) -> None:
    """Let the fingerprint of ``function`` tell what it is compiled with."""
    flags = options["fastmath"] or ()
    setattr(function, OPTIONS, sorted((options | {"fastmath": sorted(flags)}).items()))
