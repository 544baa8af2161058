"""Large arrays for passes, in memory that arrays of earlier steps have left.

A step makes the same arrays as the one before.  Left to itself the system takes the memory
of large ones back as soon as they are dropped, and clears new memory page by page when the
next step first writes to it: with 10^6 agents, a quarter of the time of a search and sum.
Here the blocks of memory stay, and one whose arrays are all gone serves the next request.
"""

from __future__ import annotations

from math import prod
from sys import getrefcount
from threading import Lock

import numpy as np

#: Bytes below which the system hands out memory that it has at hand.
_SMALL = 1 << 18
#: A block is given to requests of half its size or more.
_SPARE = 2
#: Blocks that have not served one of the last so many requests are given back.
_IDLE = 500
#: Bytes: lines of the cache begin at multiples of it.
_LINE = 64

_lock = Lock()
_requests = 0


class _Block:
    """Some bytes; every array in them refers to ``memory``."""

    def __init__(self, size: int):
        self.memory = np.empty(size + _LINE, np.uint8)
        self.first = -self.memory.ctypes.data % _LINE
        self.size = size
        self.used = _requests


_blocks = [_Block(1)]
#: References to the memory of a block that no array is in.
_NOBODY = getrefcount(_blocks[0].memory)


def empty(shape: int | tuple[int, ...], dtype: type = float) -> np.ndarray:
    """An array of that shape whose contents are arbitrary, as `numpy.empty` makes it."""
    size = prod(shape if isinstance(shape, tuple) else (shape,)) * np.dtype(dtype).itemsize
    if size < _SMALL:
        return np.empty(shape, dtype)
    with _lock:
        block = _block_for(size)
        array = block.memory[block.first : block.first + size]
    return array.view(dtype).reshape(shape)


def zeros(shape: int | tuple[int, ...], dtype: type = float) -> np.ndarray:
    """An array of zeros, as `numpy.zeros` makes it."""
    array = empty(shape, dtype)
    array.fill(0)
    return array


def _block_for(size: int) -> _Block:
    """A block that nobody uses."""
    global _requests
    _requests += 1
    for block in _blocks:
        if size <= block.size <= _SPARE * size and getrefcount(block.memory) == _NOBODY:
            break
    else:
        _blocks[:] = [each for each in _blocks if _requests - each.used < _IDLE]
        block = _Block(size + size // 8)  # room for a few more agents
        _blocks.append(block)
    block.used = _requests
    return block
