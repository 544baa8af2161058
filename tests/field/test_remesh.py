"""Laying agents anew: what is kept, when it happens, and who is who afterwards."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import DiffusingParticle, Domain, FieldModel, Mirrored, Open
from apmethod.bench.error.problems import HUMPS, PROBLEMS, shear
from apmethod.bench.error.solutions import Mixture
from apmethod.field.remesh import keeping_moments

BOX = (-1.0, 1.0, -1.0, 1.0)


def hump(x, y):
    return np.exp(-12.0 * (x**2 + y**2))


def scene(count=900, **options):
    return FieldModel(hump, BOX, particles=count, accuracy="accurate", rng=3, **options)


def moments(places, masses):
    return np.array([masses.sum(), *masses @ places])


@given(
    seed=st.integers(0, 10**6),
    count=st.integers(1, 30),
    line=st.sampled_from([None, 0.0, 0.3]),
)
@settings(max_examples=60, deadline=None)
def test_mending_keeps_mass_and_centre_and_no_mass_is_negative(seed, count, line):
    draw = np.random.default_rng(seed)
    places, masses = draw.normal(size=(count, 2)), draw.random(count) + 1e-3
    if line is not None:
        places[:, 1] = 0.1 + line * places[:, 0]
    # Masses that are a little off, as a reading is.
    weights = masses * (1.0 + 0.1 * draw.uniform(-1.0, 1.0, count))
    found = keeping_moments(places, masses, places, weights, Open())
    assert found.min() > 0.0
    assert found.sum() == pytest.approx(weights.sum(), rel=1e-13)
    change = found / masses * (masses.sum() / weights.sum()) - 1.0
    if np.abs(change).max() < 0.49:
        assert moments(places, found) == pytest.approx(moments(places, weights), abs=1e-12)


def test_mending_stays_within_half_of_a_mass_and_leaves_periodic_axes_alone():
    places = np.array([[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]])
    far = keeping_moments(places, np.ones(3), places + 1.0, np.ones(3), Open())
    assert far.sum() == pytest.approx(3.0)
    assert np.abs(far - 1.0).max() == pytest.approx(0.5)
    weights = np.array([1.0, 1.1, 0.9])
    domain = Domain((-1, -1), (1, 1), ("periodic", "bounded"))
    one = keeping_moments(places, np.ones(3), places, weights, domain)
    assert one[0] == pytest.approx(one[1])
    assert one @ places[:, 1] == pytest.approx(weights @ places[:, 1])


def test_laying_anew_from_a_strained_lattice_is_of_high_order():
    """A shear by 0.9 is a strain of 0.44: as far as the accurate scheme lets it go."""
    counts, errors = (900, 1800, 3600), []
    for count in counts:
        model = scene(count)
        x, y = model.particles.position.T
        model.particles.assign("position", np.column_stack([x + 0.9 * y, y]))
        model.remesh.lay_anew()
        x, y = model.particles.position.T
        exact = hump(x - 0.9 * y, y)
        off = model.particles.mass / model.spacing**2 - exact
        errors.append(np.sqrt((off**2).sum() / (exact**2).sum()))
    order = -np.polyfit(0.5 * np.log(counts), np.log(errors), 1)[0]
    assert 3.5 < order < 7.0
    assert errors[-1] < 4e-5


def walled(borders, count=1600):
    """A wave between walls, drawn along them and across periodic sides; and its masses anew."""
    domain = Domain((0, 0), (1, 1), borders)
    across, drawn = borders.index("periodic"), 0.28

    def wave(x, y):
        along, up = (x, y) if across == 0 else (y, x)
        return 1.0 + 0.5 * np.cos(2.0 * np.pi * along) * np.cos(np.pi * up)

    model = FieldModel(wave, (0, 1, 0, 1), particles=count, accuracy="accurate", domain=domain)
    places = np.array(model.particles.position)
    places[:, across] += drawn * np.cos(np.pi * places[:, 1 - across])
    places[:, across] %= 1.0
    model.particles.assign("position", places)
    assert model.remesh.strain() > 0.3
    mass = model.particles.mass.sum()
    model.remesh.lay_anew()
    assert model.particles.mass.sum() == pytest.approx(mass, rel=1e-13)
    places = np.array(model.particles.position)
    places[:, across] -= drawn * np.cos(np.pi * places[:, 1 - across])
    return model, wave(*places.T)


@pytest.mark.parametrize(
    "borders", [("periodic", "mirrored"), ("mirrored", "periodic"), ("periodic", "bounded")]
)
def test_laying_anew_sees_across_sides_and_the_mirror_behind_walls(borders):
    model, exact = walled(borders)
    density = model.particles.mass * len(model.particles)  # the square is of area 1
    assert density == pytest.approx(exact, abs=1e-5)


def test_what_weighs_nothing_is_left_where_it_is():
    model = scene(50)
    model.particles.assign("mass", np.zeros(50))
    model.remesh.lay_anew()
    assert len(model.particles) == 50


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
    for name in ("centroid_x", "centroid_y"):
        assert after[name] == pytest.approx(before[name], abs=1e-14)
    assert np.abs(model.field(*grid) - field).max() < 8e-4 * field.max()
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
    assert errors[None] < min(1.6e-3, 0.2 * errors[0.0])


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
