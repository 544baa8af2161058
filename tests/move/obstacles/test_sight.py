"""What agents feel near walls: nothing through them, and all that they mirror."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from apmethod import KERNELS, Bounded, Mirrored, Obstacles, Periodic, Polyline, reconstruct, square
from apmethod.compile import set_threads, threads
from apmethod.field.beside import fit_to_walls
from apmethod.move.obstacles.sight import sights_of
from apmethod.perceive.domain import Open
from obstacle_samples import by_brute_force, random_obstacles
from samples import Curious, build, column_by_id

BOX = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
SUMS = ("density", "count", "force", "envy")


class Spontaneous(Curious):
    """Runs its own perceive, and so its pairs, in Python."""

    def perceive(self):
        super().perceive()


def sums(positions, obstacles, names=SUMS, **options):
    """The terms' sums of a cloud among obstacles, (agents, all components)."""
    model = build(
        positions=positions, agent_class=Curious, flow=None, dt=1e-9, obstacles=obstacles, **options
    )
    model.step()
    columns = [column_by_id(model, name) for name in names]
    return np.concatenate([c.reshape(len(positions), -1) for c in columns], axis=1)


def same(one, other):
    assert np.abs(one - other).max() <= 1e-12 * np.abs(other).max()


def places(count, seed=1):
    return 0.001 + 0.998 * np.random.default_rng(seed).random((count, 2))


def lattice(count):
    """Places whose lines to images go right through the corners of the unit square."""
    x, y = np.meshgrid(*[(np.arange(count) + 0.5) / count] * 2)
    return np.column_stack([x.ravel(), y.ravel()])


@pytest.mark.parametrize("evaluation", ["gathered", "scattered", "stored"])
@pytest.mark.parametrize("positions", [places(250), lattice(16)])
def test_a_box_of_walls_is_a_mirrored_domain(evaluation, positions):
    expected = sums(positions, None, domain=Mirrored((0, 0), (1, 1)))
    same(sums(positions, [Polyline(BOX)], evaluation=evaluation), expected)


@pytest.mark.parametrize("tier", ["compiled", "agents"])
def test_walls_and_mirrored_sides_share_a_corner(tier):
    positions = places(150)
    positions = positions[~Obstacles([square((0.1, 0.2), 0.1)]).occupied(positions)]
    inner = square((0.1, 0.2), 0.1)
    expected = sums(positions, [Polyline(BOX), inner])
    found = sums(positions, [square((0.1, 0.2), 0.1)], domain=Mirrored((0, 0), (1, 1)), tier=tier)
    same(found, expected)


@pytest.mark.parametrize("parts", [1, 2, 3, 4])
def test_in_a_wedge_images_are_those_of_its_group(parts):
    angle, draw = np.pi / parts, np.random.default_rng(parts)
    ends = [(3.0, 0.0), (0.0, 0.0), (3.0 * np.cos(angle), 3.0 * np.sin(angle))]
    wall = Polyline(ends if parts > 1 else [(-3.0, 0.0), (3.0, 0.0)])
    at, out = angle * draw.uniform(0.02, 0.98, 60), draw.uniform(0.01, 0.6, 60)
    positions, masses = np.column_stack([out * np.cos(at), out * np.sin(at)]), draw.random(60)
    h, kernel = 0.15, KERNELS["gaussian"]
    images = []
    for turn in 2.0 * angle * np.arange(parts):
        for sign in (1.0, -1.0):
            images.append(
                np.column_stack([out * np.cos(turn + sign * at), out * np.sin(turn + sign * at)])
            )
    expected = reconstruct(positions, np.concatenate(images), np.tile(masses, 2 * parts), h, kernel)
    same(
        reconstruct(positions, positions, masses, h, kernel, obstacles=Obstacles([wall])), expected
    )


@given(seed=st.integers(0, 10**6))
@example(seed=310483)  # a place with 758 images
@settings(max_examples=8, deadline=None)
def test_straight_lines_are_those_that_no_wall_cuts_and_all_go_both_ways(seed):
    draw = np.random.default_rng(seed)
    obstacles = Obstacles(random_obstacles(draw, moving=False))
    positions = draw.random((500, 2))
    positions = positions[~obstacles.occupied(positions)]
    model = build(positions=positions, flow=None, core_radius=0.08, obstacles=obstacles)
    pairs = build(positions=positions, flow=None, core_radius=0.08).space.pairs()
    _, hits = by_brute_force(obstacles, positions[pairs[:, 0]], positions[pairs[:, 1]])
    assert (model.space.pairs() == pairs[hits < 0]).all()
    found = sights_of(obstacles, model.space.cells, Open())
    ways = Counter()
    for i, begin, end in zip(found.place.tolist(), found.begin, found.end, strict=True):
        lengths = np.hypot(found.dx[begin:end], found.dy[begin:end]).round(9).tolist()
        ways.update(zip([i] * (end - begin), found.other[begin:end].tolist(), lengths, strict=True))
    near = set(found.place.tolist())  # others are listed only as these see them
    there = Counter({way: n for way, n in ways.items() if way[1] in near})
    assert there == Counter({(j, i, length): n for (i, j, length), n in there.items()})


def test_a_thin_wall_passes_nothing():
    left, right = places(120, 1) * (0.5, 1.0), places(120, 2) * (0.5, 1.0) + (0.5, 0.0)
    both = np.concatenate([left, right])
    fence = [(0.5, -1.0), (0.5, 0.4), (0.5, 2.0)]
    for form in ("blob", "plain"):
        models = [
            build(positions=p, obstacles=[Polyline(fence, behaviour="bounce")], form=form,
                  flow=None, dt=1e-3)
            for p in (both, left)
        ]  # fmt: skip
        for model in models:  # masses are drawn for all places given
            model.particles.assign("mass", 1.0 / 240)
            for _ in range(5):
                model.step()
        for name in models[1].particles.names:
            together, alone = (column_by_id(model, name) for model in models)
            assert np.abs(together[:120] - alone).max() <= 1e-12 * np.abs(alone).max(), name


@pytest.mark.parametrize("domain", ["open", "periodic", "mirrored"])
def test_tiers_and_mixed_scenes_agree_among_walls(domain):
    draw = np.random.default_rng(5)
    things = random_obstacles(draw, moving=False)
    positions = draw.random((150, 2))
    positions = positions[~Obstacles(things).occupied(positions)]
    whole = {"open": None, "periodic": Periodic((-0.1, -0.1), (1.2, 1.3)),
             "mirrored": Mirrored((-0.1, 0.0), (1.1, 1.0))}[domain]  # fmt: skip
    options = {"domain": whole, "core_radius": 0.15, "obstacles": things}
    expected = sums(positions, **options)
    same(sums(positions, **options, tier="agents"), expected)
    if domain == "open":
        # The same agents in turn, so that columns by id are those of the rows.
        model = build(positions=positions, agent_class=Curious, others=(Spontaneous,), flow=None,
                      dt=1e-9, core_radius=0.15, obstacles=things)  # fmt: skip
        alone = build(positions=positions, agent_class=Curious, others=(type("C", (Curious,), {}),),
                      flow=None, dt=1e-9, core_radius=0.15, obstacles=things)  # fmt: skip
        for each in (model, alone):
            each.step()
        for name in SUMS:
            same(column_by_id(model, name), column_by_id(alone, name))


def test_walls_act_across_periodic_sides():
    positions, wall = places(250), np.array([(0.45, 0.3), (0.6, 0.5), (0.5, 0.75)])
    found = []
    for shift in (0.0, 0.395):  # the second brings the wall near the sides
        moved = np.column_stack([(positions[:, 0] + shift) % 1.0, positions[:, 1]])
        wall_there = Polyline([(x + shift, y) for x, y in wall])
        found.append(sums(moved, [wall_there], domain=Periodic((0, 0), (1, 1))))
    assert np.abs(found[0] - found[1]).max() <= 1e-10 * np.abs(found[0]).max()


def test_a_constant_field_is_constant_beside_any_wall():
    """The lines of sight cover every direction once: only the agents' spacing is left."""
    points = np.random.default_rng(3).uniform(0.1, 0.9, (1500, 2))

    def off(count, contributions="mirrored"):
        things = random_obstacles(np.random.default_rng(8), moving=False, absorbing=False)
        obstacles = Obstacles(things, contributions=contributions)
        spacing = 1.0 / count
        line = np.arange(-0.2, 1.2, spacing) + 0.3 * spacing
        nodes = np.column_stack([part.ravel() for part in np.meshgrid(line, line)])
        nodes = nodes[~obstacles.occupied(nodes)]
        masses = np.full(len(nodes), spacing**2)
        agents = fit_to_walls(
            obstacles, lambda x, y: np.ones_like(x), nodes, masses, (spacing, spacing), 0.0, Open()
        )
        free = points[~obstacles.occupied(points)]
        u = reconstruct(free, *agents, 0.025, KERNELS["gaussian"], obstacles=obstacles)
        return np.quantile(np.abs(u - 1.0), 0.98)

    coarse, fine = off(80), off(160)
    assert fine < 0.012
    assert fine < 0.5 * coarse
    assert off(80, "blocked") > 0.3


def test_contributions_can_be_let_through_or_only_blocked():
    positions = places(150)
    wall = [(0.3, 0.2), (0.5, 0.5), (0.4, 0.8)]
    through = Obstacles([Polyline(wall)], contributions="through")
    same(sums(positions, through), sums(positions, None))
    blocked = sums(positions, Obstacles([Polyline(wall)], contributions="blocked"))
    same(sums(positions, [Polyline(wall, behaviour="absorb")]), blocked)
    mirrored = sums(positions, [Polyline(wall)])
    assert (blocked[:, 0] <= mirrored[:, 0] * (1.0 + 1e-6)).all()
    assert (blocked[:, 0] < 0.99 * mirrored[:, 0]).any()
    with pytest.raises(ValueError, match="contributions is 'all'; it must be one of mirrored"):
        Obstacles([], contributions="all")


def test_far_walls_change_no_sum():
    positions = places(150)
    bounded = Bounded((0, 0), (9, 9))
    far = sums(positions, [square((7.0, 7.0), 0.5)], domain=bounded)
    assert (far == sums(positions, None, domain=bounded)).all()


def test_sums_near_walls_have_the_same_bits_on_any_number_of_threads():
    walls = random_obstacles(np.random.default_rng(4), moving=False)
    positions = places(3000)
    positions = positions[~Obstacles(walls).occupied(positions)]
    before, found = threads(), []
    try:
        for count in (1, 2, 3):
            set_threads(count)
            found.append(sums(positions, walls, core_radius=0.08))
    finally:
        set_threads(before)
    assert (found[0] == found[1]).all()
    assert (found[0] == found[2]).all()
