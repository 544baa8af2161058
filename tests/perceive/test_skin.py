"""A search kept over several steps misses no pair, whatever the agents do meanwhile."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import (
    AgentParticle,
    Bounded,
    Mirrored,
    ParticleModel,
    Periodic,
    brute_force_pairs,
    explain,
)
from apmethod.contribute.terms import density
from apmethod.perceive.skin import furthest
from samples import Curious, build, column_by_id

RADIUS = 0.2


def scene(positions, skin=0.3, domain=None, **options):
    model = ParticleModel(
        AgentParticle, core_radius=RADIUS, domain=domain, skin=skin, dt=1.0, rng=0, **options
    )
    AgentParticle.create_agents(model, len(positions), position=positions)
    return model


def check(model):
    model.space.take_down()
    found = brute_force_pairs(model.particles.position, model.space.core_radius, model.space.domain)
    assert np.array_equal(model.space.pairs(), found)
    return model.space.skin


@settings(max_examples=30, deadline=None)
@given(
    st.integers(0, 2**32 - 1), st.floats(0.0, 1.0), st.floats(1e-4, 1.0),
    st.sampled_from([None, Bounded((0.0, 0.0), (1.0, 1.0)), Periodic((0.0, 0.0), (1.0, 1.0)),
                     Mirrored((0.0, 0.0), (1.0, 1.0))]),
)  # fmt: skip
def test_no_pair_is_missed_as_agents_wander(seed, skin, stride, domain):
    draw = np.random.default_rng(seed)
    model = scene(draw.random((60, 2)), skin, domain)
    for _ in range(8):
        moved = model.particles.position + stride * draw.normal(size=(60, 2)) * RADIUS
        model.particles.assign("position", np.clip(moved, 0.0, 1.0 - 1e-9))
        check(model)


def test_two_agents_that_meet_at_the_limit_of_the_skin():
    # Just out of the reach of the search, then each as far as may be without a new one.
    gap = RADIUS * 1.3 * (1.0 + 1e-12)
    model = scene(np.array([[0.0, 0.0], [gap, 0.0]]))
    check(model)
    for share in (0.999, 1.0, 1.0 + 1e-6, 1.1):
        step = 0.5 * 0.3 * RADIUS * share
        model.particles.assign("position", [[step, 0.0], [gap - step, 0.0]])
        skin = check(model)
        assert (skin.searches == 1) == (share < 1.0), share
        model.particles.assign("position", [[0.0, 0.0], [gap, 0.0]])
        model.space.skin.forget()
        model.space.take_down()
        model.space.skin.searches = 1


def test_one_agent_that_jumps_and_one_that_creeps_away():
    draw = np.random.default_rng(1)
    model = scene(draw.random((80, 2)))
    check(model)
    for _ in range(40):  # each step is far below the limit, their sum is not
        model.particles.array("position")[7] += 0.01 * RADIUS
        skin = check(model)
    assert 2 <= skin.searches <= 6
    assert skin.spared >= 30
    model.particles.agents[3].position = (0.9, 0.9)
    assert check(model).searches > 2


def test_agents_that_come_go_and_change_rows_are_searched_for_anew():
    model = scene(np.random.default_rng(2).random((50, 2)))
    check(model)
    AgentParticle(model, position=(0.5, 0.5))
    assert check(model).searches == 2
    model.particles.agents[0].remove()
    assert check(model).searches == 3
    model.space.tidy()
    check(model)
    assert check(model).spared > 0


def test_a_radius_that_grows_uses_the_skin_up():
    model = scene(np.random.default_rng(3).random((60, 2)))
    check(model)
    model.space.core_radius = 1.2 * RADIUS
    model.particles.array("position")[:] += 0.01 * RADIUS
    assert check(model).searches == 1
    model.space.core_radius = 1.31 * RADIUS
    assert check(model).searches == 2


@pytest.mark.parametrize("evaluation", ["gathered", "scattered", "stored"])
@pytest.mark.parametrize("tier", ["compiled", "agents"])
def test_a_skin_changes_no_result(evaluation, tier):
    models = [
        build(120, agent_class=Curious, evaluation=evaluation, tier=tier, skin=skin, dt=0.02)
        for skin in (0.0, 0.5)
    ]
    for model in models:
        for _ in range(6):
            model.step()
    assert models[1].space.skin.spared >= 3
    for name in models[0].particles.names:
        a, b = (column_by_id(model, name) for model in models)
        assert np.abs(a - b).max() <= 1e-11 * np.abs(a).max(), name


def test_a_place_that_is_not_a_number_is_no_place_nearby():
    before = np.zeros((3, 2))
    assert not furthest(np.array([[0.0, 0.0], [np.nan, 0.0], [0.1, 0.0]]), before) <= 1.0


@pytest.mark.parametrize("skin", [-0.1, 1.5, np.nan])
def test_a_bad_skin_is_refused(skin):
    with pytest.raises(ValueError, match="skin is"):
        scene(np.zeros((1, 2)), skin)


def test_explain_tells_what_the_skin_has_spared():
    def told(domain=None):
        model = scene(np.random.default_rng(4).random((60, 2)), domain=domain, terms=[density])
        check(model)
        check(model)
        return dict(explain(model))["perceive"]

    assert "a skin of 30%: 1 searches made, 1 spared" in told()
    assert "no search reused: images" in told(Periodic((0, 0), (1, 1)))
