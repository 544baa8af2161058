"""Laying agents anew: what is kept, when it happens, and who is who afterwards."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import DiffusingParticle, FieldModel, Mirrored, Open, Periodic
from apmethod.bench.error.problems import HUMPS, PROBLEMS, shear
from apmethod.bench.error.solutions import Mixture
from apmethod.field.remesh import m6, spread

BOX = (-1.0, 1.0, -1.0, 1.0)


def hump(x, y):
    return np.exp(-12.0 * (x**2 + y**2))


def scene(count=900, **options):
    return FieldModel(hump, BOX, particles=count, accuracy="accurate", rng=3, **options)


@given(x=st.floats(0.0, 1.0))
@settings(max_examples=40, deadline=None)
def test_m6_keeps_moments_up_to_the_second(x):
    nodes = np.arange(-4, 6)
    weights = np.array([m6(x - node) for node in nodes])
    for power in range(3):
        assert weights @ nodes**power == pytest.approx(x**power, abs=1e-12)


@pytest.mark.parametrize("domain", [Open(), Mirrored((0, 0), (1, 1)), Periodic((0, 0), (1, 1))])
def test_spreading_keeps_the_mass(domain):
    draw = np.random.default_rng(2)
    positions, masses = draw.random((200, 2)), draw.random(200)
    if domain.is_open:
        positions = 0.3 + 0.4 * positions
    shift = 0.5 if domain.borders[0] == "mirrored" else 0.0
    nodes = spread(positions, masses, (shift / 12,) * 2, (1 / 12,) * 2, (12, 12), domain.kinds)
    assert nodes.sum() == pytest.approx(masses.sum())
    if domain.is_open:
        x = np.arange(12) / 12
        assert x @ nodes.sum(axis=1) == pytest.approx(masses @ positions[:, 0])


def test_the_strain_is_that_of_the_lattice():
    model = scene()
    assert model.remesh.strain() == pytest.approx(0.0, abs=1e-12)
    x, y = model.particles.position.T
    model.particles.assign("position", np.column_stack([y, -x]))
    assert model.remesh.strain() == pytest.approx(0.0, abs=1e-12)
    model.particles.assign("position", np.column_stack([x + 1.5 * y, y]))
    assert model.remesh.strain() == pytest.approx(np.arcsinh(0.75))


def test_a_lattice_stretched_between_walls_is_not_strained():
    model = FieldModel(lambda x, y: 1.0 + 0.0 * x, (0, 3, 0, 1), particles=1000,
                       accuracy="accurate", domain=Mirrored((0, 0), (3, 1)))  # fmt: skip
    assert abs(model.remesh.strain()) < 0.02


def test_laying_anew_keeps_mass_centre_and_field():
    model = scene()
    x, y = model.particles.position.T
    model.particles.assign("position", np.column_stack([x + 0.5 * y, y]))
    before, grid = model.diagnostics(), model.grid()
    field = model.field(*grid)
    model.remesh.lay_anew()
    after = model.diagnostics()
    assert after["mass"] == pytest.approx(before["mass"], rel=1e-13)
    assert after["centroid_x"] == pytest.approx(before["centroid_x"], abs=1e-4)
    assert np.abs(model.field(*grid) - field).max() < 3e-3 * field.max()
    assert model.remesh.strain() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("drawn", [0.6, 1.5])
def test_agents_stay_who_they_are_and_come_and_go(drawn):
    """Drawn together there are nodes for fewer, drawn apart for more."""
    model = scene()
    model.particles.assign("position", drawn * np.array(model.particles.position))
    before = {agent: agent.position for agent in model.particles.agents}
    model.remesh.lay_anew()
    now = model.particles.agents
    kept = [agent for agent in now if agent in before]
    assert (len(now) > len(before)) == (drawn > 1.0)
    assert len(kept) == min(len(now), len(before))
    assert len(model.agents) == len(now)
    moved = [np.hypot(*(agent.position - before[agent])) for agent in kept]
    assert np.median(moved) < model.spacing
    model.step()


def test_a_sheared_scene_is_laid_anew_and_gains_by_it():
    errors = {}
    for remesh in (None, 0.0):
        model = PROBLEMS["shear"].model(3000, accuracy="accurate", rng=2, remesh=remesh)
        while model.elapsed < model.until:
            model.step()
        errors[remesh] = model.errors()["l2_error"]
        assert (model.remesh is not None and len(model.remesh.times) > 1) == (remesh is None)
    assert errors[None] < 0.3 * errors[0.0]


def test_a_rotating_scene_is_never_laid_anew():
    model = PROBLEMS["mixture-1e-3"].model(1000, accuracy="accurate", rng=2)
    while model.elapsed < model.until:
        model.step()
    assert model.remesh.times == []


@pytest.mark.parametrize("rate", [0.7, -0.7])
def test_growth_is_exact_and_the_same_in_both_tiers(rate):
    problem = Mixture("growing", HUMPS, (-1, 1, -1, 1), diffusivity=1e-3, until=0.6, growth=rate,
                      flow=shear)  # fmt: skip
    models = [problem.model(60, rng=1, tier=tier, dt=0.2) for tier in ("compiled", "agents")]
    for model in models:
        mass = model.particles.mass.sum()
        while model.elapsed < model.until:
            model.step()
        assert model.particles.mass.sum() == pytest.approx(mass * np.exp(0.6 * rate), rel=1e-13)
    one, other = models
    assert one.particles.position == pytest.approx(other.particles.position, rel=1e-12)
    assert one.particles.mass == pytest.approx(other.particles.mass, rel=1e-14)
    still = Mixture("still", HUMPS, (-1, 1, -1, 1), diffusivity=1e-3, until=0.6, flow=shear)
    plain = still.model(60, rng=1, dt=0.2)
    while plain.elapsed < plain.until:
        plain.step()
    assert one.particles.position == pytest.approx(plain.particles.position, rel=1e-12)


def test_the_field_can_be_read_on_agents():
    model = FieldModel(hump, BOX, particles=2000, rng=1, agent_class=DiffusingParticle)
    assert model.field_on_agents() == pytest.approx(hump(*model.particles.position.T), abs=2e-4)
