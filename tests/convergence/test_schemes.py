"""Order and error level of the named accuracies, on problems with exact solutions.

The levels are what the schemes reach with a margin of about 1.5.
"""

from functools import cache

import numpy as np
import pytest

from apmethod.bench.error.problems import HUMPS, PROBLEMS, counter_rotation, rotation
from apmethod.bench.error.solutions import Mixture

COUNTS = (1000, 2000, 4000, 8000)
SCHEMES = {
    "paper": {"accuracy": "paper", "integrator": "strang"},
    "plain, cubic": {"accuracy": "paper", "form": "plain", "integrator": "strang"},
    "plain, second order": {"accuracy": "accurate", "kernel": "gaussian", "spacings": 1.6},
    "plain, fourth order": {"accuracy": "accurate", "kernel": "gaussian_4"},
    "conservative": {"accuracy": "conservative"},
    "accurate": {"accuracy": "accurate"},
}


def error(problem, count, **options):
    model = problem.model(count, **{"rng": 1, **options})
    while model.elapsed < model.until:
        model.step()
    return model.errors()["l2_error"]


@cache
def errors(scheme, name, seed=1):
    return np.array([error(PROBLEMS[name], n, rng=seed, **SCHEMES[scheme]) for n in COUNTS])


def order(found):
    """Fitted order in the agents' spacing."""
    return -np.polyfit(0.5 * np.log(COUNTS), np.log(found), 1)[0]


@pytest.mark.parametrize(
    ("scheme", "least", "most", "level"),
    [
        ("accurate", 3.5, 5.0, 1.1e-5),
        ("conservative", 2.5, 4.5, 1.5e-4),
        ("plain, fourth order", 2.5, 4.5, 1.5e-4),
        ("plain, second order", 1.4, 2.4, 7e-3),
        ("paper", 0.3, 2.4, 1.5e-2),
    ],
)
def test_order_and_level(scheme, least, most, level):
    found = errors(scheme, "mixture-1e-3")
    assert least < order(found) < most
    assert found[-1] < level


def test_the_textbook_forms_are_an_order_of_magnitude_behind():
    best = errors("conservative", "mixture-1e-3")[-1]
    for scheme in ("paper", "plain, cubic", "plain, second order"):
        assert errors(scheme, "mixture-1e-3")[-1] > 10.0 * best


@pytest.mark.parametrize("scheme", ["accurate", "conservative"])
@pytest.mark.parametrize(
    ("name", "level"),
    [
        ("mixture-1e-4", 4e-4),
        ("mixture-1e-5", 2e-4),
        ("hill-1e-3", 1.5e-4),
        ("diffusion", 5e-4),
        ("anisotropic", 8e-4),
        ("swing", 5e-4),
        ("growth", 5e-4),
        ("decay", 5e-4),
        ("disc", 3e-4),
        ("walls", 3e-4),
        ("box", 3e-4),
    ],
)
def test_level_of_the_other_problems(scheme, name, level):
    assert error(PROBLEMS[name], 4000, accuracy=scheme) < level


def test_shear_all_the_way():
    """Agents that are laid anew in time are as accurate just before as at the end."""
    model, worst = PROBLEMS["shear"].model(12_000, accuracy="accurate", rng=1), 0.0
    while model.elapsed < model.until:
        model.step()
        worst = max(worst, model.errors()["l2_error"])
    assert len(model.remesh.times) == 2
    assert model.errors()["l2_error"] <= worst < 1.5e-4


@pytest.mark.parametrize("scheme", ["accurate", "conservative"])
def test_nothing_leaves_a_box(scheme):
    problem = PROBLEMS["box"]
    model = problem.model(1000, accuracy=scheme, rng=1)
    mass = model.particles.mass.sum()
    while model.elapsed < model.until:
        model.step()
        position = model.particles.position
        assert position.min() > 0.0
        assert position.max() < 1.0
    assert model.particles.mass.sum() == pytest.approx(mass, rel=1e-14)


@pytest.mark.parametrize("scheme", ["accurate", "conservative"])
@pytest.mark.parametrize("count", [1000, 2000])
def test_the_scheme_is_not_tuned_to_one_lattice_nor_to_one_turn(scheme, count):
    """Each seed lays the agents on a shifted lattice; the flow may turn the other way."""
    options = {"diffusivity": 1e-3, "until": 2.0 * np.pi}
    box = PROBLEMS["mixture-1e-3"].box
    found = [
        error(Mixture("turned", HUMPS, box, flow=flow, **options), count, accuracy=scheme, rng=seed)
        for flow in (rotation, counter_rotation)
        for seed in range(1, 5)
    ]
    assert max(found) == pytest.approx(min(found), rel=0.05)


def test_the_conservative_scheme_keeps_momentum_and_centre():
    model = PROBLEMS["diffusion"].model(1000, accuracy="conservative", rng=1)
    before = model.diagnostics()
    while model.elapsed < model.until:
        model.step()
        rate, mass = model.particles.array("_rate"), model.particles.mass
        assert np.abs(mass @ rate).max() < 1e-14 * (mass @ np.abs(rate)).max()
    after = model.diagnostics()
    assert after["centroid_x"] == pytest.approx(before["centroid_x"], abs=1e-14)
    assert after["centroid_y"] == pytest.approx(before["centroid_y"], abs=1e-14)
