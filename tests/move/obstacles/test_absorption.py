"""Walls that take mass: agents beside them are held off, and lose what diffusion lets out."""

import numpy as np
import pytest

from apmethod import FieldModel, Obstacles, Polyline, square
from apmethod.compile import memory
from apmethod.move.obstacles.holding import hold_off
from apmethod.move.obstacles.look import walls_near
from apmethod.move.obstacles.sight import kinds_of
from obstacle_samples import random_obstacles

REACH = 0.4


def held_off(obstacles, x, y):
    """g and div g + |g|^2 at a place."""
    walls = obstacles.walls
    waiting, leaves = np.empty((2, len(obstacles.tree.axis)), np.int32)
    tried = np.full(len(walls.turn), -1, np.int64)
    near, kind = np.empty((len(tried), 8)), np.empty(len(tried), np.int8)
    count = walls_near(
        x, y, 0.0, 0.0, REACH, obstacles.tree, walls, kinds_of(obstacles), waiting, leaves,
        tried, 0, near, kind, 0,
    )  # fmt: skip
    return np.array(hold_off(x, y, near, kind, count, REACH, obstacles.clearance))


def walls_of(points, behaviour="absorb", **options):
    return Obstacles([Polyline(points, behaviour=behaviour)], absorbing="mass", **options)


ROOM = walls_of([(0, 0), (1, 0), (1, 0.7), (0, 0.7), (0, 0)])
MIXED = Obstacles(
    [Polyline([(0, 0), (2, 0)], behaviour="absorb"), Polyline([(0, 0), (1, 2)])], absorbing="mass"
)
FENCE = walls_of([(0.3, 0.4), (0.9, 0.5)])
BLOCK = Obstacles([square((0.5, 0.5), 0.3, behaviour="absorb")], absorbing="mass")


@pytest.mark.parametrize("obstacles", [ROOM, MIXED, FENCE, BLOCK])
def test_the_divergence_is_that_of_the_field(obstacles):
    draw, step = np.random.default_rng(2), 1e-6
    places = draw.uniform((0.0, 0.0), (1.0, 0.7), (150, 2))
    places = places[~obstacles.near(places, 0.02) & ~obstacles.occupied(places)]
    off = []
    for x, y in places:
        g_x, g_y, rate = held_off(obstacles, x, y)
        east, west = held_off(obstacles, x + step, y), held_off(obstacles, x - step, y)
        north, south = held_off(obstacles, x, y + step), held_off(obstacles, x, y - step)
        divergence = (east[0] - west[0] + north[1] - south[1]) / (2.0 * step)
        off.append(abs(rate - g_x**2 - g_y**2 - divergence) / (1.0 + g_x**2 + g_y**2))
    # But for places within a step of a line where another part of a wall is the nearest.
    assert np.quantile(off, 0.97) < 1e-6


def test_beside_walls_agents_are_held_off_as_diffusion_draws_them():
    for obstacles, x, slope in ((ROOM, 0.5, 0.0), (FENCE, 0.6, 1.0 / 6.0)):
        wall = slope * (x - 0.3) + (0.4 if slope else 0.0)
        for distance in (1e-2, 1e-4, 1e-6):
            normal = np.array([-slope, 1.0]) / np.hypot(slope, 1.0)
            place = np.array([x, wall]) + distance * normal
            g_x, g_y, rate = held_off(obstacles, *place)
            assert np.array([g_x, g_y]) * distance == pytest.approx(normal, abs=0.05)
            assert abs(rate) < 300.0


def test_in_corners_it_is_the_gradient_of_what_u_is_there():
    x, y = 0.002, 0.003
    expected = (1.0 / x, 1.0 / y)  # u = x y between two walls that absorb
    assert held_off(ROOM, x, y)[:2] == pytest.approx(expected, rel=1e-2)
    angle = np.arctan2(2.0, 1.0)  # between a wall that absorbs and one that lets nothing through
    at, out = 0.4, 0.003
    g = held_off(MIXED, out * np.cos(at), out * np.sin(at))[:2]
    power = np.pi / (2.0 * angle)
    outward = (np.cos(at), np.sin(at))
    assert g @ outward == pytest.approx(power / out, rel=1e-2)
    around = g @ (-np.sin(at), np.cos(at))
    assert around == pytest.approx(power / out / np.tan(power * at), rel=1e-2)
    past_the_end = held_off(FENCE, 0.3 - 0.003, 0.4 - 0.0005)[:2]  # u = sqrt(r) there
    assert np.hypot(*past_the_end) == pytest.approx(0.5 / np.hypot(0.003, 0.0005), rel=1e-2)


class Cloud(FieldModel):
    """A Gaussian among obstacles."""

    def __init__(self, obstacles, **options):
        super().__init__(
            lambda x, y: np.exp(-20.0 * ((x - 0.45) ** 2 + (y - 0.4) ** 2)), (0.0, 1.0, 0.0, 1.0),
            diffusivity=5e-3, rng=3, obstacles=obstacles, **{"particles": 150} | options,
        )  # fmt: skip


def ran(obstacles, steps=1, **options):
    model = Cloud(obstacles, **options)
    for _ in range(steps):
        model.step()
    table = model.particles
    order = np.argsort([agent.unique_id for agent in table.agents])
    return model, np.column_stack([table.position, table.mass])[order]


@pytest.mark.parametrize("accuracy", ["paper", "conservative", "accurate"])
@pytest.mark.parametrize("kind", ["room", "block"])
def test_tiers_and_evaluations_agree(accuracy, kind):
    def obstacles():
        if kind == "block":
            return [square((0.6, 0.5), 0.25, behaviour="absorb"), Polyline([(0.1, 0), (0.1, 1)])]
        walls = [(0.05, 0), (0.9, 0.1), (0.8, 1), (0.1, 0.8), (0.05, 0)]
        return [Polyline(walls, behaviour="absorb")]

    # A step short enough that none is thrown at a wall, where distances are mere rounding.
    _, expected = ran(obstacles(), accuracy=accuracy, dt=0.1)
    for options in ({"tier": "agents"}, {"evaluation": "gathered"}, {"evaluation": "stored"}):
        _, found = ran(obstacles(), accuracy=accuracy, dt=0.1, **options)
        assert found.shape == expected.shape
        assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max(), options


def test_memory_that_is_not_written_is_not_read_either(monkeypatch):
    signal = np.uint64(0x7FF4_0000_0000_0001)  # a NaN that whoever computes with it hears of

    def poisoned(shape, dtype=float):
        array = np.empty(shape, dtype)
        if array.dtype == float:
            array.view(np.uint64)[...] = signal
        return array

    wall = [Polyline([(0.3, -1.0), (0.3, 2.0)], behaviour="absorb")]
    _, expected = ran(wall)
    monkeypatch.setattr(memory, "empty", poisoned)
    _, found = ran(wall)
    assert np.array_equal(found, expected)


@pytest.mark.parametrize("seed", [1, 4])
def test_among_any_obstacles_no_mass_is_lost_or_made(seed):
    things = random_obstacles(np.random.default_rng(seed), moving=False)
    model = Cloud(things, accuracy="conservative", particles=3000)
    begun = model.particles.mass.sum()
    for _ in range(6):
        model.step()
        left = model.particles.mass.sum()
        assert left + model.obstacles.absorbed_mass == pytest.approx(begun, rel=1e-12)


def test_what_walls_take_is_a_choice():
    wall = [(0.3, -1.0), (0.3, 2.0)]
    model, _ = ran([Polyline(wall, behaviour="absorb")], 3)
    assert model.obstacles.absorbed == 0
    assert model.diagnostics()["absorbed_mass"] > 0.0
    agents = Obstacles([Polyline(wall, behaviour="absorb")], absorbing="agents")
    model, _ = ran(agents, 3)
    assert model.motion.absorption is None
    assert agents.absorbed > 0
    model, _ = ran([Polyline(wall)])
    assert model.motion.absorption is None
    with pytest.raises(ValueError, match="absorbing is 'all'; it must be one of agents, mass"):
        Obstacles([], absorbing="all")


@pytest.mark.parametrize(("speed", "most"), [(0.0, 5e-4), (0.01, 3e-3), (-0.02, 1e-3)])
def test_a_wall_may_move_while_it_takes_mass(speed, most):
    """A spot that a wall comes to or leaves: in the wall's frame a drift, with its image."""
    wall, diffusivity, age = -0.45, 1e-3, 5.0

    def exact(x, y, time):
        passed = time + age  # since the spot was a point
        begun = speed * age - wall  # how far off the wall was then
        off = x - wall - speed * time  # and how far off (x, y) is now

        def spread(z):
            return np.exp(-(z**2) / (4.0 * diffusivity * passed)) / np.sqrt(passed)

        drift = speed * passed
        image = np.exp(speed * begun / diffusivity) * spread(off + begun + drift)
        return np.where(off > 0.0, (spread(off - begun + drift) - image) * spread(y), 0.0)

    class Spot(FieldModel):
        until = 8.0

        def exact(self, x, y, time):
            return exact(x, y, time)

    fence = Polyline([(wall, -3.0), (wall, 3.0)], behaviour="absorb", velocity=(speed, 0.0))
    model = Spot(
        lambda x, y: exact(x, y, 0.0), (-1.0, 1.0, -1.0, 1.0), particles=1000,
        diffusivity=diffusivity, accuracy="accurate",
        obstacles=Obstacles([fence], absorbing="mass"), rng=1,
    )  # fmt: skip
    mass = model.particles.mass.sum()
    while model.elapsed < model.until:
        model.step()
    kept = model.particles.mass.sum() + model.obstacles.absorbed_mass
    assert kept == pytest.approx(mass, rel=1e-13)
    assert model.obstacles.absorbed_mass > 0.0
    assert model.errors()["l2_error"] < most
