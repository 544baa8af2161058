"""Smoothing kernels in the plane (paper 2.1, Figure 1).

A kernel is W(r, h) = shape(q^2) / h^2 with q = r/h, h the *smoothing length*.  It is zero
from q = support on, so the *core radius* is support * h.  Shapes are functions of q^2, and
their slope is the derivative divided by q, so that

    grad_i W_ij = slope(q^2) / h^4 * (x_i - x_j)

needs no division by a distance that may be zero.  Shapes are normalised to integrate to 1.

Kernels marked fourth order have no second moment, so that smoothing by them changes a
field by O(h^4) instead of O(h^2); such kernels are negative somewhere.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import exp, factorial, pi, sqrt

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from apmethod.compile import inlined


@dataclass(frozen=True)
class Kernel:
    """A smoothing kernel.

    Attributes:
        name: what a scene calls it.
        support: core radius over smoothing length.
        shape: W h^2 as a function of q^2, below the support.
        slope: the derivative of ``shape`` by q, divided by q, as a function of q^2.
        order: 2 for a positive kernel, 4 for one without second moment.
    """

    name: str
    support: float
    shape: Callable[[float], float]
    slope: Callable[[float], float]
    order: int = 2

    def w(self, distance, smoothing_length: float) -> np.ndarray:
        """W(r, h), per area, at distances of any shape."""
        q_2 = (np.asarray(distance, float) / smoothing_length) ** 2
        values = np.vectorize(self.shape, otypes=[float])(q_2)
        return np.where(q_2 < self.support**2, values, 0.0) / smoothing_length**2

    def dw(self, distance, smoothing_length: float) -> np.ndarray:
        """dW/dr, per volume, at distances of any shape."""
        q_2 = (np.asarray(distance, float) / smoothing_length) ** 2
        values = np.vectorize(self.slope, otypes=[float])(q_2) * np.sqrt(q_2)
        return np.where(q_2 < self.support**2, values, 0.0) / smoothing_length**3

    @cached_property
    def transform(self) -> tuple[np.ndarray, np.ndarray]:
        """Wave numbers k h and the kernel's Fourier transform there (1 at k = 0)."""
        from scipy.integrate import simpson  # here, because only a chosen time step needs them
        from scipy.special import j0

        q = np.linspace(0.0, self.support, 801)
        profile = 2.0 * pi * q * np.vectorize(self.shape, otypes=[float])(q**2)
        k = np.linspace(0.0, 12.0, 481)
        return k, simpson(j0(np.outer(k, q)) * profile, x=q)


def _spline(name: str, support: float, shape: Callable, slope: Callable) -> Kernel:
    return Kernel(name, support, inlined(shape), inlined(slope))


# -- splines and Wendland functions: (s - q)_+ is max(s - q, 0), without a branch ----------

_SMALL = 1e-150  # keeps 0/0 out of slope at q = 0, where the numerator vanishes


def _cubic(q_2):
    q = sqrt(q_2)
    two, one = max(2.0 - q, 0.0), max(1.0 - q, 0.0)
    return 10.0 / (7.0 * pi) * (0.25 * two**3 - one**3)


def _cubic_slope(q_2):
    q = sqrt(q_2)
    two, one = max(2.0 - q, 0.0), max(1.0 - q, 0.0)
    return 10.0 / (7.0 * pi) * (3.0 * one**2 - 0.75 * two**2) / max(q, _SMALL)


def _quintic(q_2):
    q = sqrt(q_2)
    three, two, one = max(3.0 - q, 0.0), max(2.0 - q, 0.0), max(1.0 - q, 0.0)
    return 7.0 / (478.0 * pi) * (three**5 - 6.0 * two**5 + 15.0 * one**5)


def _quintic_slope(q_2):
    q = sqrt(q_2)
    three, two, one = max(3.0 - q, 0.0), max(2.0 - q, 0.0), max(1.0 - q, 0.0)
    steep = -5.0 * three**4 + 30.0 * two**4 - 75.0 * one**4
    return 7.0 / (478.0 * pi) * steep / max(q, _SMALL)


def _wendland_c2(q_2):
    q = sqrt(q_2)
    inside = max(1.0 - 0.5 * q, 0.0)
    return 7.0 / (4.0 * pi) * inside**4 * (1.0 + 2.0 * q)


def _wendland_c2_slope(q_2):
    inside = max(1.0 - 0.5 * sqrt(q_2), 0.0)
    return -35.0 / (4.0 * pi) * inside**3


def _wendland_c4(q_2):
    q = sqrt(q_2)
    inside = max(1.0 - 0.5 * q, 0.0)
    return 9.0 / (4.0 * pi) * inside**6 * (1.0 + 3.0 * q + 35.0 / 12.0 * q_2)


def _wendland_c4_slope(q_2):
    q = sqrt(q_2)
    inside = max(1.0 - 0.5 * q, 0.0)
    return -9.0 / (4.0 * pi) * inside**5 * (14.0 / 3.0 + 35.0 / 3.0 * q)


# -- Gaussians, cut at q = k with value and slope going to zero there ---------------------


_BELL_END = 20.0  # beyond it nothing here asks for exp(-q^2)
_BELL_HALF = _BELL_END / 64.0
#: Of exp(t - _BELL_HALF) for |t| up to _BELL_HALF: its Taylor series to the 12th power, of which
#: Chebyshev's polynomials spare the last two.
_BELL_SERIES = Polynomial([exp(-_BELL_HALF) * _BELL_HALF**n / factorial(n) for n in range(13)])
_BELL_SHORT = _BELL_SERIES.convert(kind=Chebyshev).truncate(11).convert(kind=Polynomial)
_BELL = tuple((_BELL_SHORT.coef / _BELL_HALF ** np.arange(11)).tolist())


@inlined
def bell(q_2):
    """exp(-q^2) for q^2 from 0 to 20, to 1e-14, by multiplications that vectorise.

    exp(-s) = exp(-s/32)^32, with a polynomial for exp(-s/32) whose parts do not wait for each
    other.
    """
    t = _BELL_HALF - min(q_2, _BELL_END) / 32.0
    t2 = t * t
    t4 = t2 * t2
    low = (_BELL[0] + t * _BELL[1]) + t2 * (_BELL[2] + t * _BELL[3])
    middle = (_BELL[4] + t * _BELL[5]) + t2 * (_BELL[6] + t * _BELL[7])
    high = (_BELL[8] + t * _BELL[9]) + t2 * _BELL[10]
    e = low + t4 * (middle + t4 * high)
    e2 = e * e
    e4 = e2 * e2
    e8 = e4 * e4
    e16 = e8 * e8
    return e16 * e16


def _cut_gaussian(name: str, cut: float, order: int) -> Kernel:
    """p(q^2) g(q), g = exp(-q^2) - exp(-cut^2) (1 + cut^2 - q^2), of order 2, 4 or 6.

    The polynomial p has as many coefficients as it takes to make the integral 1 and the
    moments of q^2 up to q^(order - 2) zero.  Value and slope vanish at the cut: a kernel
    that jumps there, however little, changes the diffusivity by a share that no
    refinement removes.
    """
    end = float(np.exp(-(cut**2)))
    cut_2 = cut**2
    terms = order // 2
    moments = [_moment(cut, n) for n in range(2 * terms - 1)]
    hankel = [[moments[row + n] for n in range(terms)] for row in range(terms)]
    a, b, c = (*np.linalg.solve(hankel, np.eye(terms)[0]).tolist(), 0.0, 0.0)[:3]

    @inlined
    def shape(q_2):
        g = bell(q_2) - end * (1.0 + cut_2 - q_2)
        return (a + q_2 * (b + q_2 * c)) * g

    @inlined
    def slope(q_2):
        e = bell(q_2)
        g = e - end * (1.0 + cut_2 - q_2)
        return 2.0 * (b + 2.0 * c * q_2) * g - 2.0 * (a + q_2 * (b + q_2 * c)) * (e - end)

    return Kernel(name, cut, shape, slope, order)


def _moment(cut: float, n: int) -> float:
    """Integral over the plane of q^(2n) g(q), in closed form."""
    c, end = cut**2, exp(-(cut**2))
    # With s = q^2 the integral is pi times that of s^n (exp(-s) - end (1 + c - s)) to c.
    bell = factorial(n) * (1.0 - end * sum(c**k / factorial(k) for k in range(n + 1)))
    line = (1.0 + c) * c ** (n + 1) / (n + 1) - c ** (n + 2) / (n + 2)
    return pi * (bell - end * line)


#: Monaghan's cubic B-spline, the kernel of the paper's Figure 1.
CUBIC = _spline("cubic", 2.0, _cubic, _cubic_slope)
#: The quintic B-spline.
QUINTIC = _spline("quintic", 3.0, _quintic, _quintic_slope)
#: Wendland's C2 function.
WENDLAND_C2 = _spline("wendland_c2", 2.0, _wendland_c2, _wendland_c2_slope)
#: Wendland's C4 function.
WENDLAND_C4 = _spline("wendland_c4", 2.0, _wendland_c4, _wendland_c4_slope)
#: The Gaussian, cut smoothly at 3.4 h.
GAUSSIAN = _cut_gaussian("gaussian", 3.4, order=2)
#: (a + b q^2) times a Gaussian cut smoothly at 3.8 h: fourth order, negative in its tail.
GAUSSIAN_4 = _cut_gaussian("gaussian_4", 3.8, order=4)
#: (a + b q^2 + c q^4) times a Gaussian cut smoothly at 4.2 h: sixth order.
GAUSSIAN_6 = _cut_gaussian("gaussian_6", 4.2, order=6)
#: The same cut at 3.6 h: a quarter fewer neighbours, and errors that level off at some 5e-5.
GAUSSIAN_6_SHORT = _cut_gaussian("gaussian_6_short", 3.6, order=6)

KERNELS = {
    kernel.name: kernel
    for kernel in (
        CUBIC, QUINTIC, WENDLAND_C2, WENDLAND_C4, GAUSSIAN, GAUSSIAN_4, GAUSSIAN_6,
        GAUSSIAN_6_SHORT,
    )
}  # fmt: skip


def kernel_named(name: str | Kernel) -> Kernel:
    """The kernel of that name; a `Kernel` is handed through.

    Raises:
        ValueError: for a name that is not in ``KERNELS``.
    """
    if isinstance(name, Kernel):
        return name
    if name not in KERNELS:
        raise ValueError(f"kernel is {name!r}; it must be one of {', '.join(KERNELS)}")
    return KERNELS[name]
