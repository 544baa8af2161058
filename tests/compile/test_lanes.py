"""Whole vectors do what slices of arrays do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba.core.errors import TypingError

from apmethod.compile import LANES, add_lanes, compiled, copy_lanes, fill_lanes, keep

places = st.integers(0, LANES)


@compiled
def act(target, source, at, start, count, value, what):
    if what == 0:
        fill_lanes(target, at, value)
    elif what == 1:
        copy_lanes(target, at, source, start)
    else:
        add_lanes(target, at, source, start, count)


@compiled
def kept(condition, value):
    return keep(condition, value)


@settings(deadline=None)  # the first one compiles
@given(at=places, start=places, count=st.integers(-1, LANES + 1), what=st.integers(0, 2))
def test_they_touch_their_slice_and_nothing_else(at, start, count, what):
    target, source = np.arange(2.0 * LANES), 100.0 + np.arange(2.0 * LANES)
    expected = target.copy()
    mine, theirs = slice(at, at + LANES), source[start : start + LANES]
    if what == 0:
        expected[mine] = -7.0
    elif what == 1:
        expected[mine] = theirs
    else:
        expected[mine] += np.where(np.arange(LANES) < count, theirs, 0.0)
    act(target, source, at, start, count, -7.0, what)
    assert np.array_equal(target, expected)


def test_what_does_not_count_is_not_added_even_if_it_is_no_number():
    target, source = np.ones(LANES), np.full(LANES, np.nan)
    source[:2] = 1.0
    act(target, source, 0, 0, 2, 0.0, 2)
    assert np.array_equal(target, [2.0] * 2 + [1.0] * (LANES - 2))
    assert kept(True, np.inf) == np.inf
    assert kept(False, np.nan) == 0.0


@pytest.mark.parametrize("wrong", [np.zeros(32)[::2], np.zeros(16, int), np.zeros(16, "f4")])
def test_what_does_not_lie_side_by_side_is_refused(wrong):
    for target, source, what in ((wrong, np.zeros(16), 0), (np.zeros(16), wrong, 1)):
        with pytest.raises(TypingError, match="contiguous column of floats"):
            act(target, source, 0, 0, 1, 0.0, what)
