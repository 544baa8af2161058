"""Timing contenders in turn, so that a busy moment of the machine meets all of them."""

from __future__ import annotations

import gc
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter, sleep

Report = Callable[[float, int], None]

#: Seconds between two contenders: threads that a peer leaves spinning fall asleep in them.
_PAUSE = 0.01
#: Seconds that it takes a processor to get up to its pace after a pause.
AWAKE = 0.03


@dataclass(frozen=True)
class Times:
    """Seconds that one contender took in each round."""

    seconds: tuple[float, ...]

    @property
    def median(self) -> float:
        """The middle one, which a single busy moment does not change."""
        return median(self.seconds)

    @property
    def minimum(self) -> float:
        """The shortest, the least disturbed by whatever else the machine did."""
        return min(self.seconds)

    def over(self, other: Times) -> float:
        """How many times as long as another contender took, the median over the rounds.

        The two of one round met the same moments of the machine; a machine that changes its
        pace between rounds changes the medians of either more than this.
        """
        return median(a / b for a, b in zip(self.seconds, other.seconds, strict=True))


def stopwatch(action: Callable[[], object]) -> float:
    """Seconds that ``action()`` takes, without pauses of the garbage collector.

    Looking through millions of agents for garbage would otherwise strike a contender by
    chance; `timeit` switches the collector off for the same reason.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        began = perf_counter()
        action()
        return perf_counter() - began
    finally:
        if collecting:
            gc.enable()


def alternate(
    contenders: Mapping[str, Callable[[], float]],
    rounds: int,
    *,
    warm: int = 0,
    awake: float = 0.0,
    before: Callable[[], None] = lambda: None,
    after: Callable[[], None] = lambda: None,
) -> dict[str, Times]:
    """Let each contender run once a round, in turn, there and back.

    What runs just before leaves its data in the caches: every second round goes backwards.

    Args:
        contenders: what to run by name; each gives back the seconds it took.
        rounds: number of rounds.
        warm: runs of a contender just before the one that counts.  Step follows step in a
            simulation, so that each finds its data in the caches and its threads awake.
        awake: seconds that these runs take at least, the more of them the shorter they are;
            for contenders that a run does not change.
        before: called before each round, untimed; it may set the next state for all.
        after: called after each round, untimed.
    """
    seconds: dict[str, list[float]] = {name: [] for name in contenders}
    for number in range(rounds):
        before()
        for name in list(contenders)[:: -1 if number % 2 else 1]:
            sleep(_PAUSE)
            runs, spent = 0, 0.0
            while runs < warm or spent < awake:
                spent += contenders[name]()
                runs += 1
            seconds[name].append(contenders[name]())
        after()
    return {name: Times(tuple(values)) for name, values in seconds.items()}


class Progress:
    """Tells a progress bar how far a sweep over sizes has come, larger sizes counting more.

    Args:
        report: called with the share done and the rounds made.
        sizes: the sizes to come, once for each round.
    """

    def __init__(self, report: Report | None, sizes: Sequence[int]):
        self._report = report or (lambda share, rounds: None)
        self._total, self._done, self._rounds = sum(sizes), 0, 0
        self._report(0.0, 0)

    def made(self, size: int) -> None:
        """One round of this size has been made."""
        self._done += size
        self._rounds += 1
        self._report(self._done / self._total, self._rounds)
