"""Scenes of animals: what Figures 9 and 10 rest on, in small."""

import numpy as np
import pytest

from apmethod import (
    Animal,
    AnimalModel,
    ClosestGroup,
    Column,
    Life,
    OldestGroup,
    explain,
    load_scene,
)
from apmethod.bench.aggregation import gatherings
from apmethod.skills.groups import Group, GroupEvent, Groups


def test_a_run_keeps_the_animals_and_names_its_skills():
    model = AnimalModel(particles=400, side=20.0, diffusivity=0.01, rng=3)
    for _ in range(150):
        model.step()
        sizes = sum(group.size for group in model.groups.current)
        assert sizes + (model.particles.group == -1).sum() == 400
    assert len(model.groups.current) > 0
    assert "SignalField" in dict(explain(model))
    assert model.procedure.seconds["skills"] > 0.0


def test_a_step_is_shorter_where_the_signal_is_steep():
    model = AnimalModel(particles=300, side=20.0, rng=1)
    assert model.next_dt() == model.dt
    model.particles.assign("position", np.full((300, 2), 10.0) + 0.1)
    for _ in range(10):
        model.step()
    assert model.next_dt() == pytest.approx(0.7 * model.largest_dt())
    assert model.next_dt() < model.dt


def test_perception_never_falls_below_the_floor():
    for floor, least in ((0.0, 1.0), (2.0, 2.0)):
        model = AnimalModel(particles=400, side=20.0, diffusivity=0.01, floor=floor, rng=1)
        radii = []
        for _ in range(150):
            model.step()
            radii.append(model.space.core_radius)
        assert radii[0] == 3.0
        assert min(radii) == least


def test_seeds_are_compared_in_pairs():
    values = {0.1: [3, 5, 4], 0.01: [9, 10, 11]}
    rows = [
        {"figure": "figure 9", "diffusivity": d, "groups": value}
        for d in values
        for value in values[d]
    ]
    found = gatherings.compared(rows, "figure 9", "groups")
    assert (found["first_mean"], found["second_mean"], found["difference"]) == (4.0, 10.0, 6.0)
    assert found["half_width"] == pytest.approx(4.302653 * np.std([6, 5, 7], ddof=1) / np.sqrt(3))
    assert found["certain"]


def test_fewer_groups_at_the_higher_diffusivity():
    rows, models = gatherings.runs("figure 9", range(2), until=40.0)
    found = gatherings.compared(rows, "figure 9", "groups")
    assert found["first_mean"] < 0.5 * found["second_mean"]
    assert [model.elapsed for model in models] == [40.0, 40.0]


@pytest.mark.parametrize("strategy", ["mixed", "youngest"])
def test_strategies_and_leaders(strategy):
    model = load_scene("group_strategies")(particles=300, strategy=strategy, leaders=5, rng=1)
    model.step()
    given = set(model.particles.strategy[:300].tolist())
    assert given == (set(range(6)) if strategy == "mixed" else {4})


class Scout(Animal):
    sight = Column(start=2.0)
    view = Column(start=0.0)


def test_what_animals_see_is_told_once_for_signal_and_groups():
    """Half-blind animals go to near groups only, and always ahead."""
    model = AnimalModel(
        particles=400, side=20.0, diffusivity=0.01, agent_class=Scout, sight="sight", view="view",
        strategies=[ClosestGroup], skills=[Life()], rng=1,
    )  # fmt: skip
    for _ in range(60):
        model.step()
    goal, heading = model.particles.goal, model.particles.heading
    assert 0 < (goal != 0.0).any(axis=1).sum() < 400
    before = heading.copy()
    model.step()
    assert ((model.particles.goal * before).sum(axis=1) >= -1e-12).all()


@pytest.mark.parametrize(
    ("scene", "options", "message"),
    [
        ("group_strategies", {"strategy": "best"}, "strategy is 'best'; it must be one of grad"),
        ("group_strategies", {"leaders": -1}, "leaders is -1"),
        ("aggregation", {"followed": 2.5}, "followed is 2.5"),
        ("aggregation_perception", {"floor": 0.6}, "core radius is 30"),
        ("aggregation_perception", {"view": 0}, "view is 0; it must be above 0"),
        ("aggregation_perception", {"view": "wide"}, "view is 'wide'; it must be above 0"),
        ("aggregation_perception", {"view": 90, "sensing": "nearest"}, "needs 'vicinity'"),
    ],
)
def test_scenes_refuse_bad_input(scene, options, message):
    with pytest.raises(ValueError, match=message):
        load_scene(scene)(particles=10, **options)


def test_groups_of_some_age_become_one_agent():
    model = load_scene("aggregation")(diffusivity=0.01, gather_after=5.0, rng=1)
    while model.elapsed < 25.0:
        model.step()
        numbers = model.diagnostics()
        assert numbers["mass"] == 2500.0
        assert numbers["agents"] - numbers["aggregates"] + numbers["aggregated"] == 2500
    assert numbers["aggregates"] > 3


@pytest.mark.parametrize("tier", ["compiled", "agents"])
def test_all_on_one_point_with_every_skill(tier):
    model = AnimalModel(
        particles=40, side=10.0, strategies=[OldestGroup], skills=[Life()], dt=0.25, rng=1,
        gather=lambda group: group.age >= 1.0,
        dissolve=lambda one: one.model.elapsed >= one.since + 1.0, tier=tier,
    )  # fmt: skip
    model.particles.assign("position", (3.3, 4.1))
    sizes = set()
    for _ in range(12):
        model.step()
        sizes.add(len(model.particles))
        assert all(np.isfinite(model.particles.array(name)).all() for name in model.particles.names)
    assert sizes == {1, 40}


def test_nobody_and_one_animal():
    for count in (0, 1):
        model = AnimalModel(particles=count, side=20.0)
        model.step()
        assert model.groups.current == ()
    assert isinstance(model.particles.agents[0], Animal)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"particles": -1}, "particles is -1"),
        ({"diffusivity": -0.1}, "diffusivity is -0.1"),
        ({"production": -0.1}, "production is -0.1"),
        ({"signal_diffusivity": -0.1}, "signal_diffusivity is -0.1"),
        ({"evaporation": -0.1}, "evaporation is -0.1"),
        ({"patch": 1e-9}, "makes 4e\\+20 patches"),
        ({"side": 20.3}, "patch is 1 and the domain is 20.3 long"),
        ({"core_radius": 0.5}, "patch is 1 and the core radius is 0.5"),
        ({"floor": -1.0}, "floor is -1.0"),
        ({"floor": 11.0}, "core radius is 11"),
        ({"near": 0.0}, "near is 0.0"),
        ({"dt": 100.0}, "dt is 100, which is unstable"),
    ],
)
def test_bad_input_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        AnimalModel(**{"particles": 100, "side": 20.0} | options)


def test_lasting_groups_are_dated_by_their_birth_and_by_their_last_event():
    groups = Groups(1.0)
    groups.current = tuple(
        Group(identity, born, age=0.0, size=10, mass=10.0, x=0.0, y=0.0, radius=1.0)
        for identity, born in ((1, 2.0), (3, 6.0))
    )
    groups.events = [
        GroupEvent(2.0, "birth", 1), GroupEvent(3.0, "birth", 2), GroupEvent(5.0, "merge", 2, 1),
        GroupEvent(6.0, "split", 3, 4), GroupEvent(9.0, "end", 4),
    ]  # fmt: skip
    dates = gatherings.lasting_groups(groups, elapsed=10.0)
    assert dates == {"born": 4.0, "unaltered_since": 5.5}
    groups.current = ()
    none = gatherings.lasting_groups(groups, elapsed=10.0)
    assert none == {"born": 10.0, "unaltered_since": 10.0}


def test_the_settling_time_counts_animals_not_events():
    times, late = [0.0, 2.0, 3.0, 10.0], [[0, 0, 1, -1], [0, 0, 1, 1], [0, 0, 0, 0], [0, 0, 0, 0]]
    assert gatherings.settling_time(times, late) == 0.5 * 3.0
    at_once = [[-1] * 4, [-1] * 4, [5] * 4, [5] * 4]
    assert gatherings.settling_time(times, at_once) == 3.0
    assert gatherings.settling_time(times, [[-1] * 4] * 4) == 10.0
