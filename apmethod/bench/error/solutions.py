"""Problems by their exact solutions: Gaussians, a disc, Gaussians between walls, a wave."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from apmethod.bench.error.problem import Problem
from apmethod.perceive.domain import Domain, Mirrored


class Mixture(Problem):
    """Gaussians, which stay Gaussians in every flow that is affine in x and y.

    With V = b(t) + L(t) x a Gaussian's mean m and covariance S follow

        dm/dt = V(m, t),    dS/dt = L S + S L^T + 2 D I,

    and its mass grows by exp(growth t) and by nothing else.

    Args:
        humps: for each its height, variance (or variances along x and y, and the
            covariance) and centre x, y.
    """

    def __init__(self, name: str, humps: Sequence[Sequence], box: Sequence[float], **options: Any):
        super().__init__(name, box, **options)
        spreads = [np.broadcast_to(hump[1], 2 if np.ndim(hump[1]) == 0 else 3) for hump in humps]
        self.means = np.array([hump[-2:] for hump in humps], float)
        self.covariances = np.array(
            [[[s[0], s[2] if len(s) > 2 else 0.0], [s[2] if len(s) > 2 else 0.0, s[1]]]
             for s in spreads]
        )  # fmt: skip
        heights = np.array([hump[0] for hump in humps])
        self.masses = heights * 2.0 * np.pi * np.sqrt(np.linalg.det(self.covariances))
        self._moments = lru_cache(maxsize=8)(self._integrated)

    def exact(self, x, y, time):
        """The sum of the Gaussians."""
        total = np.zeros(np.shape(x))
        means, covariances = self._moments(float(time))
        for mass, mean, covariance in zip(self.masses, means, covariances, strict=True):
            a, b, d = np.linalg.inv(covariance)[[0, 0, 1], [0, 1, 1]]
            u, v = x - mean[0], y - mean[1]
            peak = mass / (2.0 * np.pi * np.sqrt(np.linalg.det(covariance)))
            total += peak * np.exp(-0.5 * (a * u * u + 2.0 * b * u * v + d * v * v))
        return total * np.exp(self.growth * time)

    def freefem_start(self):
        """A sum of exponentials."""
        terms = []
        for mass, mean, covariance in zip(self.masses, self.means, self.covariances, strict=True):
            a, b, d = (float(v) for v in np.linalg.inv(covariance)[[0, 0, 1], [0, 1, 1]])
            peak = mass / (2.0 * np.pi * np.sqrt(np.linalg.det(covariance)))
            u, v = f"(x-({mean[0]}))", f"(y-({mean[1]}))"
            terms.append(f"{peak}*exp(-0.5*({a}*{u}^2+2*({b})*{u}*{v}+{d}*{v}^2))")
        return " + ".join(terms)

    def _integrated(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Means and covariances at a time."""
        if self.flow is None or time == 0.0:
            return self.means, self.covariances + 2.0 * self.diffusivity * time * np.eye(2)
        from scipy.integrate import solve_ivp

        count = len(self.masses)

        def rates(t: float, state: np.ndarray) -> np.ndarray:
            shift = np.array(self.flow(0.0, 0.0, t), float)
            columns = [np.array(self.flow(*unit, t)) - shift for unit in ((1.0, 0.0), (0.0, 1.0))]
            gradient = np.column_stack(columns)
            means, spread = state[: 2 * count].reshape(-1, 2), state[2 * count :].reshape(-1, 2, 2)
            stretch = gradient @ spread
            stretch = stretch + stretch.transpose(0, 2, 1) + 2.0 * self.diffusivity * np.eye(2)
            return np.concatenate([(means @ gradient.T + shift).ravel(), stretch.ravel()])

        begin = np.concatenate([self.means.ravel(), self.covariances.ravel()])
        size = max(map(abs, self.box))  # the state is lengths and their squares, in any unit
        least = 1e-15 * np.repeat([size, size**2], [2 * count, 4 * count])
        end = solve_ivp(rates, (0.0, time), begin, "DOP853", rtol=1e-12, atol=least).y[:, -1]
        return end[: 2 * count].reshape(-1, 2), end[2 * count :].reshape(-1, 2, 2)


class Disc(Problem):
    """u = 1 in a disc and 0 outside, turned about the origin by V = (y, -x), or at rest.

    Diffusion takes each point by a Gaussian step of variance 2 D t along x and y, so u is
    the chance that such a step from (x, y) ends in the disc: a non-central chi-square.
    """

    def __init__(self, name: str, radius: float, centre: Sequence[float], box, **options: Any):
        super().__init__(name, box, **options)
        self.radius, self.centre = radius, centre

    def exact(self, x, y, time):
        """The chance of ending in the disc."""
        c, s = (np.cos(time), np.sin(time)) if self.flow else (1.0, 0.0)
        x_c, y_c = c * self.centre[0] + s * self.centre[1], c * self.centre[1] - s * self.centre[0]
        square = (x - x_c) ** 2 + (y - y_c) ** 2
        if time == 0.0:
            return np.where(square < self.radius**2, 1.0, 0.0)
        from scipy.stats import ncx2

        variance = 2.0 * self.diffusivity * time
        return ncx2.cdf(self.radius**2 / variance, 2, square / variance)

    def freefem_start(self):
        """1 or 0."""
        x_c, y_c = self.centre
        return f"((x-({x_c}))^2+(y-({y_c}))^2 < {self.radius}^2 ? 1. : 0.)"


class WalledMixture(Problem):
    """Gaussians at rest between no-flux walls: the sum of them and all their mirror images.

    Args:
        humps: height, variance and centre x, y of each.
        axes: along which axes there are walls, of "xy".
    """

    def __init__(self, name: str, humps: Sequence, box, axes: str, **options: Any):
        borders = tuple("mirrored" if axis in axes else "open" for axis in "xy")
        walls = Domain((box[0], box[2]), (box[1], box[3]), borders)
        super().__init__(name, box, walls=walls, **options)
        self.humps, self.axes = humps, axes

    def exact(self, x, y, time):
        """A product of one series of images along each axis."""
        total = np.zeros(np.shape(x))
        for height, variance, *centre in self.humps:
            wider = variance + 2.0 * self.diffusivity * time
            along = [
                self._images(points, centre[axis], wider, axis) for axis, points in ((0, x), (1, y))
            ]
            total += height * variance / wider * along[0] * along[1]
        return total

    def freefem_start(self):
        """The product of the series of images, as far as they reach."""
        terms = []
        for height, variance, *centre in self.humps:
            factors = [
                "(" + "+".join(
                    f"exp(-0.5*({'xy'[axis]}-({place}))^2/{variance})"
                    for place in self._places(centre[axis], variance, axis)
                ) + ")"
                for axis in range(2)
            ]  # fmt: skip
            terms.append("*".join([str(height), *factors]))
        return " + ".join(terms)

    def _images(self, points: np.ndarray, centre: float, variance: float, axis: int) -> np.ndarray:
        places = self._places(centre, variance, axis)
        return sum(np.exp(-0.5 * (points - place) ** 2 / variance) for place in places)

    def _places(self, centre: float, variance: float, axis: int) -> list[float]:
        """Where the hump and its mirror images stand that reach into the box."""
        if "xy"[axis] not in self.axes:
            return [centre]
        low, high = self.box[2 * axis : 2 * axis + 2]
        reach = int(np.ceil(8.0 * np.sqrt(variance) / (high - low))) + 1
        periods = 2.0 * (high - low) * np.arange(-reach, reach + 1)
        return [*(centre + periods).tolist(), *(2.0 * low - centre + periods).tolist()]


class Relaxation(Problem):
    """The slowest wave of a no-flux box dies away: u = 1 + a cos(k x) cos(k y) exp(-2 D k^2 t).

    In the unit square k = pi.  Most of the run is close to the steady state, where an implicit
    method takes steps as long as it likes and moving agents still step by h^2/D.
    """

    def __init__(self, name: str, amplitude: float, **options: Any):
        super().__init__(name, (0.0, 1.0, 0.0, 1.0), walls=Mirrored((0, 0), (1, 1)), **options)
        self.amplitude = amplitude

    def exact(self, x, y, time):
        """One wave."""
        decay = np.exp(-2.0 * self.diffusivity * np.pi**2 * time)
        return 1.0 + self.amplitude * decay * np.cos(np.pi * x) * np.cos(np.pi * y)

    def freefem_start(self):
        """One wave."""
        return f"1. + {self.amplitude}*cos(pi*x)*cos(pi*y)"
