"""Machine code is found again by its content, and never when the content has changed."""

import os
import subprocess
import sys

import numpy as np
import pytest

from apmethod.compile import compiled, inlined
from apmethod.compile.cache import NotCacheable, cache_folder, fingerprint

FACTOR = 2.0


def make(constant, callee=None):
    inner = callee or (lambda x: x)

    def function(x):
        return inner(x) * constant * FACTOR

    return function


def test_the_same_content_has_the_same_fingerprint():
    assert fingerprint(make(3.0)) == fingerprint(make(3.0))


def test_every_part_of_the_content_counts(monkeypatch):
    found = {
        fingerprint(make(3.0)),
        fingerprint(make(4.0)),
        fingerprint(make(3.0, lambda x: x + 1.0)),
        fingerprint(make(3.0, lambda x: x + 2.0)),
        fingerprint(make(np.arange(3.0))),
    }
    monkeypatch.setitem(make.__globals__, "FACTOR", 5.0)
    found.add(fingerprint(make(3.0)))
    assert len(found) == 6


def test_a_callee_of_a_callee_counts():
    def chain(last):
        def middle(x):
            return last(x)

        return fingerprint(make(1.0, middle))

    assert chain(lambda x: x) != chain(lambda x: -x)


def test_an_attribute_is_not_taken_for_a_global():
    def reads_attribute(agent):
        return agent.FACTOR

    def reads_global(agent):
        return FACTOR

    before = fingerprint(reads_attribute), fingerprint(reads_global)
    reads_attribute.__globals__["FACTOR"] = 7.0
    try:
        assert fingerprint(reads_attribute) == before[0]
        assert fingerprint(reads_global) != before[1]
    finally:
        reads_attribute.__globals__["FACTOR"] = 2.0


def test_what_cannot_be_described_is_not_cached_but_runs(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    thing = object()

    def function(x):
        return x if thing is None else x + 1.0

    with pytest.raises(NotCacheable):
        fingerprint(function)


SCRIPT = """
from apmethod.compile import compiled, inlined
@inlined
def inner(x):
    return x * {factor}
@compiled
def outer(x):
    return inner(x) + 1.0
print(outer(3.0))
"""


def run(folder, factor):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder)}
    script = SCRIPT.format(factor=factor)
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment
    )
    return float(done.stdout)


def test_a_second_process_finds_the_code_and_an_edit_makes_new_code(tmp_path):
    assert run(tmp_path, 2.0) == 7.0
    first = set(tmp_path.iterdir())
    assert len(first) == 1
    assert run(tmp_path, 2.0) == 7.0
    assert set(tmp_path.iterdir()) == first
    assert run(tmp_path, 5.0) == 16.0
    assert len(set(tmp_path.iterdir())) == 2


def test_a_damaged_file_is_compiled_anew(tmp_path):
    run(tmp_path, 2.0)
    (file,) = tmp_path.iterdir()
    file.write_bytes(b"nothing")
    assert run(tmp_path, 2.0) == 7.0


def test_a_folder_that_cannot_be_written_costs_nothing_but_time(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    assert run(blocked, 2.0) == 7.0


def test_an_inlined_function_stays_python():
    def double(x):
        return [x, x]  # numba would not return this list as it is

    assert inlined(double)("a") == ["a", "a"]
    assert cache_folder().name


def test_nan_and_infinity_come_through():
    @compiled
    def total(values):
        result = 0.0
        for value in values:
            result += value
        return result

    assert np.isnan(total(np.array([1.0, np.nan])))
    assert total(np.array([1.0, np.inf])) == np.inf
