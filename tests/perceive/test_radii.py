"""Core radii of agents' own: who is a neighbour of whom, and how many they keep."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import (
    AgentParticle,
    Column,
    KeepNeighbours,
    Mirrored,
    Open,
    ParticleModel,
    Periodic,
    explain,
    set_threads,
    square,
)
from apmethod.compile import threads
from apmethod.message import parts
from apmethod.perceive.cells import grid_of
from apmethod.perceive.pairs import neighbour_pairs
from apmethod.perceive.radii import sort_by_radius
from samples import Curious, build, column_by_id

# Radii here are what is tried, not what is good for a run.
pytestmark = pytest.mark.filterwarnings("ignore::apmethod.Unstable")

UNIT = Periodic((0.0, 0.0), (1.0, 1.0))


def all_pairs(positions, radii, domain):
    """Pairs closer than the mean of their radii, each pair tried."""
    apart = positions[:, None] - positions[None]
    if domain.periods[0]:
        apart -= np.round(apart)
    reach = 0.5 * (radii[:, None] + radii[None])
    return np.argwhere(np.triu((apart**2).sum(-1) < reach**2, 1))


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 2**32 - 1), st.integers(1, 300), st.floats(1.0, 1e3),
    st.integers(0, 3), st.sampled_from([Open(), UNIT]),
)  # fmt: skip
def test_neighbours_are_those_of_trying_all_pairs(seed, count, contrast, level, domain):
    draw = np.random.default_rng(seed)
    positions = draw.random((count, 2)) ** draw.integers(1, 4)
    radii = 0.5 * contrast ** -draw.random(count)
    cells = sort_by_radius(positions, radii, level, domain)
    assert np.array_equal(neighbour_pairs(cells), all_pairs(positions, radii, domain))


class Eyed(Curious):
    """Has a radius of its own."""

    core_radius = Column(start=0.2)


def eyed(**options):
    options.setdefault("domain", UNIT)
    model = build(250, agent_class=Eyed, **options)
    order = np.argsort([agent.unique_id for agent in model.particles.agents])
    model.particles.array("core_radius")[order] = np.geomspace(0.03, 0.4, 250)
    model.particles.assign("charge", 1.0 + model.particles.position[:, 0])
    return model


def same(one, other):
    for name in one.particles.names:
        a, b = column_by_id(one, name), column_by_id(other, name)
        assert np.abs(a - b).max() <= 1e-12 * np.abs(a).max(), name


@pytest.mark.parametrize("form", ["paper", "plain", "blob"])
@pytest.mark.parametrize("domain", [Open(), UNIT, Mirrored((0.0, 0.0), (1.0, 1.0))])
def test_evaluations_levels_and_tiers_agree(form, domain):
    expected = eyed(form=form, domain=domain)
    others = [
        eyed(form=form, domain=domain, **options)
        for options in (
            {"evaluation": "gathered"},
            {"evaluation": "stored"},
            {"level": 2},
            {"tier": "agents"},
        )
    ]
    for model in (expected, *others):
        model.step()
    for model in others:
        same(expected, model)


@pytest.mark.parametrize("domain", [Open(), UNIT, Mirrored((0.0, 0.0), (1.0, 1.0))])
def test_parts_that_reach_over_several_others_agree(domain, monkeypatch):
    expected = eyed(domain=domain, evaluation="gathered")
    expected.step()
    monkeypatch.setattr(parts, "_LEAST", 1)  # as many parts as there can be
    monkeypatch.setattr(parts, "_COPIES", np.inf)
    found = eyed(domain=domain, evaluation="scattered")
    found.step()
    same(expected, found)


def test_agents_far_out_take_no_memory_for_the_space_between():
    draw = np.random.default_rng(5)
    positions, radii = draw.random((300, 2)), 0.1 ** draw.uniform(0.5, 2.0, 300)
    for far in (1e4, 1e8, 1e15):
        positions[:3] = [[far, 0.0], [0.0, -far], [-far, far]]
        tracemalloc.start()
        cells = sort_by_radius(positions, radii, 1, Open())
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert most < 2**22
        assert np.array_equal(neighbour_pairs(cells), all_pairs(positions, radii, Open()))


@pytest.mark.parametrize("far", [1e9, 1e14, 1e15])
def test_far_out_agents_around_a_corner_of_a_sub_domain_are_found(far):
    # Numbers of sub-domains are rounded there by more than agents are apart.
    for seed in range(40):
        draw = np.random.default_rng(seed)
        reach = far * draw.uniform(1e-12, 1e-8)
        side, grid = grid_of((2.0 * far, 2.0 * far), reach, 0)
        corner = -far + side * draw.integers(1, grid[0], 2)
        positions = corner + reach * draw.uniform(-1.0, 1.0, (40, 2))
        positions = np.vstack([positions, [[-far, -far], [far, far]]])
        radii = np.append(reach * 10.0 ** -draw.uniform(0.0, 1.0, 40), [reach, reach])
        found = neighbour_pairs(sort_by_radius(positions, radii, 0, Open()))
        assert np.array_equal(found, all_pairs(positions, radii, Open()))


def test_agents_in_python_live_beside_compiled_ones():
    class Slow(Eyed):
        def perceive(self):
            super().perceive()

    models = [eyed(others=[Slow]), eyed(others=[Slow], tier="agents")]
    for model in models:
        model.step()
    same(*models)


def test_equal_radii_are_one_radius():
    shared = build(300, agent_class=Curious, domain=UNIT)
    own = build(300, agent_class=Eyed, domain=UNIT)
    for model in (shared, own):
        model.step()
    for name in shared.particles.names:
        a, b = column_by_id(shared, name), column_by_id(own, name)
        assert np.abs(a - b).max() <= 1e-12 * np.abs(a).max(), name


def test_momentum_is_kept_with_unequal_radii():
    model = eyed(flow=None, form="blob", integrator="euler")
    start = model.diagnostics()
    before = (model.particles.mass[:, None] * model.particles.position).sum(axis=0)
    model.step()
    push = model.particles.mass[:, None] * (model.particles.blob_gradient)
    assert np.abs(push.sum(axis=0)).max() <= 1e-13 * np.abs(push).sum()
    assert model.diagnostics()["mass"] == start["mass"]
    assert np.isfinite(before).all()


def test_threads_change_no_bit():
    known, found = threads(), set()
    try:
        for count in (1, 2, 3):
            set_threads(count)
            model = crowds(4000, 50.0)
            model.step()
            found.add(model.particles.density.tobytes() + model.particles.core_radius.tobytes())
    finally:
        set_threads(known)
    assert len(found) == 1


def crowds(count, contrast, **options):
    """Half of the agents in a square whose density is ``contrast`` times that of the rest."""
    draw = np.random.default_rng(3)
    positions = draw.random((count, 2))
    side = np.sqrt(1.0 / (1.0 + contrast))
    positions[: count // 2] = 0.4 + side * positions[: count // 2]
    options.setdefault("radius_rule", KeepNeighbours())
    return build(
        positions=positions, core_radius=np.sqrt(28 / np.pi / count), kernel="cubic", flow=None,
        dt=1e-9, **options,
    )  # fmt: skip


@pytest.mark.parametrize("contrast", [1.0, 100.0])
def test_the_wanted_number_of_neighbours_is_kept(contrast):
    model = crowds(3000, contrast)
    model.step()
    count = model.space.neighbour_counts()
    assert np.mean((count >= 25) & (count <= 30)) > 0.9
    assert count.min() >= 20
    assert count.max() <= 36
    assert np.array_equal(count, model.particles.neighbour_count)
    if contrast > 1.0:
        radii = model.particles.core_radius
        assert np.median(radii[:1500]) < 0.2 * np.median(radii[1500:])


def test_radii_follow_agents_that_spread():
    model = crowds(500, 1.0)
    model.step()
    before = np.median(model.particles.core_radius)
    for _ in range(30):
        model.particles.assign("position", model.particles.position * 1.03)
        model.step()
    after = np.median(model.particles.core_radius)
    assert after / before == pytest.approx(1.03**30, rel=0.1)
    count = model.space.neighbour_counts()
    assert np.mean((count >= 22) & (count <= 33)) > 0.8


def test_agents_alone_and_agents_in_one_place_keep_to_the_limits():
    positions = np.vstack([np.zeros((60, 2)), [[100.0, 0.0]]])
    rule = KeepNeighbours(smallest=0.01, largest=2.0)
    model = build(positions=positions, core_radius=0.5, radius_rule=rule, flow=None, dt=1e-6)
    model.step()
    radii = column_by_id(model, "core_radius")
    assert radii[:60] == pytest.approx(0.01)
    assert radii[60] == 2.0
    assert np.isfinite(model.particles.position).all()


def test_explain_and_the_largest_step_know_the_radii():
    alike = build(2, core_radius=0.03, flow=None, dt=1e-9)
    assert eyed(flow=None).largest_dt() == pytest.approx(alike.largest_dt())
    assert "each agent's own" in dict(explain(crowds(50, 1.0)))["core radius"]


def test_bad_radii_are_refused():
    model = eyed()
    model.particles.agents[3].core_radius = 0.0
    with pytest.raises(ValueError, match=r"core_radius of <Eyed 4 at .* is 0; it must be above 0"):
        model.step()
    model.particles.agents[3].core_radius = 0.6
    with pytest.raises(ValueError, match="periodic domain must be at least two core radii"):
        model.step()
    for wrong in ({"fewest": 0}, {"fewest": 30, "most": 20}, {"smallest": -1.0},
                  {"smallest": 2.0, "largest": 1.0}):  # fmt: skip
        with pytest.raises(ValueError, match=f"{list(wrong)[-1]} is|must be"):
            KeepNeighbours(**wrong)


def test_agents_that_come_later_have_the_models_radius():
    model = ParticleModel(
        AgentParticle, core_radius=0.3, terms=[], dt=0.1, radius_rule=KeepNeighbours(), rng=0
    )
    AgentParticle.create_agents(model, 5, position=np.random.default_rng(0).random((5, 2)))
    assert (model.particles.core_radius == 0.3).all()
    model.step()
    late = AgentParticle(model, position=(0.5, 0.5))
    assert late.core_radius == 0.3
    model.step()


def test_walls_that_hide_agents_take_one_radius():
    walls = [square((0.5, 0.5), 0.001)]
    with pytest.raises(ValueError, match="give Obstacles"):
        eyed(domain=Open(), obstacles=walls)
