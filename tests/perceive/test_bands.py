"""A slice of a band holds what the runs around a sub-domain hold, each entry itself included."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import Bounded, Open, Periodic
from apmethod.perceive.bands import places_of_own, slices_around
from apmethod.perceive.cells import sort_into_cells
from apmethod.perceive.images import MIRROR, REAL, WRAPPED
from apmethod.perceive.radii import sort_by_radius

UNIT = (0.0, 0.0), (1.0, 1.0)
DOMAINS = {"open": Open(), "bounded": Bounded(*UNIT), "periodic": Periodic(*UNIT)}


def check(cells, kind):
    chosen = cells.of_kind(kind)
    order, begin, end = slices_around(cells, chosen)
    assert len(begin) == len(end) == len(cells.number)
    for k in range(len(cells.number)):
        runs = range(cells.first[k], cells.first[k + 1])
        around = np.concatenate([np.arange(cells.low[run], cells.high[run]) for run in runs])
        found = chosen[order[begin[k] : end[k]]]
        assert sorted(found) == sorted(around[np.isin(around, chosen)])
    start = np.searchsorted(chosen, cells.start)
    own = places_of_own(order, begin, end, start)
    cell = np.repeat(np.arange(len(cells.number)), np.diff(start))
    assert np.array_equal(order[begin[cell] + own], np.arange(len(chosen)))


@settings(max_examples=60, deadline=None)
@given(
    domain=st.sampled_from(list(DOMAINS)),
    level=st.integers(0, 3),
    count=st.integers(0, 120),
    radius=st.sampled_from([0.03, 0.1, 0.25, 0.5]),
    own=st.booleans(),
    seed=st.integers(0, 2**32),
)
def test_slices_hold_what_the_runs_hold(domain, level, count, radius, own, seed):
    draw = np.random.default_rng(seed)
    positions = draw.random((count, 2)) ** draw.integers(1, 4)
    if own and count:
        radii = radius * draw.uniform(0.1, 1.0, count)
        cells = sort_by_radius(positions, radii, level, DOMAINS[domain])
    else:
        cells = sort_into_cells(positions, radius, level, DOMAINS[domain])
    for kind in (REAL, WRAPPED, MIRROR):
        check(cells, kind)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_slices_over_a_huge_plane(level):
    positions = np.random.default_rng(2).random((100, 2))
    positions[:4] = [[1e9, 1e9], [-1e9, 1e9], [1e9 + 0.01, 1e9], [0.0, -1e12]]
    check(sort_into_cells(positions, 0.1, level, Open()), REAL)
