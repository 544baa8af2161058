"""Blocks of passes on several threads: each item once, errors raised, workers awake or asleep."""

import multiprocessing
import sys
import threading
import time

import numpy as np
import pytest

from apmethod import set_threads
from apmethod.compile import in_blocks, threads
from apmethod.compile.worker import Worker


@pytest.fixture(autouse=True, params=[1, 2, 3, 8])
def number_of_threads(request):
    before = threads()
    set_threads(request.param)
    yield request.param
    set_threads(before)


def mark(first, last, seen, who):
    seen[first:last] += 1
    who[first:last] = threading.get_ident()


@pytest.mark.parametrize("count", [0, 1, 2, 3, 100, 1001])
def test_every_item_comes_once_and_blocks_follow_each_other(count, number_of_threads):
    seen, who = np.zeros(count, int), np.zeros(count, np.int64)
    in_blocks(mark, count, seen, who, least=10)
    assert (seen == 1).all()
    blocks = max(1, min(number_of_threads, count // 10))
    assert np.count_nonzero(np.diff(who)) == (blocks - 1 if count else 0)


def test_blocks_again_and_again_after_pauses_of_any_length():
    seen, who = np.zeros(64, int), np.zeros(64, np.int64)
    for number, pause in enumerate((0.0, 0.0, 0.001, 0.003, 0.05, 0.0, 0.002), start=1):
        time.sleep(pause)  # workers fall asleep within some milliseconds
        in_blocks(mark, 64, seen, who, least=1)
        assert (seen == number).all()


def test_an_error_in_any_block_is_raised_and_the_next_pass_is_sound():
    def fail(first, last, bad):
        if first <= bad < last:
            raise ZeroDivisionError(f"item {bad}")

    for bad in (0, 31, 63):
        with pytest.raises(ZeroDivisionError, match=f"item {bad}"):
            in_blocks(fail, 64, bad, least=1)
    in_blocks(fail, 64, 64, least=1)


def test_passes_of_several_threads_at_once_do_not_mix():
    failures = []

    def passes():
        for _ in range(50):
            seen, who = np.zeros(64, int), np.zeros(64, np.int64)
            in_blocks(mark, 64, seen, who, least=1)
            if not (seen == 1).all():
                failures.append(seen)

    callers = [threading.Thread(target=passes) for _ in range(4)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert not failures


def _in_a_child(answer):
    seen, who = np.zeros(64, int), np.zeros(64, np.int64)
    in_blocks(mark, 64, seen, who, least=1)
    answer.put(bool((seen == 1).all()))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no fork")
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded")
def test_a_forked_child_has_workers_of_its_own():
    in_blocks(mark, 64, np.zeros(64, int), np.zeros(64, np.int64), least=1)
    fork = multiprocessing.get_context("fork")
    answer = fork.SimpleQueue()
    child = fork.Process(target=_in_a_child, args=(answer,))
    child.start()
    child.join(timeout=30)
    assert child.exitcode == 0
    assert answer.get()


def test_a_worker_asked_at_the_moment_it_falls_asleep_wakes_up():
    worker, calls = Worker("sleepy"), []
    for pause in np.linspace(0.0, 0.004, 200):  # around the time it stays awake
        time.sleep(pause)
        worker.ask(calls.append, pause)
        worker.wait()
    assert len(calls) == 200


def test_an_outcome_that_was_not_waited_for_is_not_taken_for_the_next_one():
    worker, done = Worker("interrupted"), []
    worker.ask(time.sleep, 0.0)  # and whoever waits for it is interrupted
    while worker._outcomes.empty():
        time.sleep(0.001)

    def slow():
        time.sleep(0.05)
        done.append(1)

    worker.ask(slow)
    assert worker.wait() is None
    assert done == [1]
