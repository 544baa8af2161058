"""Sides and meetings are those of exact arithmetic, in both tiers."""

from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod.compile import plain
from apmethod.move.obstacles.predicates import MISS, meeting, orientation
from apmethod.move.obstacles.rays import BEFORE, STILL, Walls, brute_force_hits

#: Few values, so that points coincide and lie on one line, beside any at all.
coordinate = st.one_of(
    st.integers(-3, 3).map(float),
    st.integers(-3, 3).map(lambda k: 0.1 * k),
    st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-100),
)
point = st.tuples(coordinate, coordinate)


def exact_area(a, b, c):
    (ax, ay), (bx, by), (cx, cy) = (tuple(map(Fraction, p)) for p in (a, b, c))
    return (ax - cx) * (by - cy) - (ay - cy) * (bx - cx)


def sign(value):
    return (value > 0) - (value < 0)


@settings(max_examples=300, deadline=None)
@given(point, point, st.one_of(point, st.floats(-2.0, 3.0)))
def test_the_side_of_a_line_is_exact(a, b, c):
    if isinstance(c, float):  # as near to the line as rounding gets
        c = (a[0] + c * (b[0] - a[0]), a[1] + c * (b[1] - a[1]))
        c = tuple(0.0 if abs(x) < 1e-100 else x for x in c)
    assert sign(orientation(*a, *b, *c)) == sign(exact_area(a, b, c))


def exactly_meet(p, q, a, b):
    sides = [exact_area(*three) for three in ((a, b, p), (a, b, q), (p, q, a), (p, q, b))]
    if not any(sides):
        return all(
            max(min(p[k], q[k]), min(a[k], b[k])) <= min(max(p[k], q[k]), max(a[k], b[k]))
            for k in range(2)
        )
    return sides[0] * sides[1] <= 0 and sides[2] * sides[3] <= 0


@settings(max_examples=300, deadline=None)
@given(point, point, point, point)
def test_whether_segments_meet_is_exact_and_where_is_on_both(p, q, a, b):
    if a == b:
        return
    share = meeting(*p, *q, *a, *b)
    assert (share != MISS) == exactly_meet(p, q, a, b)
    if share != MISS:
        assert 0.0 <= share <= 1.0
        place = np.array(p) + share * (np.array(q) - p)
        along = np.array(b) - a
        nearest = a + np.clip((place - a) @ along / (along @ along), 0.0, 1.0) * along
        size = np.abs([*p, *q, *a, *b]).max()
        assert np.abs(place - nearest).max() <= 1e-12 * size


def test_both_tiers_give_the_same_bits():
    draw = np.random.default_rng(1)
    ends = np.concatenate(
        [draw.random((40, 4)), draw.integers((0, 0, 4, 3), (3, 3, 6, 5), (40, 4))]
    )
    number = np.arange(80, dtype=np.int32)
    still = np.full(80, STILL, np.int32)
    walls = Walls(np.stack([ends] * 3), still, number, np.zeros(80, np.int8))
    starts = np.concatenate([draw.random((50, 2)), draw.integers(0, 4, (50, 2)).astype(float)])
    stops = np.concatenate([draw.random((50, 2)), draw.integers(0, 4, (50, 2)).astype(float)])
    found = []
    for run in (brute_force_hits, plain(brute_force_hits)):
        shares, hits = np.empty(100), np.empty(100, np.int32)
        run(0, 100, walls, BEFORE, starts, stops, shares, hits)
        found.append((shares, hits))
    assert (found[0][0] == found[1][0]).all()
    assert (found[0][1] == found[1][1]).all()
    assert (found[0][1] >= 0).any()
