"""How a signal spreads and evaporates on its patches, within one step.

    ds/dt = q - beta s + Ds L s

with q the production on each patch, held for the step, and L the five-point Laplacian in
flux form: what one patch loses its neighbour gains, so without evaporation and production
the total is kept to round-off.
"""

from __future__ import annotations

import numpy as np

from apmethod.compile import compiled, in_blocks
from apmethod.skills.patches import Patches


class Euler:
    """Forward Euler, the paper's method, in as many equal sub-steps as keep it inside its limit.

    A sub-step is at most 1 / (4 Ds/dx^2 + beta).  That is half of what stability needs;
    within it a patch never gives more than it has, so that no signal becomes negative.
    """

    def __init__(self, patches: Patches, diffusivity: float, evaporation: float):
        self.patches = patches
        self.diffusivity, self.evaporation = diffusivity, evaporation
        self.substeps = True

    @property
    def largest_step(self) -> float:
        """Length of a sub-step at the most."""
        rate = 4.0 * self.diffusivity / self.patches.area + self.evaporation
        return 1.0 / rate if rate else np.inf

    def check(self, dt: float) -> None:
        """Refuse a step that needs sub-steps where they are off."""
        if not self.substeps and dt > self.largest_step * (1.0 + 1e-12):
            raise ValueError(
                f"dt is {dt:.6g} and sub-stepping is off; with diffusivity {self.diffusivity:g}, "
                f"evaporation {self.evaporation:g} and patches of {self.patches.side:g} forward "
                f"Euler allows {self.largest_step:.6g}: a smaller dt, substeps=True or another "
                "method would do"
            )

    def advance(self, signal: np.ndarray, source: np.ndarray, dt: float) -> np.ndarray:
        """The signal a time ``dt`` later; both arrays of the patches' shape."""
        self.check(dt)
        count = max(1, int(np.ceil(dt / self.largest_step * (1.0 - 1e-12))))
        patches, step = self.patches, dt / count
        exchanged = self.diffusivity * step / patches.area
        for _ in range(count):
            later = np.empty_like(signal)
            in_blocks(
                _euler, len(signal), signal, source, patches.east, patches.north, exchanged,
                self.evaporation * step, step, later, least=200,
            )  # fmt: skip
            signal = later
        return signal


@compiled
def _euler(first, last, signal, source, east, north, exchanged, lost, dt, later):
    wide, high = signal.shape
    for i in range(first, last):
        before, after = i - 1 if i else wide - 1, i + 1 if i + 1 < wide else 0
        for j in range(high):
            below, above = j - 1 if j else high - 1, j + 1 if j + 1 < high else 0
            s = signal[i, j]
            gained = east[i, j] * (signal[after, j] - s) + east[before, j] * (signal[before, j] - s)
            gained += north[i, j] * (signal[i, above] - s)
            gained += north[i, below] * (signal[i, below] - s)
            later[i, j] = s + exchanged * gained + (dt * source[i, j] - lost * s)


class Exact:
    """Exact in time: each wave of the patches' own Laplacian grows or decays by itself.

    Waves are cosines where borders are closed and Fourier's where they are periodic.

    Raises:
        ValueError: where there are obstacles, whose waves are not known.
    """

    def __init__(self, patches: Patches, diffusivity: float, evaporation: float):
        if not patches.free.all():
            raise ValueError("method is 'exact', which knows no obstacles; use 'implicit'")
        self.patches = patches
        along_x, along_y = (
            (2.0 / patches.side * np.sin(np.pi * np.arange(n) / (n if wraps else 2 * n))) ** 2
            for n, wraps in zip(patches.shape, patches.periodic, strict=True)
        )
        self._rate = evaporation + diffusivity * (along_x[:, None] + along_y)
        self._closed = [axis for axis in range(2) if not patches.periodic[axis]]
        self._wrapped = [axis for axis in range(2) if patches.periodic[axis]]

    def check(self, dt: float) -> None:
        """Every step is stable."""

    def advance(self, signal: np.ndarray, source: np.ndarray, dt: float) -> np.ndarray:
        """The signal a time ``dt`` later; both arrays of the patches' shape."""
        decayed = np.exp(-self._rate * dt)
        # (1 - exp(-r dt)) / r, and its limit dt where nothing decays.
        rate = np.where(self._rate > 0.0, self._rate, 1.0)
        gathered = np.where(self._rate > 0.0, -np.expm1(-self._rate * dt) / rate, dt)
        return self._values(decayed * self._waves(signal) + gathered * self._waves(source))

    def _waves(self, values: np.ndarray) -> np.ndarray:
        from scipy.fft import dctn, fftn

        return fftn(dctn(values, axes=self._closed, norm="ortho"), axes=self._wrapped)

    def _values(self, waves: np.ndarray) -> np.ndarray:
        from scipy.fft import idctn, ifftn

        values = np.ascontiguousarray(ifftn(waves, axes=self._wrapped).real)
        return idctn(values, axes=self._closed, norm="ortho")


class Implicit:
    """Backward Euler: one sparse solve, stable for every step and around obstacles.

    The matrix is factorised once for each length of step.
    """

    def __init__(self, patches: Patches, diffusivity: float, evaporation: float):
        self.patches = patches
        self.diffusivity, self.evaporation = diffusivity, evaporation
        self._step = np.nan

    def check(self, dt: float) -> None:
        """Every step is stable."""

    def advance(self, signal: np.ndarray, source: np.ndarray, dt: float) -> np.ndarray:
        """The signal a time ``dt`` later; both arrays of the patches' shape."""
        if dt != self._step:
            self._solve, self._step = self._factorised(dt), dt
        return self._solve((signal + dt * source).ravel()).reshape(signal.shape)

    def _factorised(self, dt: float):
        from scipy.sparse import coo_array, diags_array
        from scipy.sparse.linalg import splu

        patches = self.patches
        number = np.arange(patches.free.size).reshape(patches.shape)
        here, there, share = [], [], []
        for axis, opening in enumerate((patches.east, patches.north)):
            ends = number, np.roll(number, -1, axis)
            for one, other in (ends, ends[::-1]):
                here.append(one.ravel())
                there.append(other.ravel())
                share.append(opening.ravel())
        here, there, share = (np.concatenate(parts) for parts in (here, there, share))
        exchange = coo_array((share, (here, there)), shape=(number.size, number.size)).tocsc()
        exchanged = self.diffusivity * dt / patches.area
        kept = 1.0 + self.evaporation * dt + exchanged * exchange.sum(axis=1)
        return splu((diags_array(kept) - exchanged * exchange).tocsc()).solve


METHODS = {"euler": Euler, "exact": Exact, "implicit": Implicit}
