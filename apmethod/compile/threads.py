"""Blocks of one compiled pass on several threads.

A pass releases the GIL and writes each agent's results from that agent's own sums only,
so cutting the population into blocks changes no bit of the result, however many threads
there are.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from apmethod.checks import whole_number

_pool: ThreadPoolExecutor | None = None
_threads: int | None = None


def threads() -> int:
    """The number of threads passes run on: ``set_threads``, ``$APMETHOD_THREADS`` or all."""
    global _threads
    if _threads is None:
        wanted = os.environ.get("APMETHOD_THREADS", "")
        set_threads(int(wanted) if wanted.isdigit() and int(wanted) else _processors())
    return _threads


def set_threads(count: int) -> None:
    """Run the following passes on ``count`` threads; the results keep every bit.

    Raises:
        ValueError: if ``count`` is not a whole number of at least 1.
    """
    global _threads, _pool
    _threads, _pool = whole_number("threads", count, least=1), None


def in_blocks(run: Callable, count: int, *arguments, least: int = 20_000) -> None:
    """Call ``run(first, last, *arguments)`` so that the blocks cover ``range(count)``.

    Below ``least`` items a block, a pass is over before another thread has woken up.
    """
    global _pool
    blocks = min(threads(), count // least)
    if blocks < 2:
        run(0, count, *arguments)
        return
    if _pool is None:
        _pool = ThreadPoolExecutor(threads() - 1, thread_name_prefix="apmethod")
    edges = [count * block // blocks for block in range(blocks + 1)]
    jobs = [_pool.submit(run, edges[k], edges[k + 1], *arguments) for k in range(1, blocks)]
    run(0, edges[1], *arguments)
    for job in jobs:
        job.result()


def _processors() -> int:
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # only Linux tells
        return os.cpu_count() or 1


def _forget_pool() -> None:
    global _pool
    _pool = None


# A forked child inherits the pool but none of its threads, and would wait for ever.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_pool)
