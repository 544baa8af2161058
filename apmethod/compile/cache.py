"""Machine code kept on disk, found again by what it was compiled from.

numba's own cache watches the source file of the compiled function only.  A pass here is
put together from functions of many files (a kernel, the terms of a scene, a user's own
pair function), so its key is a fingerprint of all of them: byte code, constants, options,
and the globals and closure cells they use, followed as deep as they go.  Editing any of
them, or another numba, Python or processor, makes another key.
"""

import contextlib
import dis
import hashlib
import os
import pickle
import sys
import tempfile
import types
from collections.abc import Callable, Iterator
from pathlib import Path

import numba
import numpy as np
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.extending import _Intrinsic
from numba.core.serialize import dumps
from numba.misc.appdirs import AppDirs

#: Attribute of a function that holds the options it is compiled with.
OPTIONS = "_compiled_with"


class NotCacheable(TypeError):
    """A compiled function depends on an object whose content cannot be fingerprinted."""


def cache_folder() -> Path:
    """Where machine code is kept: ``$NUMBA_CACHE_DIR`` or the user's cache folder."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    return Path(chosen or AppDirs("apmethod", appauthor=False).user_cache_dir)


def fingerprint(function: Callable) -> str:
    """A hexadecimal digest of all that the machine code of ``function`` depends on.

    Raises:
        NotCacheable: if it uses an object that has no stable description.
    """
    digest = hashlib.sha256(f"{sys.version} numba {numba.__version__}".encode())
    for piece in _describe(function, seen=set()):
        digest.update(piece.encode() + b"\0")
    return digest.hexdigest()


def _describe(value: object, seen: set[int]) -> Iterator[str]:
    if isinstance(value, Dispatcher):
        value = value.py_func
    elif isinstance(value, _Intrinsic):
        value = value._defn
    if isinstance(value, types.FunctionType):
        if id(value) not in seen:
            seen.add(id(value))
            yield from _describe_function(value, seen)
    elif isinstance(value, types.CodeType):
        yield value.co_code.hex()
        yield repr(value.co_names)
        for constant in value.co_consts:
            yield from _describe(constant, seen)
    elif value is None or isinstance(value, bool | int | float | complex | str | bytes):
        yield repr(value)
    elif isinstance(value, tuple | frozenset):
        yield type(value).__name__
        for item in value if isinstance(value, tuple) else sorted(value, key=repr):
            yield from _describe(item, seen)
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    elif isinstance(value, type):
        yield f"{value.__module__}.{value.__qualname__} {getattr(value, '_fields', '')}"
    elif isinstance(value, types.ModuleType):
        yield value.__name__
    elif isinstance(value, types.BuiltinFunctionType | np.ufunc):
        yield repr(value.__name__)
    else:
        raise NotCacheable(f"{value!r} has no stable description")


def _describe_function(function: types.FunctionType, seen: set[int]) -> Iterator[str]:
    code = function.__code__
    yield from _describe(code, seen)
    yield repr(getattr(function, OPTIONS, None))
    for name in _global_names(code):
        if name in function.__globals__:
            yield name
            yield from _describe(function.__globals__[name], seen)
    for cell in function.__closure__ or ():
        yield from _describe(cell.cell_contents, seen)
    yield from _describe(function.__defaults__, seen)


def _global_names(code: types.CodeType) -> list[str]:
    """Names that the code looks up as globals; ``co_names`` has attributes too."""
    names = [i.argval for i in dis.get_instructions(code) if i.opname == "LOAD_GLOBAL"]
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            names += _global_names(constant)
    return names


class ContentCache(_Cache):
    """numba's cache interface over one file for each fingerprint and signature."""

    def __init__(self, function: Callable):
        self._function = function
        self._key: str | None = None
        self._enabled = True

    @property
    def cache_path(self) -> str:
        """The folder, as numba asks for it."""
        return str(cache_folder())

    def load_overload(self, sig, target_context):
        """The machine code for a signature, or None."""
        path = self._path(sig, target_context.codegen())
        if path is None:
            return None
        target_context.refresh()
        try:
            payload = pickle.loads(path.read_bytes())
            return CompileResult._rebuild(target_context, *payload)
        except FileNotFoundError:
            return None
        except Exception:  # a damaged file can fail in any way; compiling mends them all
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
            return None

    def save_overload(self, sig, data) -> None:
        """Keep the machine code for a signature."""
        path = self._path(sig, data.codegen)
        if path is None or data.library.has_dynamic_globals or data.lifted:
            return
        payload = dumps(data._reduce())
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(dir=path.parent)
            with os.fdopen(handle, "wb") as file:
                file.write(payload)
            os.replace(name, path)  # another process sees the whole file or none
        except OSError:
            return  # a read-only or full disk costs the compile time, nothing else

    def _path(self, sig, codegen) -> Path | None:
        if not self._enabled:
            return None
        if self._key is None:
            try:
                self._key = fingerprint(self._function)
            except NotCacheable:
                self._enabled = False
                return None
        rest = repr((getattr(sig, "args", sig), codegen.magic_tuple()))
        name = hashlib.sha256((self._key + rest).encode()).hexdigest()[:32]
        return cache_folder() / f"{self._function.__name__}-{name}.bin"

    def enable(self) -> None:
        """Use the cache."""
        self._enabled = True

    def disable(self) -> None:
        """Leave the cache alone."""
        self._enabled = False

    def flush(self) -> None:
        """Forget what functions of this name have left."""
        for file in cache_folder().glob(f"{self._function.__name__}-*.bin"):
            file.unlink(missing_ok=True)
