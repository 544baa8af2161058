"""The problems of the study, by name: start, box, D, flow, growth, walls, until when.

The tests and ``apmethod bench error`` take them from here.
"""

from __future__ import annotations

import numpy as np

from apmethod.bench.error.problem import FreeFem, Problem
from apmethod.bench.error.solutions import Disc, Mixture, Relaxation, WalledMixture

#: Height, variance and centre of overlapping Gaussians.  One alone would flatter every scheme:
#: the logarithm of its density is a parabola, so the agents' lattice only dilates.
HUMPS = ((1.0, 0.020, -0.25, 0.10), (0.6, 0.008, 0.20, 0.25), (0.8, 0.012, 0.10, -0.30))
HILL = ((1.0, 0.0125, 0.3, 0.3),)

TURNING = FreeFem(("y", "-x"), ("x*cos(s)-y*sin(s)", "x*sin(s)+y*cos(s)"), round=True)
SHEARED = FreeFem(("y", "0"), ("x-s*y", "y"))
STILL = FreeFem(("0", "0"), ("x", "y"))


def rotation(x, y, t):
    """V = (y, -x): one turn, clockwise, in 2 pi."""
    return y, -x


def counter_rotation(x, y, t):
    """V = (-y, x)."""
    return -y, x


def shear(x, y, t):
    """V = (y, 0)."""
    return y, 0.0


def swing(x, y, t):
    """A wind that turns, and a rotation whose sense changes, with time."""
    turn = 2.0 * np.cos(2.0 * t)
    return turn * y + 0.3 * np.cos(t), -turn * x + 0.3 * np.sin(t)


_TURN = 2.0 * np.pi
_ROUND = (-1.2, 1.2, -1.2, 1.2)
_STILL = (-1.1, 1.1, -1.1, 1.1)

PROBLEMS: dict[str, Problem] = {
    problem.name: problem
    for problem in (
        Mixture("mixture-1e-3", HUMPS, _ROUND, diffusivity=1e-3, until=_TURN, flow=rotation,
                freefem=TURNING),
        Mixture("mixture-1e-4", HUMPS, _ROUND, diffusivity=1e-4, until=_TURN, flow=rotation,
                freefem=TURNING),
        Mixture("mixture-1e-5", HUMPS, _ROUND, diffusivity=1e-5, until=_TURN, flow=rotation,
                freefem=TURNING),
        Mixture("hill-1e-3", HILL, _ROUND, diffusivity=1e-3, until=_TURN, flow=rotation,
                freefem=TURNING),
        Mixture("hill-1e-4", HILL, _ROUND, diffusivity=1e-4, until=_TURN, flow=rotation,
                freefem=TURNING),
        Mixture("hill-1e-5", HILL, _ROUND, diffusivity=1e-5, until=_TURN, flow=rotation,
                freefem=TURNING),
        Mixture("diffusion", HUMPS, _STILL, diffusivity=5e-3, until=2.0, freefem=STILL),
        Mixture("gaussian", ((1.0, 0.01, 0.0, 0.0),), _STILL, diffusivity=5e-3, until=2.0,
                freefem=STILL),
        Mixture("anisotropic", ((1.0, (0.03, 0.004, 0.004), -0.1, 0.05),
                                (0.7, (0.006, 0.02, 0.0), 0.2, -0.1)),
                _STILL, diffusivity=2e-3, until=2.0, freefem=STILL),
        Mixture("shear", HUMPS, (-2.4, 2.4, -1.1, 1.1), diffusivity=1e-3, until=3.0, flow=shear,
                freefem=SHEARED),
        Mixture("swing", HUMPS, (-1.5, 1.5, -1.5, 1.5), diffusivity=1e-3, until=3.0, flow=swing),
        Mixture("growth", HUMPS, _ROUND, diffusivity=1e-3, until=_TURN, flow=rotation,
                growth=0.3, freefem=TURNING),
        Mixture("decay", HUMPS, _STILL, diffusivity=5e-3, until=2.0, growth=-1.0, freefem=STILL),
        Disc("disc", 0.25, (0.3, 0.3), _ROUND, diffusivity=1e-3, until=_TURN, flow=rotation,
             freefem=TURNING),
        WalledMixture("walls", ((1.0, 0.01, 0.15, 0.3), (0.6, 0.02, 0.5, 0.6)),
                      (0.0, 1.0, -0.9, 1.9), "x", diffusivity=1e-2, until=1.0, freefem=STILL),
        WalledMixture("box", ((1.0, 0.01, 0.15, 0.2), (0.6, 0.02, 0.7, 0.75)),
                      (0.0, 1.0, 0.0, 1.0), "xy", diffusivity=1e-2, until=1.0, freefem=STILL),
        Relaxation("relaxation", 0.5, diffusivity=1e-2, until=10.0, freefem=STILL),
    )
}  # fmt: skip
