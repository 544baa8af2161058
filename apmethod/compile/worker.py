"""A thread that takes part in compiled passes and is still awake when the next one comes.

To wake a sleeping thread takes some 0.1 to 1 ms (it lies on a sleeping processor, or on
that of the caller), as long as a pass over 10^4 agents.  So a worker that has done its part
watches a number in memory for a while before it goes to sleep, as those of OpenMP do, and
so does the caller that waits for it.  Watching is compiled and leaves the GIL to others.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
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


class Job:
    """A pass in blocks, each of which is run by whoever comes first.

    On a busy machine a worker may come late or not at all: whoever has asked it for help does
    not wait for that, but runs what is left.
    """

    def __init__(self, run: Callable, blocks: Iterable[tuple[int, int]], arguments: tuple):
        self._run, self._blocks, self._arguments = run, deque(blocks), arguments

    def take_part(self) -> None:
        """Run blocks until none is left."""
        while self._blocks:
            try:
                first, last = self._blocks.popleft()
            except IndexError:
                return  # another thread was quicker
            self._run(first, last, *self._arguments)

    def end(self) -> None:
        """Leave nothing to be begun, for one that has failed."""
        self._blocks.clear()


class Worker(Thread):
    """Takes part in the jobs that it is asked for."""

    def __init__(self, name: str):
        super().__init__(name=name, daemon=True)
        self._numbers = np.zeros(_DONE + 1, np.int64)
        self._asleep = False
        self._wake: SimpleQueue[None] = SimpleQueue()
        self._outcomes: SimpleQueue[tuple[int, BaseException | None]] = SimpleQueue()
        self._asked: tuple[int, Job] | None = None
        self._begun = 0
        self._watch(_ASKED, 0, looks=0)  # compiles
        self.start()

    def ask(self, job: Job) -> None:
        """Let the worker take part in a job."""
        number = int(self._numbers[_ASKED]) + 1
        self._asked = number, job
        self._numbers[_ASKED] = number
        if self._asleep and self._wake.empty():  # once, however often it is asked meanwhile
            self._wake.put(None)

    def wait(self) -> BaseException | None:
        """Wait until it is through with a job of which nothing is left, if it has begun.

        Returns:
            The error that it has raised, if any.
        """
        asked = int(self._numbers[_ASKED])
        self._asked = None  # keeps no array alive
        if self._begun != asked:
            return None  # and will find nothing to do
        done = int(self._numbers[_DONE])
        if done != asked:
            self._watch(_DONE, done)
        done, error = 0, None
        while done < asked:  # Ctrl-C may have kept an earlier outcome from being fetched
            done, error = self._outcomes.get()
        return error

    def run(self) -> None:
        """The thread's own work, until the process ends."""
        done = 0
        while True:
            self._watch(_ASKED, done)
            number = int(self._numbers[_ASKED])
            if number == done:
                self._sleep(done)
                continue
            asked = self._asked
            if asked is not None:
                number = self._take_part(*asked)
            del asked
            done = number

    def _take_part(self, number: int, job: Job) -> int:
        # Before the first block is taken: who finds none left then knows whom to wait for.
        self._begun = number
        error = None
        try:
            job.take_part()
        except BaseException as raised:
            error = raised
        self._outcomes.put((number, error))
        self._numbers[_DONE] = number
        return number

    def _sleep(self, done: int) -> None:
        self._asleep = True
        # Asked since: the asker may have seen it awake.
        if self._numbers[_ASKED] == done:
            self._wake.get()
        self._asleep = False

    def _watch(self, place: int, known: int, looks: int = _LOOKS) -> None:
        _watch(self._numbers, place, known, looks, _GRACE)
