"""The two decorators of the compiled tier.

``inlined`` is for the small functions that a pass is made of: they are compiled into
their callers and never on their own.  ``compiled`` is for the passes that Python calls:
their machine code is kept on disk (see `apmethod.compile.cache`).

Both let the compiler reorder and fuse sums, which is what makes them fast, and neither
lets it assume that NaN and infinity do not happen: a NaN has to come out.
"""

from collections.abc import Callable

import numba

from apmethod.compile.cache import ContentCache

_OPTIONS = {
    "nogil": True,
    "error_model": "numpy",
    "forceinline": True,
    # Without "nsz": with it LLVM turns `sum + (value if near else 0)` into a select on
    # the sum, which it can no longer vectorise.
    "fastmath": {"reassoc", "contract"},
}


def inlined(function: Callable) -> Callable:
    """Compile ``function`` into whatever compiled function calls it.

    A function that is compiled already is returned as it is.
    """
    if isinstance(function, numba.core.dispatcher.Dispatcher):
        return function
    return numba.njit(**_OPTIONS)(function)


def compiled(function: Callable) -> Callable:
    """Compile ``function`` for calls from Python, without the GIL, cached on disk."""
    dispatcher = numba.njit(**_OPTIONS)(function)
    dispatcher._cache = ContentCache(function)
    return dispatcher


def plain(function: Callable) -> Callable:
    """The Python function behind a compiled one; any other function as it is."""
    return getattr(function, "py_func", function)
