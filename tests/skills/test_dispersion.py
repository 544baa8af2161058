"""Small waves of animals grow and decay as the dispersion relation says."""

import numpy as np
import pytest

from apmethod import Follow, SignalField, growth_rate
from apmethod.bench.aggregation import dispersion


def test_the_growth_rate_is_the_eigenvalue():
    signal = SignalField(1.0, production=0.3, diffusivity=0.2, evaporation=0.1)
    for k in (0.1, 0.5, 2.0):
        matrix = [[-0.05 * k**2, 0.7 * 1.3 * k**2], [0.3, -(0.2 * k**2 + 0.1)]]
        expected = np.linalg.eigvals(matrix).real.max()
        assert growth_rate(k, 1.3, 0.05, Follow(signal, 0.7)) == pytest.approx(expected)


def test_waves_grow_and_decay_at_the_rate_of_the_dispersion_relation():
    rows = dispersion.waves((2, 3, 6, 7))
    assert [row["agents"] for row in rows] == [10_000] * 4
    assert [row["expected"] > 0.0 for row in rows] == [True, True, False, False]
    for row in rows:
        assert row["measured"] == pytest.approx(row["expected"], rel=0.05)


def test_the_threshold_between_gathering_and_dispersal():
    found = dispersion.threshold(along=50)
    assert found["measured"] == pytest.approx(found["expected"], rel=0.05)
