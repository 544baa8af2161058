"""First hits by the tree are those of trying every wall, to the last bit."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import Obstacles, Polygon, Polyline, disc, square
from apmethod.compile import plain
from apmethod.move.obstacles.rays import BEFORE, first_hits
from apmethod.move.obstacles.tree import LEAF, RULES
from obstacle_samples import assert_as_brute_force, random_obstacles


def grazing_rays(obstacles, draw, count):
    """From anywhere, through corners, along walls, on walls, of no length, along the axes."""
    corners = obstacles.walls.ends[0].reshape(-1, 2)
    a, b, c = (corners[draw.integers(len(corners), size=count)] for _ in range(3))
    far = draw.uniform(-0.3, 1.3, (count, 2))
    walls = obstacles.walls.ends[0][draw.integers(len(corners) // 2, size=count)]
    along = walls[:, 2:] - walls[:, :2]
    share, longer = draw.uniform(-1.0, 2.0, (2, count, 1))
    on_line = walls[:, :2] + share * along
    level = np.column_stack([far[:, 0], b[:, 1]])
    pairs = [
        (far, draw.uniform(-0.3, 1.3, (count, 2))),
        (far, far + 0.02 * draw.normal(size=(count, 2))),
        (far, a),
        (far, far + 2.0 * (a - far)),
        (a, b),
        (a, c),
        (walls[:, :2], walls[:, 2:]),
        (on_line, on_line + longer * along),
        (on_line, far),
        (level, b),
        (level, np.column_stack([draw.uniform(-0.3, 1.3, count), b[:, 1]])),
        (np.column_stack([a[:, 0], far[:, 1]]), a),
        (far, far),
        (a, a),
    ]
    starts, ends = (np.concatenate(part) for part in zip(*pairs, strict=True))
    return starts, ends


@pytest.mark.parametrize("rule", list(RULES))
def test_a_million_rays_over_random_scenes(rule):
    scenes, count = {"surface_area": (15, 5000), "median": (2, 2000), "none": (1, 1000)}[rule]
    hits = total = 0
    for seed in range(scenes):
        draw = np.random.default_rng(seed)
        obstacles = Obstacles(random_obstacles(draw, moving=False), rule=rule)
        starts, ends = grazing_rays(obstacles, draw, count)
        hits += (assert_as_brute_force(obstacles, starts, ends)[1] >= 0).sum()
        total += len(starts)
    assert 0.3 * total < hits < total


lattice = st.integers(0, 6).map(float)
point = st.tuples(lattice, lattice)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(lattice, lattice, st.integers(1, 4)), min_size=1, max_size=8),
    st.lists(st.tuples(point, point), max_size=6),
    st.lists(st.tuples(point, point), min_size=1, max_size=40),
    st.sampled_from([1.0, 0.1, 1e-3]),
)
def test_touching_overlapping_and_collinear_obstacles(squares, lines, rays, unit):
    things = [square((unit * x, unit * y), unit * side) for x, y, side in squares]
    things += [Polyline(unit * np.array(line)) for line in lines if line[0] != line[1]]
    starts, ends = np.ascontiguousarray(unit * np.array(rays).transpose(1, 0, 2))
    assert_as_brute_force(Obstacles(things), starts, ends)


def test_a_first_hit_is_where_shapely_finds_it():
    draw = np.random.default_rng(5)
    things = random_obstacles(draw, moving=False)
    obstacles = Obstacles(things)
    starts, ends = draw.random((2, 3000, 2))
    shares, hits = obstacles.first_hits(starts, ends)
    lines = shapely.multilinestrings(
        [shapely.linestrings(w.reshape(2, 2)) for w in obstacles.walls.ends[0]]
    )
    rays = shapely.linestrings(np.stack([starts, ends], axis=1))
    met = shapely.intersects(rays, lines)
    assert (met == (hits >= 0)).mean() > 0.999  # shapely rounds where we do not
    gone = np.hypot(*(ends - starts)[met].T) * shares[met]
    expected = shapely.distance(shapely.points(starts[met]), shapely.intersection(rays[met], lines))
    assert np.abs(gone - expected).max() < 1e-12


def test_both_tiers_walk_alike():
    draw = np.random.default_rng(2)
    obstacles = Obstacles(random_obstacles(draw, moving=False))
    starts, ends = grazing_rays(obstacles, draw, 30)
    found = []
    for run in (first_hits, plain(first_hits)):
        n = len(starts)
        arrays = np.full(n, -1, np.int32), np.empty(n), np.empty(n, np.int32), np.empty(n, np.int32)
        run(0, n, obstacles.tree, obstacles.walls, BEFORE, starts, ends, *arrays)
        found.append(arrays)
    for one, other in zip(*found, strict=True):
        assert (one == other).all()


def test_pairs_are_blocked_where_a_wall_is_between_them():
    wall = Polyline([(0.5, 0.0), (0.5, 0.8)])
    obstacles = Obstacles([wall, disc((0.8, 0.2), 0.05)])
    positions = np.array([[0.4, 0.5], [0.6, 0.5], [0.4, 0.9], [0.6, 0.9], [0.4, 0.3], [0.5, 0.8]])
    pairs = np.array([[0, 1], [2, 3], [0, 4], [4, 3], [1, 4], [2, 5]])
    blocked = obstacles.blocked(positions, pairs)
    assert blocked.tolist() == [True, False, False, True, True, True]
    assert (obstacles.blocked(positions, pairs[:, ::-1]) == blocked).all()


def test_who_is_near_a_wall():
    draw = np.random.default_rng(3)
    things = random_obstacles(draw, moving=False)
    obstacles = Obstacles(things)
    points = draw.uniform(-0.2, 1.2, (2000, 2))
    lines = shapely.union_all([shapely.LineString(c) for o in things for c in o.chains])
    apart = shapely.distance(shapely.points(points), lines)
    for distance in (0.0, 1e-3, 0.03, 0.5):
        clear = np.abs(apart - distance) > 1e-12
        assert (obstacles.near(points, distance) == (apart <= distance))[clear].all()


# -- the domains -----------------------------------------------------------------------


def test_domains_tile_the_plane_and_list_what_is_in_them():
    draw = np.random.default_rng(4)
    obstacles = Obstacles(random_obstacles(draw, moving=False))
    domains = obstacles.domains()
    limits = np.array([domain.limits for domain in domains])
    points = draw.uniform(-0.5, 1.5, (3000, 2))
    inside = ((points[:, None] >= limits[:, :2]) & (points[:, None] < limits[:, 2:])).all(axis=2)
    assert (inside.sum(axis=1) == 1).all()
    for domain in domains:
        box = shapely.box(*np.clip(domain.limits, -2.0, 3.0))
        for obstacle in obstacles:
            meets = any(shapely.LineString(chain).intersects(box) for chain in obstacle.chains)
            if meets:
                assert obstacle in domain.obstacles


def test_family_and_contiguous_domains():
    obstacles = Obstacles([square((0.0, 0.0), 2.0), square((10.0, 0.0), 2.0)])
    tree = obstacles.tree
    for domain in obstacles.domains():
        if domain.father < 0:
            continue
        assert set(tree.sons[domain.father].tolist()) == {domain.number, domain.brother}
        for side, other in enumerate(domain.beyond):
            if other < 0:
                assert np.isinf(domain.limits[side])
                continue
            shared, opposite = domain.limits[side], tree.limits[other, (side + 2) % 4]
            assert shared == opposite
            across = (side + 1) % 2
            assert tree.limits[other, across] <= domain.limits[across]
            assert tree.limits[other, across + 2] >= domain.limits[across + 2]


def test_empty_domains_are_as_large_as_obstacles_let_them():
    """All that is outside of the squares' own bounds is in empty domains."""
    squares = [square((3.0, 5.0), 2.0), square((9.0, 6.0), 1.0)]
    for domain in Obstacles(squares).domains():
        assert len(domain.obstacles) < 2
        for obstacle in domain.obstacles:
            (corners,) = obstacle.chains
            assert (np.array(domain.limits[:2]) > corners.min(axis=0) - 1e-6).all()
            assert (np.array(domain.limits[2:]) < corners.max(axis=0) + 1e-6).all()


def test_the_threshold_stops_the_cutting():
    things = [disc((k % 5, k // 5), 0.4) for k in range(25)]
    sizes = [len(Obstacles(things, threshold=t).tree.axis) for t in (0.0, 1.0, 5.0, 100.0)]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] > sizes[2] > sizes[3]


def test_no_obstacles_are_fine():
    shares, hits = Obstacles([]).first_hits(np.zeros((2, 2)), np.ones((2, 2)))
    assert (hits == -1).all()
    assert (shares > 1.0).all()


def test_a_polygon_with_very_many_corners():
    angles = np.linspace(0.0, 2.0 * np.pi, 5000, endpoint=False)
    reach = 1.0 + 0.2 * np.sin(40.0 * angles)
    coast = Polygon(reach[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]))
    obstacles = Obstacles([coast])
    draw = np.random.default_rng(6)
    starts = draw.uniform(-1.3, 1.3, (2000, 2))
    assert_as_brute_force(obstacles, starts, starts + 0.1 * draw.normal(size=(2000, 2)))
    leaves = obstacles.tree.axis == LEAF
    assert (obstacles.tree.last - obstacles.tree.first)[leaves].mean() < 3.0
