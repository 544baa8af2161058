"""Planes follow moving obstacles; the tree is built again only where a domain disappears."""

import numpy as np
import pytest

from apmethod import AgentParticle, Obstacles, ParticleModel, disc, square
from apmethod.move.obstacles.rays import BEFORE, first_hits
from apmethod.move.obstacles.tree import LEAF
from obstacle_samples import assert_as_brute_force, random_obstacles


def stepped(obstacles, steps, dt=0.01):
    """Obstacles that belong to a model and go on by themselves."""
    model = ParticleModel(AgentParticle, core_radius=0.1, dt=dt, obstacles=obstacles)
    for _ in range(steps):
        model.step()
        assert model.obstacles.tree  # planes follow when they are asked for
        yield model


def crowd(moving=1, count=100, speed=0.05):
    """Octagons on a jittered grid, the first of them moving and turning."""
    draw = np.random.default_rng(7)
    side = int(np.ceil(np.sqrt(count)))
    places = np.stack(np.divmod(np.arange(count), side), axis=1) + draw.uniform(
        0.3, 0.7, (count, 2)
    )
    return [
        disc(
            place / side, 0.2 / side, corners=8,
            velocity=draw.uniform(-speed, speed, 2) if number < moving else (0.0, 0.0),
            spin=1.0 if number < moving else 0.0,
        )
        for number, place in enumerate(places)
    ]  # fmt: skip


@pytest.mark.parametrize("moving", [1, 10, 100])
def test_hits_are_those_of_a_new_tree(moving):
    obstacles = Obstacles(crowd(moving))
    draw = np.random.default_rng(1)
    for _ in stepped(obstacles, 30):
        starts = draw.random((300, 2))
        ends = np.concatenate([draw.random((150, 2)), starts[150:] + 0.01])
        assert_as_brute_force(obstacles, starts, ends)
        fresh = Obstacles(list(obstacles))
        fresh.walls.ends[:2] = obstacles.walls.ends[:2]
        fresh._bounds[:] = obstacles._bounds
        fresh._build()
        for found, expected in zip(
            obstacles.first_hits(starts, ends), fresh.first_hits(starts, ends), strict=True
        ):
            assert (found == expected).all()


def test_one_of_a_hundred_moves_planes_and_rarely_builds():
    obstacles = Obstacles(crowd(1))
    (model,) = stepped(obstacles, 1)
    before = obstacles.tree
    model.step()
    assert obstacles.rebuilds == 0
    assert obstacles.tree.axis is before.axis
    moved = np.flatnonzero(obstacles.tree.plane != before.plane)
    owners = obstacles.walls.obstacle[before.owner[moved]]
    assert len(moved)
    assert (owners == 0).all()
    for _ in range(50):
        model.step()
    assert obstacles.rebuilds <= 5


def test_a_domain_that_disappears_is_counted():
    obstacles = Obstacles([square((0.0, 0.0), 1.0, velocity=(1.0, 0.0)), square((3.0, 0.2), 1.0)])
    counts = [model.obstacles.rebuilds for model in stepped(obstacles, 60, dt=0.1)]
    assert counts[0] == 0
    assert 1 <= counts[-1] <= 20  # it passes four planes of the other one


def test_only_the_part_with_a_domain_that_disappears_is_built_again():
    near = [square((0.0, 0.0), 1.0, velocity=(1.0, 0.0)), square((3.0, 0.0), 1.0)]
    obstacles = Obstacles([*near, *(square((20.0 + 3.0 * k, 9.0), 1.0) for k in range(20))])

    def far():
        return {d.limits for d in obstacles.domains() if d.limits[0] > 20.0}

    before = far()
    for _ in stepped(obstacles, 40, dt=0.1):
        assert far() == before
    assert obstacles.rebuilds >= 1


def test_walls_that_differ_by_rounding_have_no_domain_between_them():
    thin = [square((3.0, 0.0), 1.0), square((3.0 + 1e-11, 4.0), 1.0)]
    obstacles = Obstacles([square((0.0, 20.0), 1.0, velocity=(-1.0, 0.0)), *thin])
    for model in stepped(obstacles, 20, dt=0.1):
        assert model.obstacles.rebuilds == 0
    widths = [d.limits[axis + 2] - d.limits[axis] for d in obstacles.domains() for axis in (0, 1)]
    assert min(widths) > 2.0 * obstacles.clearance


def tried_walls(obstacles, tree, starts, ends):
    """How many walls rays try by a tree, on average."""
    count = len(starts)
    domains, hits, tried = np.full(count, -1, np.int32), *np.empty((2, count), np.int32)
    first_hits(
        0, count, tree, obstacles.walls, BEFORE, starts, ends, domains, np.empty(count), hits, tried
    )
    return tried.mean()


def test_domains_do_not_crowd_where_obstacles_have_come_and_gone():
    to_and_fro = [
        disc((0.5, 0.1 + 0.2 * k), 0.03, path=lambda t, k=k: (0.4 * np.sin((2.0 + k) * t), 0.0))
        for k in range(5)
    ]
    obstacles = Obstacles([*to_and_fro, *crowd(0, 400)])
    starts = np.random.default_rng(2).random((2000, 2))
    for model in stepped(obstacles, 200, dt=0.05):
        if model.steps % 20 == 0:
            fresh = tried_walls(obstacles, obstacles.new_tree(), starts, starts + 0.01)
            assert tried_walls(obstacles, obstacles.tree, starts, starts + 0.01) < 2.0 * fresh
    assert_as_brute_force(obstacles, starts, starts + 0.01)


def test_domains_hug_a_moving_obstacle():
    drum = square((0.0, 0.0), 1.0, velocity=(1.0, 0.5))
    obstacles = Obstacles([drum, square((9.0, 9.0), 1.0)])
    for model in stepped(obstacles, 5, dt=0.1):
        occupied = [d for d in obstacles.domains() if drum in d.obstacles]
        low = np.min([d.limits[:2] for d in occupied], axis=0)
        high = np.max([d.limits[2:] for d in occupied], axis=0)
        time = model.elapsed
        # They hold the way of the last step, and nothing else.
        assert low == pytest.approx(np.array([time - 0.6, 0.5 * time - 0.55]), abs=1e-6)
        assert high == pytest.approx(np.array([time + 0.5, 0.5 * time + 0.5]), abs=1e-6)


def test_every_list_is_complete_after_many_moves():
    draw = np.random.default_rng(11)
    obstacles = Obstacles(random_obstacles(draw, moving=True))
    for _ in stepped(obstacles, 40, dt=0.05):
        tree = obstacles.tree
        leaves = np.flatnonzero(tree.axis == LEAF)
        for wall in range(len(obstacles.walls.turn)):
            low, high = obstacles._bounds[wall, :2], obstacles._bounds[wall, 2:]
            middle = obstacles.walls.ends[:2, wall].reshape(2, 2, 2).mean(axis=1)
            for place in [*obstacles.walls.ends[:2, wall].reshape(4, 2), *middle]:
                assert (low < place).all()
                assert (place < high).all()
                at = leaves[
                    ((tree.limits[leaves, :2] <= place) & (place <= tree.limits[leaves, 2:])).all(1)
                ]
                for leaf in at:
                    assert wall in tree.listed[tree.first[leaf] : tree.last[leaf]]
