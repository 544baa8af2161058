"""Parts of a scattered round: they cover all sub-domains, and their tables what these reach."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import Mirrored, Open, Periodic
from apmethod.compile import LANES, compiled
from apmethod.message import parts
from samples import Curious, build

UNIT = (0.0, 0.0), (1.0, 1.0)
DOMAINS = {"open": Open(), "periodic": Periodic(*UNIT), "mirrored": Mirrored(*UNIT)}


@pytest.mark.parametrize("least", [1, 1000, 10_000])
@pytest.mark.parametrize("domain", list(DOMAINS))
def test_parts_cover_all_sub_domains_and_reach_as_far_as_their_runs(domain, least):
    cells = build(300, agent_class=Curious, domain=DOMAINS[domain], level=1).space.cells
    runs = cells.runs, cells.image
    cell, begin, end, base = parts._divide(*runs, least, 8, np.inf)
    assert [cell[0], cell[-1]] == [0, len(cells.number)]
    assert (np.diff(cell) > 0).all()
    assert (5 if least == 1 else 1) <= len(begin) <= 8
    for part, (first, last) in enumerate(pairwise(cell)):
        assert begin[part] == cells.start[first]
        runs_of_part = slice(cells.first[first], cells.first[last])
        assert end[part] >= max(cells.high[runs_of_part].max(), cells.start[last])
    assert np.array_equal(np.diff(base), end - begin + LANES)  # whole vectors end behind them
    for copies in (1.0, 2.5):
        less = parts._divide(*runs, least, 8, copies)[-1]
        assert less[-1] <= copies * len(cells.row) or len(less) <= 3
        assert len(less) <= len(base)


@compiled
def taken(order, shares, count):
    """The parts that threads take, one after the other in an order of their shares."""
    claimed = np.zeros(parts.APART * shares, np.int64)
    found = np.empty(len(order), np.int64)
    for k in range(len(order)):
        found[k] = parts.next_part(claimed, order[k], shares, count)
    return found


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 5), st.integers(1, 32), st.integers(0, 2**32))
def test_each_part_is_taken_once_and_ones_own_first(shares, count, seed):
    order = np.random.default_rng(seed).integers(0, shares, 40)
    found = taken(order, shares, count)
    assert sorted(found[:count]) == list(range(count))
    assert (found[count:] == count).all()
    own = [count * share // shares for share in range(shares + 1)]
    for share in range(shares):
        mine = found[order == share]
        if len(mine) and own[share] < own[share + 1] and order[0] == share:
            assert mine[0] == own[share]
