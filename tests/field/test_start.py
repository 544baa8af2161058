"""Starts: lattices between walls, jumps found and smoothed, the clock put forward."""

import numpy as np
import pytest

from apmethod import Mirrored, Open, Periodic
from apmethod.bench.error.problems import PROBLEMS
from apmethod.contribute.sample import sample
from apmethod.field.start import convolved, has_jump

BOX = (-1.0, 1.0, -1.0, 1.0)


def disc(x, y):
    return np.where((x - 0.013) ** 2 + y**2 < 0.16, 2.0, 0.0)


@pytest.mark.parametrize(
    ("field", "jumps"),
    [
        (disc, True),
        (lambda x, y: np.where(x > 0.2, 1.0, 0.5), True),
        (lambda x, y: np.exp(-400.0 * (x**2 + y**2)), False),
        (lambda x, y: 1.0 / (1.0 + np.exp(-150.0 * x)), False),
        (lambda x, y: np.maximum(1.0 - np.hypot(x, y), 0.0), False),
        (lambda x, y: 0.0 * x + 1.0, False),
    ],
)
def test_jumps_are_told_from_steep_places(field, jumps):
    assert has_jump(field, BOX) == jumps


def test_a_jump_is_smoothed_as_diffusion_would():
    """The exact disc after t = s^2 / (2 D)."""
    problem = PROBLEMS["disc"]
    deviation = 0.04
    smoothed = convolved(lambda x, y: problem.exact(x, y, 0.0), problem.box, deviation, Open())
    x, y = np.random.default_rng(1).uniform(-0.2, 0.8, (2, 500))
    still = type(problem)("still", problem.radius, problem.centre, problem.box,
                          diffusivity=1.0, until=1.0)  # fmt: skip
    assert smoothed(x, y) == pytest.approx(still.exact(x, y, 0.5 * deviation**2), abs=3e-5)


def test_the_clock_of_a_smoothed_start_begins_later():
    model = PROBLEMS["disc"].model(600, rng=1)
    assert 0.0 < model.elapsed <= 0.5 * model.until
    assert model.errors()["l2_error"] < 5e-3
    assert PROBLEMS["hill-1e-3"].model(600, rng=1).elapsed == 0.0
    assert PROBLEMS["disc"].model(600, rng=1, smooth=0.0).elapsed == 0.0


@pytest.mark.parametrize("domain", [Mirrored((0, 0), (2, 1)), Periodic((0, 0), (2, 1))])
@pytest.mark.parametrize("count", [150, 1000])
def test_a_lattice_goes_on_behind_closed_sides(domain, count):
    positions, masses, spacing = sample(
        lambda x, y: 0.0 * x + 3.0, count, (-9, -9), (9, 9), offset=(0.3, 0.7), domain=domain
    )
    assert len(positions) == pytest.approx(count, rel=0.05)
    assert masses.sum() == pytest.approx(6.0)
    for axis, length in enumerate((2.0, 1.0)):
        along = np.unique(np.round(positions[:, axis], 9))
        across = length - along[-1] + along[0]  # over the seam, or to the mirror images
        assert np.diff(along) == pytest.approx(across, rel=1e-6)
        assert across == pytest.approx(spacing, rel=0.1)
        if domain.borders[axis] == "mirrored":
            assert along[0] == pytest.approx(0.5 * across)
