"""Kernels: normalised, smooth, zero at their support, and consistent with their slope."""

import numpy as np
import pytest
from scipy.integrate import quad

from apmethod import KERNELS, Kernel
from apmethod.contribute.smoothing import bell, kernel_named

kernels = pytest.mark.parametrize("kernel", list(KERNELS.values()), ids=list(KERNELS))


def moment(kernel: Kernel, power: int) -> float:
    def ring(q):
        return 2.0 * np.pi * q ** (power + 1) * kernel.shape(q * q)

    knots = [knot for knot in (1.0, 2.0, 3.0) if knot < kernel.support]
    return quad(ring, 0.0, kernel.support, points=knots, epsabs=1e-13)[0]


@kernels
def test_integral_is_one(kernel):
    assert moment(kernel, 0) == pytest.approx(1.0, abs=1e-12)


@kernels
def test_moments_below_the_order_vanish(kernel):
    for power in range(2, kernel.order, 2):
        assert moment(kernel, power) == pytest.approx(0.0, abs=1e-12)
    assert abs(moment(kernel, kernel.order)) > 0.3


@kernels
def test_slope_is_the_derivative(kernel):
    q = np.linspace(0.03, kernel.support - 0.03, 200)
    step = 1e-5
    difference = (kernel.w(q + step, 1.0) - kernel.w(q - step, 1.0)) / (2.0 * step)
    assert kernel.dw(q, 1.0) == pytest.approx(difference, abs=1e-8)


@kernels
def test_value_and_slope_vanish_at_the_support(kernel):
    edge = kernel.support * (1.0 - 1e-9)
    assert abs(kernel.w(edge, 1.0)) < 1e-8
    assert abs(kernel.dw(edge, 1.0)) < 1e-6
    assert kernel.w([kernel.support, 9.0], 1.0).tolist() == [0.0, 0.0]


@kernels
def test_units(kernel):
    assert kernel.w(0.6, 2.0) == pytest.approx(kernel.w(0.3, 1.0) / 4.0)
    assert kernel.dw(0.6, 2.0) == pytest.approx(kernel.dw(0.3, 1.0) / 8.0)


@kernels
def test_transform_begins_at_the_integral(kernel):
    k, transform = kernel.transform
    assert k[0] == 0.0
    assert transform[0] == pytest.approx(1.0, abs=1e-5)


def test_second_order_kernels_are_positive():
    for kernel in KERNELS.values():
        if kernel.order == 2:
            assert (kernel.w(np.linspace(0.0, kernel.support * 0.999, 500), 1.0) > 0.0).all()


def test_bell_is_the_exponential():
    q_2 = np.linspace(0.0, 20.0, 4001)
    found = np.array([bell(value) for value in q_2])
    assert np.abs(found / np.exp(-q_2) - 1.0).max() < 2e-14


def test_a_kernel_goes_by_its_name():
    assert kernel_named("cubic") is KERNELS["cubic"]
    with pytest.raises(ValueError, match="kernel is 'box'; it must be one of cubic, quintic"):
        kernel_named("box")
