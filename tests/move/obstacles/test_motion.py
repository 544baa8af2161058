"""Agents among obstacles: what they do at walls, and that none gets in, through or lost."""

import numpy as np
import pytest

from apmethod import (
    AgentParticle,
    Bounded,
    Column,
    Flow,
    InertialParticle,
    Law,
    Obstacles,
    ParticleModel,
    Periodic,
    Polygon,
    Polyline,
    StepFailed,
    explain,
    square,
)
from obstacle_samples import half_back, random_obstacles
from obstacle_soak import rooms_of, wander

PUSH = Law("push", lambda agent, p: agent.push, reads=("push",))
#: Much more than what agents are kept in front of walls.
NEAR = 1e-7


class Walker(AgentParticle):
    """Goes where it is pushed."""

    push = Column(2)


def walkers(obstacles, positions, pushes, **options):
    options.setdefault("dt", 1.0)
    model = ParticleModel(
        options.pop("agent_class", Walker), core_radius=0.1, laws=[PUSH], obstacles=obstacles,
        **options,
    )  # fmt: skip
    cls = model.particles.classes[0]
    cls.create_agents(model, len(positions), position=positions, push=pushes)
    return model


WALL = [(1.0, -5.0), (1.0, 5.0)]


@pytest.mark.parametrize(
    ("behaviour", "end"),
    [
        ("repulse", (0.0, -0.5)),
        ("bounce", (0.0, 1.5)),
        ("slide", (1.0, 1.5)),
        ("stick", (1.0, 0.5)),
        (half_back, (0.5, 1.0)),
    ],
)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_behaviours_at_a_wall(behaviour, end, side):
    mirror = np.array([side, 1.0])
    wall = Polyline(mirror * WALL, behaviour=behaviour)
    model = walkers([wall], [mirror * (0.0, -0.5)], [mirror * (2.0, 2.0)])
    model.step()
    assert model.particles.position[0] == pytest.approx(mirror * end, abs=NEAR)
    assert side * model.particles.position[0, 0] < 1.0


def test_an_agent_that_sticks_stays_until_the_obstacle_is_gone():
    wall = Polyline(WALL, behaviour="stick")
    model = walkers([square((9.0, 9.0), 1.0), wall], [(0.0, 0.0)], [(2.0, 0.0)])
    model.step()
    place = model.particles.position.copy()
    model.particles.assign("push", (-1.0, 0.0))
    model.step()
    assert (model.particles.position == place).all()
    model.obstacles.remove(model.obstacles[0])
    model.step()
    assert (model.particles.position == place).all()
    model.obstacles.remove(wall)
    model.step()
    assert model.particles.position[0] == pytest.approx((0.0, 0.0), abs=NEAR)
    assert model.obstacles.rebuilds == 2


def test_absorbed_agents_leave_and_are_counted():
    hole = square((2.0, 0.0), 1.0, behaviour="absorb", name="drain")
    positions = [(0.0, y) for y in (-0.4, 0.0, 0.4, 2.0)]
    model = walkers([hole], positions, (3.0, 0.0))
    model.step()
    assert len(model.agents) == len(model.particles) == 1
    assert model.particles.position[0] == pytest.approx((3.0, 2.0))
    assert hole.absorbed == model.obstacles.absorbed == 3
    model.step()
    assert hole.absorbed == 3


def test_several_bounces_in_one_step():
    channel = [Polyline([(0, 0), (9, 0)], behaviour="bounce"),
               Polyline([(0, 1), (9, 1)], behaviour="bounce")]  # fmt: skip
    model = walkers(channel, [(0.5, 0.5)], [(7.0, 7.0)])
    model.step()
    assert model.particles.position[0] == pytest.approx((7.5, 0.5), abs=NEAR)


def test_a_corner_sends_back_by_where_it_came():
    box = square((2.0, 2.0), 2.0, behaviour="bounce")
    model = walkers([box], [(0.0, 0.0)], [(2.0, 2.0)])
    model.step()
    assert model.particles.position[0] == pytest.approx((0.0, 0.0), abs=NEAR)
    corner = Polyline([(0, 3), (0, 0), (3, 0)], behaviour="bounce")
    model = walkers([corner], [(1.0, 1.0)], [(-2.0, -2.0)])
    model.step()
    assert model.particles.position[0] == pytest.approx((1.0, 1.0), abs=NEAR)


def test_grazing_rays_pass_and_touching_ones_do_not():
    box = square((2.0, 0.0), 2.0, behaviour="stick")
    up = np.nextafter(1.0, 2.0)
    model = walkers([box], [(0.0, 1.5), (0.0, 1.0 + 1e-8), (0.0, up)], [(4.0, 0.0)] * 3)
    model.step()
    x = model.particles.position[:, 0]
    assert x[:2] == pytest.approx([4.0, 4.0])
    # One unit in the last place off the side: too near to it to stay, but not through it.
    assert model.particles.position[2, 1] >= up
    model = walkers([box], [(0.0, 1.0)], [(4.0, 0.0)])
    model.step()
    assert model.particles.position[0] == pytest.approx((1.0, 1.0), abs=NEAR)


def test_a_narrow_wedge_holds_an_agent_without_letting_it_through():
    wedge = Polyline([(0.0, 1e-3), (1.0, 0.0), (0.0, -1e-3)], behaviour="slide")
    model = walkers([wedge], [(0.1, 0.0)], [(2.0, 1e-4)])
    for _ in range(20):
        model.step()
        x, y = model.particles.position[0]
        assert x < 1.0
        assert abs(y) < 1e-3 * (1.0 - x)


@pytest.mark.parametrize(
    ("domain", "ends"),
    [
        (Bounded((0, 0), (1, 1)), [(0.7, 0.5), (0.3, 0.9)]),
        (Periodic((0, 0), (1, 1)), [(0.3, 0.5), (0.7, 0.9)]),
    ],
)
def test_borders_come_before_and_after_walls(domain, ends):
    wall = Polyline([(0.5, 0.25), (0.5, 0.75)], behaviour="bounce")
    model = walkers([wall], [(0.9, 0.5), (0.9, 0.9)], [(0.8, 0.0), (0.8, 0.0)], domain=domain)
    model.step()
    assert model.particles.position == pytest.approx(np.array(ends), abs=NEAR)


# -- velocities ------------------------------------------------------------------------


class Ball(InertialParticle):
    """Keeps its velocity."""


@pytest.mark.parametrize("integrator", ["leap_frog", "velocity_verlet"])
@pytest.mark.parametrize(
    ("behaviour", "velocity"),
    [("bounce", (-1.0, 0.5)), ("slide", (0.0, 0.5)), ("repulse", (-1.0, -0.5))],
)
def test_a_velocity_is_reflected_as_the_displacement_is(integrator, behaviour, velocity):
    wall = Polyline(WALL, behaviour=behaviour)
    model = ParticleModel(
        Ball, core_radius=0.1, dt=0.3, obstacles=[wall], integrator=integrator, laws=[]
    )
    Ball(model, position=(0.0, 0.0), velocity=(1.0, 0.5))
    for _ in range(5):
        model.step()
    assert model.particles.velocity[0] == pytest.approx(velocity, abs=1e-12)
    after = np.array([1.0, 0.5]) + 0.5 * np.array(velocity)
    assert model.particles.position[0] == pytest.approx(after, abs=1e-6)


def test_a_moving_wall_gives_twice_its_velocity():
    wall = Polyline(WALL, behaviour="bounce", velocity=(-0.5, 0.0))
    model = ParticleModel(
        Ball, core_radius=0.1, dt=0.1, obstacles=[wall], integrator="leap_frog", laws=[]
    )
    Ball(model, position=(0.0, 0.0), velocity=(1.0, 0.25))
    for _ in range(10):
        model.step()
    assert model.particles.velocity[0] == pytest.approx((-2.0, 0.25), abs=1e-12)


# -- moving obstacles ------------------------------------------------------------------


@pytest.mark.parametrize("velocity", [0.1, 3.0, 1e3])
def test_an_obstacle_sweeps_resting_agents_along(velocity):
    plough = Polyline([(0.0, -1.0), (0.0, 1.0)], behaviour="slide", velocity=(velocity, 0.0))
    model = walkers([plough], [(0.05, 0.0), (0.07, 0.5), (-0.5, 0.0)], [(0.0, 0.0)] * 3)
    for _ in range(3):
        model.step()
    x = model.particles.position[:, 0]
    assert x[:2] == pytest.approx([3.0 * velocity] * 2, rel=1e-6)
    assert (x[:2] > 3.0 * velocity).all()
    assert x[2] == -0.5


def test_a_turning_blade_sweeps_a_full_circle():
    blade = Polyline([(0.0, 0.0), (1.0, 0.0)], behaviour="slide", spin=1.0, pivot=(0.0, 0.0))
    angles = np.linspace(0.5, 6.0, 12)
    places = 0.5 * np.column_stack([np.cos(angles), np.sin(angles)])
    model = walkers([blade], places, np.zeros((12, 2)), dt=2.0)
    for _ in range(3):
        model.step()
    # All are in front of the blade, which stands at 6 radians, or further out than it is long.
    at = np.arctan2(*model.particles.position.T[::-1]) % (2.0 * np.pi)
    out = np.hypot(*model.particles.position.T) > 1.0
    assert ((at >= 6.0 - 1e-6) | out).all()


def test_stuck_agents_go_where_the_obstacle_goes():
    raft = square((0.0, 0.0), 1.0, behaviour="stick", velocity=(0.25, 0.0), spin=0.5)
    model = walkers([raft], [(0.0, 1.0)], [(0.0, -1.0)], dt=1.0)
    model.step()
    radius = np.hypot(*(model.particles.position[0] - (0.25, 0.0)))
    for step in range(2, 40):
        model.step()
        apart = model.particles.position[0] - (0.25 * step, 0.0)
        assert np.hypot(*apart) == pytest.approx(radius, abs=1e-12)


def closing(squeezed):
    left = Polyline([(-1.0, -3.0), (-1.0, 3.0)], velocity=(0.3, 0.0), name="left")
    right = Polyline([(1.0, -3.0), (1.0, 3.0)], velocity=(-0.3, 0.0), name="right")
    obstacles = Obstacles([left, right], squeezed=squeezed)
    return walkers(obstacles, [(0.0, 0.0), (5.0, 0.0)], [(0.0, 0.0)] * 2)


def test_two_obstacles_closing_on_an_agent_are_reported():
    model = closing("stop")
    for _ in range(3):
        model.step()
    before = model.particles.position.copy()
    with pytest.raises(StepFailed, match=r"step 4.*agent 1 \(Walker\).*is squeezed: \w+ leaves it"):
        model.step()
    assert (model.particles.position == before).all()
    assert model.elapsed == 3.0
    with pytest.raises(StepFailed):
        model.step()
    model.agents[0].remove()
    model.step()
    assert model.elapsed == 4.0


def test_squeezed_agents_can_be_taken_out_and_listed():
    model = closing("remove")
    for _ in range(4):
        model.step()
    assert [agent.unique_id for agent in model.agents] == [2]
    ((time, number, place, obstacle),) = model.obstacles.squeezed
    assert (time, number, obstacle in model.obstacles) == (4.0, 1, True)
    assert abs(place[0]) < 0.2


def test_an_agent_slides_out_of_a_closing_wedge():
    wedge = Polyline([(0.0, 0.0), (4.0, 2.0)], behaviour="slide")
    press = Polyline([(1.0, -1.0), (1.0, 5.0)], behaviour="slide", velocity=(0.5, 0.0))
    model = walkers([wedge, press], [(1.1, 0.56)], [(0.0, 0.0)])
    for _ in range(4):
        model.step()
    x, y = model.particles.position[0]
    assert x == pytest.approx(3.0, abs=NEAR)
    assert x > 3.0
    assert y >= 1.5


def test_a_failed_step_puts_obstacles_back_too():
    drum = square((0.0, 0.0), 1.0, velocity=(0.5, 0.0))
    model = walkers([drum], [(5.0, 0.0)], [(0.0, 0.0)])
    model.step()
    before = model.obstacles.outline(drum)[0].copy()
    model.particles.array("push")[:] = np.nan
    with pytest.raises(StepFailed):
        model.step()
    assert (model.obstacles.outline(drum)[0] == before).all()
    model.particles.assign("push", (0.0, 0.0))
    model.step()
    assert model.obstacles.outline(drum)[0] == pytest.approx(before + np.array([0.5, 0.0]))


# -- tiers, stages, agents of their own will -------------------------------------------


class Stroller(Walker):
    """Moves, and then one more step of its own."""

    def move(self):
        super().move()
        self.position = self.position + np.array([0.0, 0.05])


def test_a_displacement_of_ones_own_meets_walls_too():
    fence = Polyline([(-9.0, 1.0), (9.0, 1.0)], behaviour="slide")
    model = walkers([fence], [(0.0, 0.98)], [(0.5, 0.0)], agent_class=Stroller)
    for _ in range(3):
        model.step()
    x, y = model.particles.position[0]
    assert (x, y) == pytest.approx((1.5, 1.0), abs=NEAR)
    assert y < 1.0
    drain = Polyline([(-9.0, 1.0), (9.0, 1.0)], behaviour="absorb")
    model = walkers([drain], [(0.0, 0.98)], [(0.0, 0.5)], agent_class=Stroller)
    model.step()
    assert (len(model.agents), drain.absorbed) == (0, 1)


@pytest.mark.parametrize(
    "integrator", ["euler", "predictor_corrector", "rk4", "strang", "leap_frog", "velocity_verlet"]
)
def test_tiers_agree_among_obstacles(integrator):
    class Drifter(InertialParticle, Walker):
        pass

    models = []
    for tier in ("compiled", "agents"):
        draw = np.random.default_rng(3)
        obstacles = Obstacles(random_obstacles(draw, moving=True), squeezed="remove")
        model = ParticleModel(
            Drifter, core_radius=0.1, dt=0.2, obstacles=obstacles, tier=tier,
            laws=[PUSH, Flow(lambda x, y, t: (0.5 - y, x - 0.5))], integrator=integrator,
            domain=Bounded((0, 0), (1, 1)), rng=1,
        )  # fmt: skip
        positions = draw.random((60, 2))
        fit = ~rooms_of(list(obstacles), positions, 0.0)[1] & ~obstacles.near(positions, 1e-6)
        count = int(fit.sum())
        Drifter.create_agents(
            model, count, position=positions[fit], push=draw.normal(size=(count, 2)),
            velocity=draw.normal(size=(count, 2)),
        )  # fmt: skip
        models.append(model)
    for _ in range(4):
        for model in models:
            model.step()
        one, other = (model.particles for model in models)
        assert len(one) == len(other)
        for name in one.names:
            assert np.abs(getattr(one, name) - getattr(other, name)).max() <= 1e-12, name
    assert models[0].obstacles.absorbed == models[1].obstacles.absorbed


def test_trial_places_stop_in_front_of_walls():
    seen = []

    class Watcher(Walker):
        def dynamics(self):
            seen.append(self.position[0])
            return super().dynamics()

    wall = Polyline(WALL, behaviour="bounce")
    model = walkers([wall], [(0.5, 0.0)], [(2.0, 0.0)], agent_class=Watcher, integrator="rk4")
    model.step()
    assert max(seen) == pytest.approx(1.0, abs=NEAR)
    assert max(seen) < 1.0
    assert model.particles.position[0, 0] == pytest.approx(-0.5, abs=NEAR)


def test_agents_remember_their_domain():
    model = walkers([square((0.5, 0.5), 0.2)], [(0.1, 0.1), (0.9, 0.9)], [(0.01, 0.0)] * 2)
    model.step()
    numbers = model.particles.array("_domain")
    limits = {domain.number: domain.limits for domain in model.obstacles.domains()}
    for number, (x, y) in zip(numbers.tolist(), model.particles.position, strict=True):
        x_min, y_min, x_max, y_max = limits[number]
        assert x_min <= x <= x_max
        assert y_min <= y <= y_max
    assert model.obstacles.skipped == 1.0


def test_explain_tells_of_obstacles():
    model = walkers([square((0.5, 0.5), 0.2), square((2, 2), 1, spin=1)], [(0, 0)], [(0, 0)])
    assert dict(explain(model))["obstacles"].startswith("2 obstacles, 1 moving, 8 walls")
    assert "obstacles" not in dict(explain(walkers(None, [(0, 0)], [(0, 0)])))


@pytest.mark.parametrize(("domain", "reach"), [("bounded", 0.15), ("open", 0.5), ("periodic", 0.3)])
def test_nobody_gets_in_through_or_lost(domain, reach):
    """The short form of the program ``tests/obstacle_soak.py``."""
    for seed in range(3):
        model, made = wander(seed, 1500, 20, domain=domain, reach=reach)
        assert made > 5000
    assert model.obstacles.absorbed or model.obstacles.squeezed or domain == "open"


def test_rooms_notice_who_has_gone_through_a_wall():
    """The check of the soak can fail."""
    room = Polygon([(0.2, 0.2), (0.8, 0.2), (0.8, 0.8)], name="room")
    inner = np.array([[0.7, 0.4]])
    members, solid = rooms_of([room], inner, 0.0)
    assert members.any()
    assert solid.all()
