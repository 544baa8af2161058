"""Groups are those of scikit-learn's DBSCAN, and keep their identities."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.cluster import DBSCAN

from apmethod import (
    Animal,
    Domain,
    Groups,
    Law,
    Obstacles,
    Open,
    ParticleModel,
    Periodic,
    Polyline,
    clusters,
    set_threads,
)
from apmethod.compile.threads import threads
from obstacle_samples import by_brute_force, random_obstacles


def dbscan(positions, radius, least, domain=None):
    """The same clusters by scikit-learn, of distances taken pair by pair."""
    apart = np.abs(positions[:, None] - positions)
    for axis, period in enumerate((domain or Open()).periods):
        if period:
            apart[..., axis] = np.minimum(apart[..., axis], period - apart[..., axis])
    search = DBSCAN(eps=radius, min_samples=least, metric="precomputed")
    return search.fit(np.hypot(apart[..., 0], apart[..., 1])).labels_


@settings(max_examples=40, deadline=None)
@given(
    st.integers(1, 300), st.floats(0.02, 0.4), st.integers(1, 12), st.booleans(),
    st.floats(0.01, 0.3), st.integers(0, 2**31),
)  # fmt: skip
def test_groups_are_those_of_dbscan(count, radius, least, periodic, width, seed):
    draw = np.random.default_rng(seed)
    centres = draw.random((6, 2))
    positions = (centres[draw.integers(0, 6, count)] + width * draw.normal(size=(count, 2))) % 1.0
    domain = Periodic((0, 0), (1, 1)) if periodic else Open()
    expected = dbscan(positions, radius, least, domain)
    np.testing.assert_array_equal(clusters(positions, radius, least, domain), expected)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.03, 0.2), st.integers(1, 6), st.booleans())
def test_walls_separate(seed, radius, least, periodic):
    draw = np.random.default_rng(seed)
    obstacles = Obstacles(random_obstacles(draw, moving=False))
    positions = draw.random((200, 2))
    positions = positions[~obstacles.occupied(positions)]
    domain = Periodic((-0.1, -0.1), (1.1, 1.1)) if periodic else Open()
    i, j = (part.ravel() for part in np.indices((len(positions),) * 2))
    apart = positions[i] - positions[j]
    if periodic:
        apart -= 1.2 * np.round(apart / 1.2)
    near = np.flatnonzero(np.hypot(*apart.T) <= radius)
    cut = np.zeros(len(i), bool)
    moves = [(x, y) for x in (-1.2, 0.0, 1.2) for y in (-1.2, 0.0, 1.2)] if periodic else [(0, 0)]
    for move in moves:  # every line of sight, tried on every wall
        begin = positions[i[near]] + move
        cut[near] |= by_brute_force(obstacles, begin, begin - apart[near])[1] >= 0
    far = np.where(cut & (i != j), 9.0, np.hypot(*apart.T)).reshape(len(positions), -1)
    far = np.maximum(far, far.T)
    search = DBSCAN(eps=radius, min_samples=least, metric="precomputed")
    found = clusters(positions, radius, least, domain, obstacles)
    np.testing.assert_array_equal(found, search.fit(far).labels_)


@pytest.mark.parametrize(("contributions", "count"), [("mirrored", 2), ("through", 1)])
def test_animals_on_both_sides_of_a_wall_are_two_groups(contributions, count):
    draw = np.random.default_rng(1)
    for core_radius in (0.4, 2.0):
        fence = Obstacles([Polyline([(0.0, -9.0), (0.0, 9.0)])], contributions=contributions)
        groups = Groups(0.3, 4)
        model = ParticleModel(
            Animal, core_radius=core_radius, skills=[groups], dt=1.0, obstacles=fence
        )
        Animal.create_agents(model, 60, position=0.2 * draw.normal(size=(60, 2)))
        assert len(groups.find()) == count


def test_an_agent_exactly_at_the_radius_is_near():
    positions = np.stack(np.meshgrid(np.arange(5.0), np.arange(5.0)), -1).reshape(-1, 2)
    assert set(clusters(positions, 1.0, 5)) == {0, -1}  # the corners have no core agent
    np.testing.assert_array_equal(clusters(positions, 1.0, 5), dbscan(positions, 1.0, 5))


def test_nobody_and_all_on_one_point():
    assert clusters(np.empty((0, 2)), 1.0, 3).tolist() == []
    assert clusters(np.zeros((7, 2)), 1.0, 7).tolist() == [0] * 7
    assert clusters(np.zeros((7, 2)), 1.0, 8).tolist() == [-1] * 7


def test_threads_change_no_label():
    positions, before, found = np.random.default_rng(0).random((30_000, 2)), threads(), []
    try:
        for count in (1, 2, 3):
            set_threads(count)
            found.append(clusters(positions, 0.006, 6))
    finally:
        set_threads(before)
    assert len(set(found[0])) > 100
    assert all(np.array_equal(other, found[0]) for other in found[1:])


# -- followed over time ----------------------------------------------------------------


def flock(places, *, groups=None, core_radius=1.0, size=12, **options):
    """A model with one dense cluster of ``size`` animals at each of some places."""
    groups = groups or Groups(0.5, 4)
    model = ParticleModel(Animal, core_radius=core_radius, skills=[groups], dt=1.0, **options)
    draw = np.random.default_rng(3)
    for place in places:
        Animal.create_agents(model, size, position=place + 0.1 * draw.normal(size=(size, 2)))
    return model, groups


def shift(model, first, last, by):
    """Move the agents of rows first to last."""
    positions = model.particles.position.copy()
    positions[first:last] += by
    model.particles.assign("position", positions)


def happened(groups):
    return [(event.kind, event.group, event.other) for event in groups.events]


def test_a_group_keeps_its_identity_while_it_moves():
    model, groups = flock([(0, 0), (5, 5)])
    groups.find()
    assert [group.identity for group in groups.current] == [0, 1]
    for _ in range(5):
        shift(model, 0, 12, (0.7, 0.0))
        model.step()
    one, other = groups.find()
    assert (one.identity, one.size, one.born, one.age) == (0, 12, 0.0, 5.0)
    assert (one.x, one.y) == pytest.approx(model.particles.position[:12].mean(axis=0))
    assert other.mass == 12.0
    apart = model.particles.position[12:] - (other.x, other.y)
    assert other.radius == pytest.approx(np.sqrt((apart**2).sum(axis=1).mean()))
    assert happened(groups) == [("birth", 0, None), ("birth", 1, None)]
    assert set(groups.members(one)) == set(model.particles.agents[:12])


def test_the_larger_part_of_a_split_and_of_a_merge_goes_on():
    model, groups = flock([(0, 0), (0.2, 0)], size=9)
    groups.find()
    shift(model, 0, 7, (4.0, 0.0))
    groups.find()
    assert happened(groups)[1:] == [("split", 1, 0)]
    assert {group.identity: group.size for group in groups.current} == {0: 11, 1: 7}
    shift(model, 0, 7, (-4.0, 0.0))
    groups.find()
    assert happened(groups)[2:] == [("merge", 1, 0)]
    assert [group.size for group in groups.current] == [18]


def test_a_group_that_scatters_ends():
    model, groups = flock([(0, 0)])
    groups.find()
    model.particles.assign("position", [(3.0 * k, 0.0) for k in range(12)])
    groups.find()
    assert happened(groups)[1:] == [("end", 0, None)]
    assert groups.current == ()
    assert (model.particles.group == -1).all()
    assert model.particles.agents[0].group == -1


def test_an_agent_that_joins_or_leaves_the_model_is_no_trouble():
    model, groups = flock([(0, 0), (5, 5)])
    groups.find()
    for agent in model.particles.agents[:3]:
        agent.remove()
    Animal(model, position=(5, 5))
    model.step()
    assert [(group.identity, group.size) for group in groups.find()] == [(0, 9), (1, 13)]


def test_a_group_across_a_periodic_side_has_its_centre_there():
    draw = np.random.default_rng(0)
    positions = (np.array([0.0, 5.0]) + 0.2 * draw.normal(size=(40, 2))) % 10.0
    groups = Groups(0.5, 4)
    model = ParticleModel(
        Animal, core_radius=1.0, skills=[groups], dt=1.0, domain=Periodic((0, 0), (10, 10))
    )
    Animal.create_agents(model, 40, position=positions)
    (group,) = groups.find()
    assert min(group.x, 10.0 - group.x) < 0.2
    assert group.y == pytest.approx(5.0, abs=0.2)
    assert group.radius < 0.5


@pytest.mark.parametrize("radius", [0.5, 0.9])
def test_mirror_images_are_in_no_group(radius):
    groups = Groups(radius, 4)
    domain = Domain((0, 0), (10, 10), "mirrored")
    model = ParticleModel(Animal, core_radius=1.0, skills=[groups], dt=1.0, domain=domain)
    Animal.create_agents(model, 3, position=[(0.0, 0.0), (0.1, 0.0), (0.0, 0.1)])
    model.step()
    assert groups.current == ()
    Animal(model, position=(0.1, 0.1))
    model.step()
    assert [group.size for group in groups.current] == [4]


def test_a_radius_beyond_perception_is_searched_for():
    wide, narrow = Groups(0.5, 4), Groups(0.5, 4)
    model, _ = flock([(0, 0), (2, 2)], groups=wide, core_radius=1.0)
    other, _ = flock([(0, 0), (2, 2)], groups=narrow, core_radius=0.3)
    model.step()
    other.step()
    np.testing.assert_array_equal(model.particles.group, other.particles.group)
    assert len(wide.current) == 2


def test_a_failed_step_leaves_the_groups_as_they_were():
    model, groups = flock(
        [(0, 0)], laws=[Law("lost", lambda agent, p: (p.time / (1.0 - p.time), 0.0))]
    )
    model.step()
    before, events = groups.current, list(groups.events)
    shift(model, 0, 6, (9.0, 9.0))
    with pytest.raises(RuntimeError):
        model.step()
    assert groups.current == before
    assert groups.events == events
    assert (model.particles.group == 0).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"radius": 0.0}, "radius is 0.0"),
        ({"radius": np.inf}, "radius is inf"),
        ({"radius": 1.0, "least": 1}, "least is 1; it must be a whole number, 2 or more"),
    ],
)
def test_bad_input_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        Groups(**options)
