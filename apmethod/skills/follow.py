"""Following a signal: V = lambda grad s (paper eq 3.4)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from apmethod.checks import finite_number
from apmethod.contribute.smoothing import Kernel
from apmethod.move.law import Law
from apmethod.skills.signal import SignalField


class Follow(Law):
    """An agent goes up the gradient of a signal, V = lambda grad s; down it if lambda < 0.

    Args:
        signal: the field, which must be among the scene's skills.
        sensitivity: lambda, length^4/(signal time).

    Raises:
        ValueError: if the sensitivity is not finite.
    """

    def __init__(self, signal: SignalField, sensitivity: float):
        self.signal = signal
        self.sensitivity = finite_number("sensitivity", sensitivity)
        super().__init__(
            f"follows {signal.name}",
            _uphill(signal.name),
            reads=(f"{signal.name}_gradient",),
            parameters={"sensitivity": self.sensitivity},
        )

    def largest_step(self, kernel: Kernel, smoothing_length: float, reach: float) -> float:
        """The largest stable time step for agents around the signal's steepest peak.

        They are drawn to it at the rate lambda |s_xx|; an integrator that is stable down to
        -reach takes steps of at most reach over that.
        """
        if not hasattr(self.signal, "values"):
            return np.inf  # no model has laid the patches yet
        rate = abs(self.sensitivity) * self.signal.steepest_turn()
        return reach / rate if rate else np.inf


def growth_rate(
    k: np.ndarray | float, density: float, diffusivity: float, follow: Follow
) -> np.ndarray | float:
    """How fast a small wave grows on a uniform population, 1/time; below 0 it decays.

    The larger eigenvalue of the linearised equations 3.4 (signs mended) at u0 and
    s0 = alpha u0 / beta (Keller and Segel 1970),

        [[-D k^2, lambda u0 k^2], [alpha, -(Ds k^2 + beta)]],

    which is above 0, the animals gather, where alpha lambda u0 > D (Ds k^2 + beta).

    Args:
        k: wave number, 2 pi over the wave's length; a number or an array.
        density: u0, animals per area.
        diffusivity: D of the animals.
        follow: the law by which they follow the signal.
    """
    signal = follow.signal
    spread = diffusivity * k * k
    loss = signal.diffusivity * k * k + signal.evaporation
    drawn = signal.production * follow.sensitivity * density * k * k
    return 0.5 * (np.sqrt((spread - loss) ** 2 + 4.0 * drawn) - spread - loss)


@cache
def _uphill(name: str) -> Callable:
    # The column's name is the scene's own, and numba needs it spelled out.
    gradient = f"agent.{name}_gradient"
    return eval(f"lambda agent, p: (p.sensitivity * {gradient}[0], p.sensitivity * {gradient}[1])")
