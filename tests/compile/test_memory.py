"""Memory that is used again: never while an array in it is alive."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod.compile import memory

LARGE = 300_000  # bytes, above what is left to the system


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["make", "view", "drop"]), st.integers(0, 7), st.integers(1, 40_000)
        ),
        max_size=40,
    )
)
def test_no_array_is_written_to_by_another_one_while_it_lives(actions):
    alive = []
    for number, (action, which, more) in enumerate(actions):
        if action == "make":
            array = memory.empty((LARGE + more) // 8)
            array.fill(number)
            alive.append((array, number))
        elif alive and action == "view":
            array, value = alive.pop(which % len(alive))
            alive.append((array[more % len(array) :][::2].reshape(-1, 1).T, value))
        elif alive:
            alive.pop(which % len(alive))
        assert all((array == value).all() for array, value in alive)


def test_memory_is_used_again_once_all_arrays_in_it_are_gone():
    first = memory.empty((LARGE, 2))
    place, part = first.ctypes.data, first[5:, 1]
    del first
    second = memory.empty((LARGE, 2))
    assert second.ctypes.data != place
    assert not np.shares_memory(second, part)
    del part
    third = memory.empty((2, LARGE), np.int64)
    assert third.ctypes.data == place


def test_arrays_are_like_those_of_numpy():
    for shape in (3, (2, 5), LARGE, (2, LARGE), 0, (0, 2)):
        for dtype in (float, np.int64, np.int32):
            array, zeros = memory.empty(shape, dtype), memory.zeros(shape, dtype)
            assert array.shape == zeros.shape == np.empty(shape).shape
            assert array.dtype == zeros.dtype == dtype
            assert array.flags.c_contiguous
            assert not zeros.any()
            zeros.fill(1)
            del zeros
            assert not memory.zeros(shape, dtype).any()


def test_blocks_that_nobody_asks_for_are_given_back():
    memory.empty(50 * LARGE)
    assert any(block.size >= 8 * 50 * LARGE for block in memory._blocks)
    for _ in range(memory._IDLE + 1):
        memory.empty(LARGE)
    memory.empty(200 * LARGE)
    assert not any(8 * 50 * LARGE <= block.size < 8 * 200 * LARGE for block in memory._blocks)
