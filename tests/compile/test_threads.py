"""Blocks of passes on several threads: each item once, errors raised, workers awake or asleep."""

import multiprocessing
import sys
import threading
import time

import numpy as np
import pytest

from apmethod import set_threads
from apmethod.compile import in_blocks, threads
from apmethod.compile.worker import Job, Worker


@pytest.fixture(autouse=True, params=[1, 2, 3, 8])
def number_of_threads(request):
    before = threads()
    set_threads(request.param)
    yield request.param
    set_threads(before)


def mark(first, last, seen):
    seen[first:last] += 1


@pytest.mark.parametrize("count", [0, 1, 2, 3, 100, 1001])
def test_every_item_comes_once_and_blocks_follow_each_other(count, number_of_threads):
    blocks = []

    def note(first, last):
        blocks.append((first, last))

    in_blocks(note, count, least=10)
    ends = [0, *(last for _, last in sorted(blocks))]
    assert [first for first, _ in sorted(blocks)] == ends[:-1]
    assert ends[-1] == count
    assert len(blocks) == max(1, min(number_of_threads, count // 10))


def test_several_threads_share_the_blocks(number_of_threads):
    begun, helped = threading.Barrier(number_of_threads), []

    def meet(first, last):
        begun.wait(timeout=60)  # for all others, each in a block of its own
        helped.append(threading.get_ident())

    in_blocks(meet, number_of_threads, least=1)
    assert len(set(helped)) == number_of_threads


def test_nobody_waits_for_a_worker_that_does_not_come():
    worker, called, calls = Worker("busy"), threading.Event(), []
    worker.ask(Job(lambda first, last: called.wait(), [(0, 1)], ()))
    while not worker._begun:
        time.sleep(0.001)
    job = Job(lambda first, last: calls.append(first), [(0, 1), (1, 2)], ())
    worker.ask(job)
    job.take_part()
    assert worker.wait() is None  # it would take for ever
    assert calls == [0, 1]
    worker._asleep = True  # as one that does not come is for long
    for _ in range(5):
        worker.ask(job)
    assert worker._wake.qsize() == 1
    worker._asleep = False
    called.set()
    assert helps(worker)


def test_blocks_again_and_again_after_pauses_of_any_length():
    seen = np.zeros(64, int)
    for number, pause in enumerate((0.0, 0.0, 0.001, 0.003, 0.05, 0.0, 0.002), start=1):
        time.sleep(pause)  # workers fall asleep within some milliseconds
        in_blocks(mark, 64, seen, least=1)
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
            seen = np.zeros(64, int)
            in_blocks(mark, 64, seen, least=1)
            if not (seen == 1).all():
                failures.append(seen)

    callers = [threading.Thread(target=passes) for _ in range(4)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert not failures


def _in_a_child(answer):
    seen = np.zeros(64, int)
    in_blocks(mark, 64, seen, least=1)
    answer.put(bool((seen == 1).all()))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no fork")
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded")
def test_a_forked_child_has_workers_of_its_own():
    in_blocks(mark, 64, np.zeros(64, int), least=1)
    fork = multiprocessing.get_context("fork")
    answer = fork.SimpleQueue()
    child = fork.Process(target=_in_a_child, args=(answer,))
    child.start()
    child.join(timeout=30)
    assert child.exitcode == 0
    assert answer.get()


def helps(worker):
    """Whether a worker does all of a job that nobody else takes part in."""
    done = threading.Event()
    worker.ask(Job(lambda first, last: done.set(), [(0, 1)], ()))
    return done.wait(timeout=60) and worker.wait() is None


def test_a_worker_asked_at_the_moment_it_falls_asleep_wakes_up():
    worker = Worker("sleepy")
    for pause in np.linspace(0.0, 0.004, 200):  # around the time it stays awake
        time.sleep(pause)
        assert helps(worker)


def test_an_outcome_that_was_not_waited_for_is_not_taken_for_the_next_one():
    worker, done, begun = Worker("interrupted"), [], threading.Event()
    worker.ask(Job(lambda first, last: None, [(0, 1)], ()))  # and whoever waits is interrupted
    while worker._outcomes.empty():
        time.sleep(0.001)

    def slow(first, last):
        begun.set()
        time.sleep(0.05)
        done.append(1)

    worker.ask(Job(slow, [(0, 1)], ()))
    assert begun.wait(timeout=60)
    assert worker.wait() is None
    assert done == [1]


def test_what_a_failed_pass_has_left_is_not_begun():
    ran = []
    job = Job(lambda first, last: ran.append(1 / first), [(0, 1), (1, 2)], ())
    with pytest.raises(ZeroDivisionError):
        job.take_part()
    job.end()
    job.take_part()
    assert ran == []
