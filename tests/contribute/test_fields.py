"""Fields laid on agents and read out of them."""

import numpy as np
import pytest

from apmethod import KERNELS, Periodic, reconstruct, sample


def hump(x, y):
    return np.exp(-20.0 * (x**2 + y**2))


@pytest.mark.parametrize("count", [1, 7, 500, 3001])
def test_as_many_agents_as_asked_for(count):
    positions, masses, spacing = sample(hump, count, (-1, -1), (1, 1))
    assert positions.shape == (count, 2)
    assert masses == pytest.approx(hump(*positions.T) * spacing**2)


def test_the_mass_is_the_integral():
    _, masses, _ = sample(hump, 2000, (-1, -1), (1, 1), offset=(0.3, 0.8))
    assert masses.sum() == pytest.approx(np.pi / 20.0, rel=2e-5)


def test_what_is_read_out_is_what_was_laid_down():
    points = np.random.default_rng(1).uniform(-0.6, 0.6, (500, 2))
    errors = []
    for count in (2000, 8000):
        positions, masses, spacing = sample(hump, count, (-1, -1), (1, 1))
        found = reconstruct(points, positions, masses, 2.0 * spacing)
        errors.append(np.abs(found - hump(*points.T)).max())
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] > 2.0**5  # half the spacing; the kernel's order is 6


@pytest.mark.parametrize("name", ["cubic", "gaussian", "gaussian_6"])
def test_reading_out_equals_the_plain_sum(name):
    draw = np.random.default_rng(2)
    kernel = KERNELS[name]
    positions, masses = draw.random((150, 2)), draw.random(150)
    points = draw.uniform(-0.5, 1.5, (80, 2))
    apart = np.hypot(*(points[:, None] - positions[None]).transpose(2, 0, 1))
    expected = kernel.w(apart, 0.07) @ masses
    assert reconstruct(points, positions, masses, 0.07, kernel) == pytest.approx(
        expected, rel=1e-12, abs=1e-12
    )


def test_reading_out_sees_across_a_periodic_side():
    domain = Periodic((0.0, 0.0), (1.0, 1.0))
    found = reconstruct(
        np.array([[0.99, 0.5]]), np.array([[0.01, 0.5]]), np.ones(1), 0.05, domain=domain
    )
    assert found[0] == pytest.approx(KERNELS["gaussian_6"].w(0.02, 0.05))


def test_no_agents_are_no_field():
    assert reconstruct(np.zeros((3, 2)), np.empty((0, 2)), np.empty(0), 1.0).tolist() == [0.0] * 3


@pytest.mark.parametrize(
    ("field", "count", "message"),
    [
        (hump, 0, "count is 0; it must be a whole number, 1 or more"),
        (lambda x, y: 0.0 * x, 10, "above 0 somewhere"),
        (lambda x, y: x, 10, "0 or more everywhere"),
    ],
)
def test_what_cannot_be_laid_down_is_refused(field, count, message):
    with pytest.raises(ValueError, match=message):
        sample(field, count, (-1, -1), (1, 1))


def test_bad_points_and_lengths_are_refused():
    with pytest.raises(ValueError, match=r"points has shape \(2,\); it must be \(n, 2\)"):
        reconstruct(np.zeros(2), np.zeros((1, 2)), np.ones(1), 1.0)
    with pytest.raises(ValueError, match=r"smoothing_length is 0\.0"):
        reconstruct(np.zeros((1, 2)), np.zeros((1, 2)), np.ones(1), 0.0)
