"""Animals go to the group that their strategy prefers."""

import numpy as np
import pytest

from apmethod import (
    Animal,
    ClosestGroup,
    Column,
    Diffusion,
    FarthestGroup,
    Groups,
    HighestGradient,
    Life,
    OldestGroup,
    ParticleModel,
    Periodic,
    Pursue,
    SignalField,
    Strategies,
    Strategy,
    YoungestGroup,
)

CHOICES = (HighestGradient, ClosestGroup, FarthestGroup, OldestGroup, YoungestGroup)
SIDE = 40.0


class Shy(Animal):
    courage = Column(start=9.0)


class SmallestWithin(Strategy):
    """The smallest group among those not too far for the animal's courage."""

    reads = ("courage",)

    def score(agent, group):
        return -group.size if group.distance < agent.courage else -1e9


class Hawk(Animal):
    sight = Column(start=1e9)
    view = Column(start=-1.0)


def valley(choices=CHOICES, *, agent_class=Animal, speed=0.5, sight=None, view=None, **options):
    """An old group in the west, a young large one in the east, and singles in between."""
    signal = SignalField(1.0, production=0.3, diffusivity=0.2, evaporation=0.1)
    groups = Groups(1.0, 5)
    strategies = Strategies(groups, choices, sight=sight, view=view)
    model = ParticleModel(
        agent_class,
        core_radius=3.0,
        domain=Periodic((0, 0), (SIDE, SIDE)),
        laws=[Diffusion(0.01), Pursue(signal, 0.1, speed)],
        skills=[signal, groups, strategies, Life()],
        dt=0.1,
        rng=1,
        **options,
    )
    draw = np.random.default_rng(5)
    agent_class.create_agents(model, 15, position=(10, 20) + 0.3 * draw.normal(size=(15, 2)))
    model.step()
    agent_class.create_agents(model, 25, position=(24, 20) + 0.3 * draw.normal(size=(25, 2)))
    singles = [(15.0, 20.0), (19.5, 14.0), (5.0, 20.0)]
    agent_class.create_agents(model, 3, position=singles)
    model.step()
    return model, groups, strategies


def singles(model):
    return model.particles.agents[-3:]


def test_each_strategy_heads_for_its_group():
    for choice, targets in {
        ClosestGroup: (10, 24, 10),
        FarthestGroup: (24, 10, 24),
        OldestGroup: (10, 10, 10),
        YoungestGroup: (24, 24, 24),
    }.items():
        model, _, strategies = valley()
        strategies.give(singles(model), choice)
        before = [agent.position for agent in singles(model)]
        model.step()
        for agent, began, target in zip(singles(model), before, targets, strict=True):
            x, y = model.space.domain.displacement((target, 20), began)
            expected = np.array([x, y]) / np.hypot(x, y)
            np.testing.assert_allclose(agent.goal, expected, atol=0.05)
            # The way it goes is its speed's, but for the push of others near by.
            went = np.array(model.space.domain.displacement(agent.position, began))
            assert went @ expected == pytest.approx(0.5 * model.dt, rel=0.2)


def test_who_is_in_its_group_or_follows_the_gradient_has_no_goal():
    model, _, strategies = valley()
    strategies.give(model.agents, OldestGroup)
    strategies.give(singles(model), HighestGradient)
    model.step()
    goals = model.particles.goal
    assert (goals[:15] == 0.0).all()
    assert (goals[15:40] != 0.0).any(axis=1).all()
    assert (goals[40:] == 0.0).all()


def test_a_strategy_of_ones_own_reads_columns():
    model, _, strategies = valley((HighestGradient, SmallestWithin), agent_class=Shy)
    strategies.give(singles(model), SmallestWithin)
    singles(model)[1].courage = 8.0
    model.step()
    assert singles(model)[0].goal[0] < -0.99
    assert singles(model)[1].goal[0] > 0.5
    number = strategies.number(SmallestWithin)
    assert Shy.create_agents(model, 2, strategy=number).get("strategy") == [number] * 2


def test_both_tiers_choose_alike():
    found = []
    for tier in ("compiled", "agents"):
        model, _, strategies = valley(tier=tier)
        for k, choice in enumerate(CHOICES):
            strategies.give(model.particles.agents[k :: len(CHOICES)], choice)
        for _ in range(3):
            model.step()
        found.append((model.particles.position, model.particles.goal))
    for ours, theirs in zip(*found, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-13)


def test_an_animal_goes_for_the_best_group_that_it_sees():
    """The farthest is east; one sees no farther than 6, one looks west, one sees all."""
    model, _, strategies = valley(agent_class=Hawk, sight="sight", view="view")
    strategies.give(singles(model), FarthestGroup)
    positions = model.particles.position.copy()
    positions[-3:] = (15.0, 20.0)
    model.particles.assign("position", positions)
    near, behind, all_round = singles(model)
    near.sight, behind.view, behind.heading = 6.0, np.cos(0.3), (-2.0, 0.0)
    model.step()
    for agent, ahead in ((near, -1.0), (behind, -1.0), (all_round, 1.0)):
        np.testing.assert_allclose(agent.goal, (ahead, 0.0), atol=0.05)
    near.sight = 3.0
    model.step()
    assert near.goal.tolist() == [0.0, 0.0]


def test_who_sees_nothing_sees_the_group_it_is_in():
    model, _, strategies = valley(agent_class=Hawk, sight="sight", view="view")
    strategies.give(model.agents, YoungestGroup)
    model.particles.assign("sight", 0.0)
    model.step()
    in_group = model.particles.group >= 0
    assert in_group.sum() == 40
    assert (model.particles.goal == 0.0).all()


def test_both_tiers_see_alike():
    found = []
    for tier in ("compiled", "agents"):
        model, _, strategies = valley(agent_class=Hawk, sight="sight", view="view", tier=tier)
        draw = np.random.default_rng(7)
        for k, choice in enumerate(CHOICES):
            strategies.give(model.particles.agents[k :: len(CHOICES)], choice)
        model.particles.assign("sight", draw.uniform(2.0, 20.0, 43))
        model.particles.assign("view", draw.uniform(-1.0, 0.5, 43))
        for _ in range(3):
            model.step()
        found.append((model.particles.position, model.particles.goal))
    assert 0 < (found[0][1] != 0.0).any(axis=1).sum() < 43
    for ours, theirs in zip(*found, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-13)


class Leader(Animal):
    """Goes its own way, in Python."""

    calls = 0

    def dynamics(self):
        Leader.calls += 1
        return super().dynamics() + np.array([0.2, 0.0])


def test_leaders_cost_one_python_call_each():
    signal = SignalField(1.0, production=0.3, diffusivity=0.2, evaporation=0.1)
    groups = Groups(1.0, 5)
    model = ParticleModel(
        [Animal, Leader],
        core_radius=3.0,
        domain=Periodic((0, 0), (SIDE, SIDE)),
        laws=[Diffusion(0.01), Pursue(signal, 0.1, 0.5)],
        skills=[signal, groups, Strategies(groups, CHOICES)],
        dt=0.1,
        rng=1,
    )
    draw = np.random.default_rng(2)
    Animal.create_agents(model, 1000, position=SIDE * draw.random((1000, 2)))
    leaders = Leader.create_agents(model, 50, position=SIDE * draw.random((50, 2)))
    Leader.calls = 0
    before = {leader: leader.position for leader in leaders}
    model.step()
    assert Leader.calls == 50
    moved = [model.space.domain.displacement(one.position, before[one])[0] for one in leaders]
    assert np.mean(moved) == pytest.approx(0.2 * model.dt, rel=0.2)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda g: Strategies(g, []), ValueError, "choices is empty"),
        (lambda g: Strategies(g, ["closest"]), TypeError, "subclass of Strategy"),
    ],
)
def test_bad_input_is_refused(make, error, message):
    with pytest.raises(error, match=message):
        make(Groups(1.0))


def test_groups_must_come_first():
    groups = Groups(1.0)
    with pytest.raises(ValueError, match="name the groups first"):
        ParticleModel(Animal, core_radius=2.0, dt=1.0, skills=[Strategies(groups, CHOICES), groups])


def test_a_column_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="Strategies reads column 'eyes'"):
        valley(sight="eyes")


def test_an_unknown_strategy_is_refused():
    model, _, strategies = valley()
    with pytest.raises(ValueError, match="not among the scene's strategies, HighestGradient"):
        strategies.give(model.agents, SmallestWithin)
