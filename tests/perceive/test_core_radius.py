"""The core radius that follows the density, and where it stops."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import FollowDensity, Periodic, QuadLattice
from apmethod.particles import Column, Particles


class Table(Particles):
    """Masses and densities, without agents."""

    def __init__(self, masses, densities):
        super().__init__()
        self.declare("position", Column(2))
        self._arrays |= {"mass": np.array(masses, float), "density": np.array(densities, float)}

    def array(self, name):
        return self._arrays[name]


def followed(*densities, masses=(1.0, 2.0), domain=None, radius=0.5):
    """The core radius after densities were received one after the other."""
    space = QuadLattice(Particles(), radius, domain)
    rule = FollowDensity()
    for received in densities:
        rule.adapt(space, Table(masses, received))
    return space.core_radius


@settings(max_examples=30, deadline=None)
@given(st.floats(1e-3, 1e3), st.floats(1e-5, 1e5), st.integers(1, 6))
def test_it_keeps_the_number_of_neighbours(thinner, unit, rounds):
    """R^2 times the mean density is what it was, whatever the way there."""
    first = np.array([3.0, 1.0]) * unit
    way = [first / thinner ** (k / rounds) for k in range(rounds + 1)]
    assert followed(*way) == pytest.approx(0.5 * np.sqrt(thinner), rel=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.floats(1e-300, 1e300))
def test_it_stays_between_its_limits(density):
    radius = followed([1.0, 1.0], [density, density], domain=Periodic((0, 0), (4, 3)))
    assert 0.5e-3 <= radius <= 1.5


@pytest.mark.parametrize("nothing", [[0.0, 0.0], [np.nan, 1.0], [np.inf, 1.0]])
def test_it_stays_what_it_is_while_there_is_no_density(nothing):
    assert followed(nothing) == 0.5
    assert followed([1.0, 1.0], [0.25, 0.25], nothing) == 1.0
    assert followed([1.0, 1.0], masses=(0.0, 0.0)) == 0.5
