"""A thread that takes part in compiled passes and is still awake when the next one comes.

To wake a sleeping thread takes some 0.1 to 1 ms (it lies on a sleeping processor, or on
that of the caller), as long as a pass over 10^4 agents.  So a worker that has done its part
watches a number in memory for a while before it goes to sleep, as those of OpenMP do, and
so does the caller that waits for it.  Watching is compiled and leaves the GIL to others.
"""

from __future__ import annotations

from collections.abc import Callable
from queue import SimpleQueue
from threading import Thread

import numpy as np

from apmethod.compile.atomic import read_now
from apmethod.compile.jit import compiled

#: Looks at the number before sleeping: about a millisecond.
_LOOKS = 1_000_000
#: Looks after it has changed, some microseconds, in which whoever changed it lets go of the
#: GIL: to find it taken means to sleep.
_GRACE = 20_000
#: Places of the two numbers, apart by more than what a processor fetches at once.
_ASKED, _DONE = 0, 16


@compiled
def _watch(numbers, place, known, looks, grace):
    """Return once numbers[place] is no longer ``known``, or after so many looks."""
    for _ in range(looks):
        if read_now(numbers, place) != known:
            for _ in range(grace):
                read_now(numbers, place)
            return


class Worker(Thread):
    """Runs what it is asked for, once each time."""

    def __init__(self, name: str):
        super().__init__(name=name, daemon=True)
        self._numbers = np.zeros(_DONE + 1, np.int64)
        self._asleep = False
        self._wake: SimpleQueue[None] = SimpleQueue()
        self._outcomes: SimpleQueue[tuple[int, BaseException | None]] = SimpleQueue()
        self._job: tuple[Callable, tuple] = (tuple, ())
        self._watch(_ASKED, 0, looks=0)  # compiles
        self.start()

    def ask(self, run: Callable, *arguments) -> None:
        """Let the worker call ``run(*arguments)``."""
        self._job = run, arguments
        self._numbers[_ASKED] += 1
        if self._asleep:
            self._wake.put(None)

    def wait(self) -> BaseException | None:
        """Wait until it has, for the error that it has raised, if any."""
        asked = self._numbers[_ASKED]
        self._watch(_DONE, asked - 1)
        done = 0
        while done < asked:  # Ctrl-C may have kept an earlier outcome from being fetched
            done, error = self._outcomes.get()
        return error

    def run(self) -> None:
        """The thread's own work, until the process ends."""
        done = 0
        while True:
            self._watch(_ASKED, done)
            if self._numbers[_ASKED] == done:
                self._sleep(done)
                continue
            call, arguments = self._job
            try:
                call(*arguments)
                error = None
            except BaseException as raised:
                error = raised
            self._job = tuple, ()  # keeps no array alive
            done += 1
            self._outcomes.put((done, error))
            self._numbers[_DONE] = done

    def _sleep(self, done: int) -> None:
        self._asleep = True
        # Asked since: the asker may have seen it awake.
        if self._numbers[_ASKED] == done:
            self._wake.get()
        self._asleep = False

    def _watch(self, place: int, known: int, looks: int = _LOOKS) -> None:
        _watch(self._numbers, place, known, looks, _GRACE)
