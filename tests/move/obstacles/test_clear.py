"""Who is told to have nothing to meet has nothing to meet, and far obstacles change no bit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import (
    AgentParticle,
    Bounded,
    Column,
    Law,
    Mirrored,
    Obstacles,
    ParticleModel,
    Periodic,
    disc,
    square,
)
from apmethod.errors import StepFailed
from apmethod.move.obstacles.clear import box_clear
from apmethod.move.obstacles.tree import LEAF
from obstacle_samples import assert_as_brute_force, random_obstacles


class Walker(AgentParticle):
    push = Column(2)


PUSH = Law("push", lambda agent, p: agent.push, reads=("push",))


def walkers(obstacles, positions, pushes, **options):
    model = ParticleModel(Walker, core_radius=0.1, laws=[PUSH], obstacles=obstacles, **options)
    Walker.create_agents(model, len(positions), position=positions, push=pushes)
    return model


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_a_box_is_clear_if_all_leaves_that_it_touches_are_empty(seed):
    draw = np.random.default_rng(seed)
    tree = Obstacles(random_obstacles(draw, moving=True)).tree
    leaves = np.flatnonzero(tree.axis == LEAF)
    planes = tree.plane[tree.axis != LEAF]
    for _ in range(20):
        low = draw.random(2)
        high = low + 10.0 ** draw.uniform(-4, 0, 2)
        if draw.random() < 0.3 and len(planes):  # on a plane
            low[0] = high[0] = draw.choice(planes)
        limits = tree.limits[leaves]
        touched = leaves[((limits[:, :2] <= high) & (low <= limits[:, 2:])).all(axis=1)]
        empty = (tree.first[touched] == tree.last[touched]).all()
        assert box_clear(tree, *low, *high) == empty
    assert not box_clear(tree, np.nan, 0.0, 1.0, 1.0)


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("together", [1, 300])
def test_who_meets_nothing_has_no_wall_on_the_way(moving, together):
    draw = np.random.default_rng(together)
    obstacles = Obstacles(random_obstacles(draw, moving), squeezed="remove")
    model = ParticleModel(Walker, core_radius=0.1, dt=0.1, obstacles=obstacles)
    starts = draw.random((3000, 2))
    starts = starts[~obstacles.occupied(starts)]
    Walker.create_agents(model, len(starts), position=starts)
    model.motion.begin(0.0, 0.1)
    ends = starts + 0.02 * draw.normal(size=starts.shape)
    free = np.ones(len(starts), bool)
    for first in range(0, len(starts), together):
        rows = np.arange(first, min(first + together, len(starts)))
        free[obstacles._who_may_meet(rows, starts, ends, in_python=False)] = False
    assert 0.1 < free.mean() < 0.98
    hits = assert_as_brute_force(obstacles, starts[free], ends[free])[1]
    assert (hits == -1).all()
    assert not obstacles.near(ends[free], 0.5 * obstacles.clearance).any()


def around(middle, count=40):
    """Discs on a circle of radius 3."""
    angles = 2.0 * np.pi * np.arange(count) / count
    return [disc(middle + 3.0 * np.array([np.cos(a), np.sin(a)]), 0.1) for a in angles]


@pytest.mark.parametrize(
    "domain",
    [None, Bounded((0, 0), (9, 9)), Mirrored((0, 0), (9, 9)), Periodic((0, 0), (9, 9))],
    ids=["open", "bounded", "mirrored", "periodic"],
)
@pytest.mark.parametrize("tier", ["compiled", "agents"])
def test_far_obstacles_change_no_bit(domain, tier):
    draw = np.random.default_rng(1)
    count = 1000 if tier == "compiled" else 60
    positions = draw.uniform(3.5, 5.5, (count, 2))  # over several empty domains
    pushes = draw.normal(size=(count, 2))
    for integrator in ("euler", "midpoint"):
        with_far, without = (
            walkers(
                obstacles, positions, pushes, domain=domain, dt=0.05, integrator=integrator,
                tier=tier,
            )
            for obstacles in (around(np.array([4.5, 4.5])), None)
        )  # fmt: skip
        for _ in range(3):
            with_far.step()
            without.step()
        assert (with_far.particles.position == without.particles.position).all()
        assert with_far.obstacles.skipped == 1.0


@pytest.mark.parametrize("tier", ["compiled", "agents"])
def test_planes_follow_late_and_in_time(tier):
    """An obstacle comes from afar: the same happens as if planes had followed all the way."""
    draw = np.random.default_rng(2)
    count = 400 if tier == "compiled" else 30
    positions, pushes = draw.random((count, 2)), 0.2 * draw.normal(size=(count, 2))
    late, always = (
        walkers(
            [
                square((-9.0, 0.5), 0.6, velocity=(2.0, 0.0), name="comes"),
                *(square((-5.0 + k, 4.0), 0.5) for k in range(5)),
            ],
            positions, pushes, dt=0.1, tier=tier,
        )
        for _ in range(2)
    )  # fmt: skip
    behind = []
    for _ in range(60):
        late.step()
        always.step()
        behind.append(late.obstacles._behind)
        assert always.obstacles.tree
        assert (late.particles.position == always.particles.position).all()
        assert late.obstacles.skipped >= always.obstacles.skipped
    assert behind[0]
    assert not all(behind)
    assert late.obstacles.rebuilds <= always.obstacles.rebuilds
    # It has swept along whom it met.
    walked = positions + 6.0 * pushes
    assert np.abs(late.particles.position - walked).max() > 0.1
    starts = draw.uniform(-6.0, 6.0, (300, 2))
    assert_as_brute_force(late.obstacles, starts, draw.uniform(-6.0, 6.0, (300, 2)))


def test_who_goes_nowhere_fails_the_step_far_from_walls():
    pushes = np.zeros((300, 2))
    pushes[7] = 1e308
    model = walkers(around(np.zeros(2)), np.zeros((300, 2)), pushes, dt=100.0)
    with np.errstate(over="ignore"), pytest.raises(StepFailed, match="position"):
        model.step()
    assert (model.particles.position == 0.0).all()


def test_agents_that_do_not_move_are_swept_along_all_the_same():
    class Rests(Walker):
        def move(self):
            pass

    obstacle = square((-1.0, 0.0), 1.0, velocity=(1.0, 0.0))
    model = ParticleModel([Walker, Rests], core_radius=0.1, dt=1.0, obstacles=[obstacle])
    Walker.create_agents(model, 1, position=[(5.0, 5.0)])
    Rests.create_agents(model, 1, position=[(0.0, 0.0)])
    model.step()
    assert model.particles.position[1, 0] == pytest.approx(1.0, abs=1e-6)  # bounced
