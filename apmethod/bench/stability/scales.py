"""The same problem in other units, and with other ratios of flow to diffusion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from apmethod.bench.error.problems import HILL, HUMPS, rotation
from apmethod.bench.error.solutions import Mixture

_BOX = (-1.2, 1.2, -1.2, 1.2)


def units(accuracy: str, decades: Sequence[int], particles: int) -> list[dict[str, Any]]:
    """Relative errors with lengths, masses and times in units of 10^decade.

    Half of a turn with the flow, where times keep their unit, and diffusion without it,
    where they go with the square root of the lengths.  The masses' unit goes down as the
    lengths' goes up.
    """
    rows: list[dict[str, Any]] = []
    for flow in (rotation, None):
        first: list[float] = []
        for decade in decades:
            length, second = 10.0**decade, 1.0 if flow else 10.0 ** (0.5 * decade)
            humps = [
                (height / length, variance * length**2, x * length, y * length)
                for height, variance, x, y in HUMPS
            ]
            problem = Mixture(
                "units", humps, [side * length for side in _BOX], flow=flow, until=3.0 * second,
                diffusivity=5e-3 * length**2 / second,
            )  # fmt: skip
            error, steps = _solved(problem, particles, accuracy)[:2]
            first = first or [error]
            rows.append({
                "study": "units", "accuracy": accuracy, "flow": "rotation" if flow else "none",
                "decade": decade, "steps": steps, "error": error,
                "off": abs(error / first[0] - 1.0),
            })  # fmt: skip
    return rows


def peclet(accuracy: str, diffusivities: Sequence[float], particles: int) -> list[dict[str, Any]]:
    """The hill once around the origin, with ever less diffusion.

    The Peclet number is that of the hill's way, V L / D with V = 0.42 and L = 0.22.
    """
    rows = []
    for diffusivity in diffusivities:
        problem = Mixture(
            "peclet", HILL, _BOX, diffusivity=diffusivity, until=2.0 * np.pi, flow=rotation
        )
        error, steps, drift = _solved(problem, particles, accuracy)
        rows.append({
            "study": "peclet", "accuracy": accuracy, "peclet": 0.42 * 0.22 / diffusivity,
            "steps": steps, "error": error, "mass_drift": drift,
        })  # fmt: skip
    return rows


def _solved(problem: Mixture, particles: int, accuracy: str) -> tuple[float, int, float]:
    """Error, steps and drift of the mass of a run."""
    model = problem.model(particles, accuracy=accuracy, rng=1)
    mass = model.particles.mass.sum()
    while model.elapsed < model.until:
        model.step()
    return model.errors()["l2_error"], model.steps, abs(model.particles.mass.sum() / mass - 1.0)
