"""The largest stable step of each scheme, found by bisection, beside the theory.

A lattice of agents at rest is shaken by a ten-millionth of its spacing.  A step is stable
if the velocities have not grown between the 30th and the 60th of such steps.

With splines there is another growth, which no step avoids: their Fourier transform is
negative around k h = 7.5, where the plain and the blob form then draw agents together in
pairs.  It is slow and its rate is known, so it is taken off.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from apmethod.bench.stability.boxes import Box
from apmethod.contribute.smoothing import KERNELS
from apmethod.move.diffusion import FORMS

Scheme = tuple[str, str, str]

#: Form, kernel, integrator: each form with each kernel it goes with, and the integrators.
SCHEMES: tuple[Scheme, ...] = (
    *((form, kernel, "midpoint") for form in FORMS for kernel in KERNELS
      if form != "blob" or KERNELS[kernel].order == 2),
    *((form, kernel, integrator) for form, kernel in (
        ("paper", "cubic"), ("plain", "gaussian_6"), ("blob", "gaussian"))
      for integrator in ("euler", "predictor_corrector", "heun_3", "rk4", "strang_3")),
)  # fmt: skip
QUICK: tuple[Scheme, ...] = (
    ("paper", "cubic", "euler"),
    ("paper", "cubic", "predictor_corrector"),
    ("paper", "gaussian", "midpoint"),
    ("plain", "gaussian", "midpoint"),
    ("plain", "gaussian_4", "midpoint"),
    ("plain", "gaussian_6", "strang_3"),
    ("plain", "wendland_c4", "midpoint"),
    ("blob", "gaussian", "euler"),
    ("blob", "gaussian", "strang_3"),
    ("blob", "gaussian", "rk4"),
    ("blob", "cubic", "midpoint"),
)

_SHAKEN, _STEPS = 1e-7, 60
#: Shares of the theory's limit between which the measured one is looked for, and how often.
_BETWEEN, _HALVINGS = (0.3, 3.0), 8


def limit(scheme: Scheme) -> dict[str, Any]:
    """Theory and measurement of one scheme, as D dt/h^2."""
    box = Box(*scheme)
    unit, pairing = box.limit / box.bus.smoothing_length**2, pairing_rate(*scheme[:2])
    low, high = _BETWEEN
    for _ in range(_HALVINGS):
        middle = np.sqrt(low * high)
        if growth(box, middle) < np.exp(pairing * middle * unit):
            low = middle
        else:
            high = middle
    measured = float(np.sqrt(low * high))
    form, kernel, integrator = scheme
    return {
        "study": "limit", "form": form, "kernel": kernel, "integrator": integrator,
        "theory": unit, "measured": measured * unit, "measured_over_theory": measured,
        "pairing": pairing,
    }  # fmt: skip


def pairing_rate(form: str, kernel: str) -> float:
    """Rate, in D/h^2, at which agents are drawn together in pairs; 0 for most kernels."""
    k, transform = KERNELS[kernel].transform
    rate = -float((k * k * FORMS[form].decay(transform)).min())
    return rate if rate > 1e-3 else 0.0


def growth(box: Box, share: float) -> float:
    """By what the velocities of a shaken box grow in a step, at a share of the theory's limit.

    Runs that have gone from rest to a thousandth of D/h have no linear growth any more; they
    grow by what took them there.
    """
    box.put(_SHAKEN * box.places[1, 0])
    speeds = box.speeds(share * box.limit, _STEPS)
    half = _STEPS // 2
    beyond = np.flatnonzero(speeds > 1e-3)
    if len(beyond) and beyond[0] < half:
        return float((1e-3 / speeds[0]) ** (1.0 / max(1, beyond[0])))
    end = beyond[0] if len(beyond) else _STEPS - 1
    return float((min(speeds[end], 1e9) / speeds[half - 1]) ** (1.0 / (end - half + 1)))


def growths(
    scheme: Scheme, spacings: Sequence[float], shares: Sequence[float], along: int = 24
) -> list[dict[str, Any]]:
    """Growth in a step over (dt, h/dx): a map of where a scheme is stable."""
    rows = []
    for each in spacings:
        box = Box(*scheme, spacings=each, along=along)
        for share in shares:
            rows.append({
                "study": "map", "form": scheme[0], "kernel": scheme[1], "integrator": scheme[2],
                "spacings": each, "share_of_limit": share,
                "number": share * box.limit / box.bus.smoothing_length**2,
                "growth": growth(box, share),
            })  # fmt: skip
    return rows
