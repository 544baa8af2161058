"""Groups become aggregates and dissolve again, and nothing is lost."""

import numpy as np
import pytest

from apmethod import (
    Aggregate,
    Animal,
    Column,
    DescriptionScale,
    Groups,
    InertialParticle,
    Law,
    ParticleModel,
    Periodic,
    SignalField,
)

SIDE = 20.0


class Bee(Animal, InertialParticle):
    nectar = Column(start=1.0)


class Guest(Bee):
    pass


class Swarm(Aggregate, Bee):
    pass


def hive(gather, dissolve, seed=1):
    """Two clusters of bees, one across a corner, that fly at random velocities."""
    signal = SignalField(1.0, production=0.5, diffusivity=0.1, evaporation=0.1, by="nectar")
    groups = Groups(1.0, 5)
    scale = DescriptionScale(groups, gather, dissolve, Swarm)
    model = ParticleModel(
        [Bee, Guest, Swarm],
        core_radius=2.0,
        domain=Periodic((0, 0), (SIDE, SIDE)),
        laws=[Law("no force", lambda agent, p: (0.0, 0.0))],
        integrator="velocity_verlet",
        skills=[signal, groups, scale],
        dt=0.1,
        rng=seed,
    )
    draw = np.random.default_rng(seed)
    for cls, centre in ((Bee, (0.0, 0.0)), (Guest, (0.0, 0.0)), (Bee, (10.0, 10.0))):
        cls.create_agents(
            model, 12, position=(centre + 0.3 * draw.normal(size=(12, 2))) % SIDE,
            mass=draw.uniform(0.5, 2.0, 12), nectar=draw.uniform(0.0, 2.0, 12),
            velocity=(0.4, 0.1) + 0.01 * draw.normal(size=(12, 2)),
        )  # fmt: skip
    return model, groups, scale


def kept(model):
    """Mass, momentum, production and number of all agents."""
    table, scale = model.particles, model.skills[-1]
    away = sum(aggregate.size - 1 for aggregate in scale.aggregates)
    momentum = table.mass @ table.velocity
    return [table.mass.sum(), *momentum, table.nectar.sum(), len(table) + away]


def test_nothing_is_lost_in_gathering_and_dissolving():
    model, _groups, scale = hive(
        lambda group: group.age >= 0.3 and group.born < 0.5,
        lambda swarm: swarm.model.elapsed > swarm.since + 0.5,
    )
    before, ids = kept(model), sorted(agent.unique_id for agent in model.agents)
    sizes = set()
    for _ in range(15):
        model.step()
        sizes.add(len(model.particles))
        np.testing.assert_allclose(kept(model), before, rtol=1e-13)
        assert len(model.agents) == len(model.particles)
    assert sizes == {36, 2}
    assert scale.aggregates == []
    assert sorted(agent.unique_id for agent in model.agents) == ids
    assert len(model.agents_by_type[Guest]) == 12


def test_members_stand_around_it_as_they_stood_around_their_centre():
    model, groups, scale = hive(lambda group: False, lambda swarm: False)
    _first, second = groups.find()
    bees = list(groups.members(second))
    was = np.array([bee.position for bee in bees])
    swarm = scale.gather(second)
    assert swarm.size == 12
    assert swarm.mass == pytest.approx(second.mass)
    np.testing.assert_allclose(swarm.position, (second.x, second.y))
    for _ in range(10):
        model.step()
    assert scale.diagnostics() == {"aggregates": 1, "aggregated": 12}
    moved = swarm.position - (second.x, second.y)
    np.testing.assert_allclose(moved, model.elapsed * swarm.velocity, rtol=1e-12)
    assert scale.dissolve(swarm) == bees
    np.testing.assert_allclose([bee.position for bee in bees], was + moved, rtol=1e-12)
    model.step()
    assert len(groups.current) == 2


def test_what_it_gained_is_shared_out():
    _model, groups, scale = hive(lambda group: False, lambda swarm: False)
    group = groups.find()[0]
    masses = [bee.mass for bee in groups.members(group)]
    swarm = scale.gather(group)
    swarm.mass *= 1.5
    np.testing.assert_allclose(
        [bee.mass for bee in scale.dissolve(swarm)], np.multiply(1.5, masses)
    )


def test_an_aggregate_may_be_gathered_again():
    model, groups, scale = hive(lambda group: False, lambda swarm: False)
    before = kept(model)
    swarm = scale.gather(groups.find()[1])
    Bee.create_agents(model, 6, position=swarm.position, mass=0.0)
    larger = scale.gather(groups.find()[-1])
    assert larger.size == 18
    np.testing.assert_allclose(kept(model)[:3], before[:3], rtol=1e-13)
    assert scale.diagnostics() == {"aggregates": 1, "aggregated": 18}
    assert swarm in scale.dissolve(larger)
    assert scale.aggregates == [swarm]
    scale.dissolve(swarm)
    np.testing.assert_allclose(kept(model)[:3], before[:3], rtol=1e-13)
    assert len(model.particles) == 36 + 6


def test_a_scene_must_name_the_groups_and_the_class():
    groups = Groups(1.0)
    scale = DescriptionScale(groups, lambda group: True)
    with pytest.raises(ValueError, match="groups is not among"):
        ParticleModel([Animal, Aggregate], core_radius=1.0, dt=1.0, skills=[scale])
    with pytest.raises(ValueError, match="not among the model's agent_classes"):
        ParticleModel(Animal, core_radius=1.0, dt=1.0, skills=[groups, scale])
