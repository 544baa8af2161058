"""Blocks of one compiled pass on several threads.

A pass releases the GIL and writes each agent's results from that agent's own sums only,
so cutting the population into blocks changes no bit of the result, however many threads
there are.
"""

import os
from collections.abc import Callable
from itertools import pairwise
from threading import Lock

from apmethod.checks import whole_number
from apmethod.compile.worker import Job, Worker

#: Agents in a block of a pass that does little with each, below which another thread does not
#: pay (measured).
WORTH = 7_000
_threads: int | None = None
_workers: list[Worker] = []
#: Held by the thread whose pass the workers take part in.
_busy = Lock()


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
    global _threads
    _threads = whole_number("threads", count, least=1)


def in_blocks(run: Callable, count: int, *arguments, least: int = WORTH) -> None:
    """Call ``run(first, last, *arguments)`` so that the blocks cover ``range(count)``.

    Below ``least`` items a block, another thread does not pay.
    """
    blocks = min(threads(), count // least)
    if blocks < 2 or not _busy.acquire(blocking=False):
        run(0, count, *arguments)
        return
    try:
        while len(_workers) < blocks - 1:
            _workers.append(Worker(f"apmethod-{len(_workers) + 1}"))
        edges = [count * block // blocks for block in range(blocks + 1)]
        job, asked = Job(run, pairwise(edges), arguments), _workers[: blocks - 1]
        for worker in asked:
            worker.ask(job)
        try:
            job.take_part()
        finally:
            job.end()
            errors = [worker.wait() for worker in asked]
    finally:
        _busy.release()
    for error in filter(None, errors):
        raise error


def _processors() -> int:
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # only Linux tells
        return os.cpu_count() or 1


def _forget_workers() -> None:
    global _busy
    _workers.clear()
    _busy = Lock()


# A forked child inherits the workers but none of their threads, and would wait for ever.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_workers)
