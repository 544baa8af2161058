"""Long runs: what drifts in 10^5 steps, and shipped scenes far beyond their own length."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from apmethod.bench.error.problems import HILL, rotation
from apmethod.bench.error.solutions import Mixture
from apmethod.bench.stability.boxes import Box
from apmethod.errors import Unstable
from apmethod.model import MARGIN, ParticleModel
from apmethod.perceive.lattice import QuadLattice
from apmethod.run.scenes import load_scene

Moment = tuple[float, np.ndarray, float]
#: Steps of a shipped scene at the most.
_LONGEST = 20_000
#: What a shipped scene may not leave in ten times its default length, or `_LONGEST` steps.
BOUNDS = {
    "mass_drift": 1e-12,  # unless obstacles take agents out, and then it may not grow
    "outside": 0,  # agents outside of their domain
    "radius_growth": 100.0,  # largest core radius over the first, or the first over the least
    "warnings": 0,  # signs of instability
}


def at_rest(steps: int) -> dict[str, Any]:
    """A jittered lattice in a periodic box, conservative scheme at the model's own step."""
    box = Box("blob", "gaussian", "euler", start="jittered", spacings=1.4)
    return _followed("at rest in a box, blob", box, steps, MARGIN * box.limit)


def turning(accuracy: str, steps: int) -> dict[str, Any]:
    """A hill that spreads and turns in 3142 steps, again and again."""
    problem = Mixture(
        "turning", HILL, (-1.2, 1.2, -1.2, 1.2), diffusivity=1e-6, until=2e-3 * steps, flow=rotation
    )
    model = problem.model(200, accuracy=accuracy, rng=1, dt=2e-3, remesh=0.0)
    return _followed(f"spreads and turns, {accuracy}", model, steps, 2e-3, rotation_of)


def rotation_of(place: np.ndarray, time: float) -> np.ndarray:
    """Where V = (y, -x) takes a place in some time."""
    c, s = np.cos(time), np.sin(time)
    return np.array([c * place[0] + s * place[1], c * place[1] - s * place[0]])


def _followed(
    name: str, model: ParticleModel, steps: int, dt: float, carried: Callable | None = None
) -> dict[str, Any]:
    """Run a model, and see what has drifted."""
    mass, centre, order = _moments(model)
    model.dt = dt
    momentum, way, first = 0.0, np.zeros(2), 0.0
    for _ in range(steps):
        model.step()
        rate, weight = model.particles.array("_rate"), model.particles.array("mass")
        sums, first = weight @ rate, first or (weight @ np.abs(rate)).max()
        momentum = max(momentum, float(np.abs(sums).max() / first))
        way += sums * model.motion.dt / mass
    mass_now, centre_now, order_now = _moments(model)
    # Across periodic sides the centre of mass is only known by its way.
    off = centre_now - carried(centre, model.elapsed) if carried else way
    return {
        "study": "long", "run": name, "steps": steps, "time": model.elapsed,
        "mass_drift": abs(mass_now / mass - 1.0), "largest_momentum": momentum,
        "centroid_drift": float(np.hypot(*off) / model.space.core_radius),
        "order_first": order, "order_last": order_now,
    }  # fmt: skip


def _moments(model: ParticleModel) -> Moment:
    """Mass, its centre, and the order: least over mean distance to the nearest neighbour."""
    mass, places = model.particles.mass, model.particles.position
    return float(mass.sum()), mass @ places / mass.sum(), _order(model.space)


def _order(space: QuadLattice) -> float:
    pairs, places = space.pairs(), space.particles.position
    apart = places[pairs[:, 0]] - places[pairs[:, 1]]
    for axis, period in enumerate(space.domain.periods):
        if period:
            apart[:, axis] -= period * np.round(apart[:, axis] / period)
    nearest = np.full(len(places), np.inf)
    for end in range(2):
        np.minimum.at(nearest, pairs[:, end], np.hypot(*apart.T))
    nearest = nearest[np.isfinite(nearest)]
    return float(nearest.min() / nearest.mean()) if len(nearest) else np.nan


def scene(name: str, times: float = 10.0) -> dict[str, Any]:
    """A shipped scene so many times its default length, or `_LONGEST` steps, by `BOUNDS`."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model = load_scene(name)(rng=1)
        model.until = times * model.until
        mass, radius = model.particles.mass.sum(), model.space.core_radius
        radii = [radius]
        while model.elapsed < model.until and model.steps < _LONGEST:
            model.step()
            radii.append(model.space.core_radius)
    grown = float(model.particles.mass.sum() / mass - 1.0)
    said = [str(each.message) for each in caught if issubclass(each.category, Unstable)]
    domain, places = model.space.domain, model.particles.position
    found = {
        "mass_drift": max(grown, 0.0) if model.obstacles is not None else abs(grown),
        "outside": int(((places < domain.lower) | (places > domain.upper)).any(axis=1).sum()),
        "radius_growth": max(max(radii) / radius, radius / min(radii)),
        "warnings": len(said),
    }
    return {
        "study": "scene", "scene": name, "time": model.elapsed, "steps": model.steps,
        "agents": len(places), **found, "said": "; ".join(said),
        "kept": all(found[bound] <= most for bound, most in BOUNDS.items()),
    }  # fmt: skip
