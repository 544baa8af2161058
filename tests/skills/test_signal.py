"""A signal on patches: its total, its spreading, how it is laid and sensed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from apmethod import (
    Animal,
    Bounded,
    Column,
    Diffusion,
    Domain,
    Follow,
    Life,
    Obstacles,
    Open,
    ParticleModel,
    Periodic,
    SignalField,
    StepFailed,
    Unstable,
    set_threads,
    square,
)
from apmethod.compile.threads import threads
from apmethod.skills.patches import lay_patches
from apmethod.skills.spread import METHODS

SIDE = 12.0
PERIODIC, BOUNDED = Periodic((0, 0), (SIDE, SIDE)), Bounded((0, 0), (SIDE, SIDE))
MIXED = Domain((0, 0), (SIDE, SIDE), ("periodic", "bounded"))


def pillar(x, y):
    """An obstacle in the middle, and one in a corner."""
    return ((abs(x - 6) < 2) & (abs(y - 5) < 1)) | ((x < 2) & (y < 2))


def field(patch=1.0, **options):
    rates = {"production": 0.3, "diffusivity": 0.2, "evaporation": 0.1}
    return SignalField(patch, **(rates | options))


def scene(signal, *, count=60, domain=PERIODIC, sensitivity=0.1, positions=None, **options):
    """Animals at random places that lay and follow a signal."""
    options = {"dt": 0.3, "rng": 1, "core_radius": 3.0, "skills": [signal]} | options
    model = ParticleModel(
        Animal,
        domain=domain,
        laws=[Diffusion(0.05), Follow(signal, sensitivity)],
        **options,
    )
    if positions is None:
        positions = np.random.default_rng(4).random((count, 2)) * SIDE
    Animal.create_agents(model, len(positions), position=positions)
    return model


# -- its total -------------------------------------------------------------------------


@pytest.mark.parametrize("laying", ["nearest", "cloud"])
@pytest.mark.parametrize(
    ("domain", "obstacles"), [(PERIODIC, None), (BOUNDED, None), (MIXED, pillar)]
)
def test_the_total_obeys_eulers_own_form(domain, obstacles, laying):
    """S' = S + dt (alpha N - beta S) in each sub-step, to round-off."""
    signal = field(laying=laying, obstacles=obstacles, start=0.7, diffusivity=1.0)
    model = scene(signal, domain=domain)
    substeps = int(np.ceil(model.dt / signal._spread.largest_step))
    assert substeps == 2
    expected = signal.total
    for _ in range(20):
        model.step()
        for _ in range(substeps):
            expected += model.dt / substeps * (0.3 * 60 - 0.1 * expected)
        assert signal.total == pytest.approx(expected, rel=1e-13)
    assert (signal.values[signal.patches.free == 0.0] == 0.0).all()


def test_the_exact_total_is_that_of_its_equation():
    signal = field(method="exact")
    model = scene(signal)
    for step in range(1, 11):
        model.step()
        expected = 0.3 * 60 / 0.1 * -np.expm1(-0.1 * 0.3 * step)
        assert signal.total == pytest.approx(expected, rel=1e-12)


def test_the_implicit_total_obeys_backward_eulers_form_around_obstacles():
    """S' (1 + beta dt) = S + dt alpha N."""
    signal = field(method="implicit", obstacles=pillar, start=0.7, diffusivity=20.0)
    model = scene(signal, domain=MIXED)
    expected = signal.total
    for _ in range(5):
        model.step()
        expected = (expected + model.dt * 0.3 * 60) / (1.0 + 0.1 * model.dt)
        assert signal.total == pytest.approx(expected, rel=1e-12)


@settings(max_examples=15, deadline=None)
@given(
    st.integers(1, 5), st.integers(1, 5), st.floats(0.0, 5.0), st.floats(0.0, 3.0),
    st.floats(0.01, 20.0), st.sampled_from(["euler", "implicit"]), st.integers(0, 2**31),
)  # fmt: skip
def test_no_signal_becomes_negative(wide, high, diffusivity, evaporation, dt, method, seed):
    draw = np.random.default_rng(seed)
    domain = Domain((0, 0), (wide, high), ("periodic", "bounded"))
    blocked = draw.random((wide, high)) < 0.3
    blocked[0, 0] = False
    patches = lay_patches(domain, 1.0, blocked)
    spread = METHODS[method](patches, diffusivity, evaporation)
    start = draw.random((wide, high)) * patches.free
    later = spread.advance(start, np.zeros((wide, high)), dt)
    assert later.min() >= -1e-15
    assert later.sum() <= start.sum() * (1 + 1e-12)


# -- its spreading ---------------------------------------------------------------------


def brute_force(patches, diffusivity, evaporation):
    """The matrix of Ds L - beta, patch by patch and neighbour by neighbour."""
    wide, high = patches.shape
    matrix = -evaporation * np.eye(wide * high)
    for i in range(wide):
        for j in range(high):
            for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                k, m = i + step[0], j + step[1]
                if patches.periodic[0]:
                    k %= wide
                if patches.periodic[1]:
                    m %= high
                if 0 <= k < wide and 0 <= m < high and patches.free[i, j] * patches.free[k, m]:
                    matrix[i * high + j, i * high + j] -= diffusivity / patches.area
                    matrix[i * high + j, k * high + m] += diffusivity / patches.area
    return matrix


@pytest.mark.parametrize("domain", [PERIODIC, BOUNDED, MIXED])
def test_each_method_solves_the_patches_equation(domain):
    patches = lay_patches(domain, 2.0)
    matrix, dt = brute_force(patches, 0.7, 0.2), 1.3
    draw = np.random.default_rng(0)
    start, source = draw.random((2, *patches.shape))
    grown = expm(matrix * dt)
    exact = grown @ start.ravel() + np.linalg.solve(
        matrix, (grown - np.eye(len(matrix))) @ source.ravel()
    )
    found = METHODS["exact"](patches, 0.7, 0.2).advance(start, source, dt)
    np.testing.assert_allclose(found.ravel(), exact, rtol=1e-12)
    backward = np.linalg.solve(
        np.eye(len(matrix)) - dt * matrix, start.ravel() + dt * source.ravel()
    )
    found = METHODS["implicit"](patches, 0.7, 0.2).advance(start, source, dt)
    np.testing.assert_allclose(found.ravel(), backward, rtol=1e-12)


@pytest.mark.parametrize("method", ["euler", "implicit"])
def test_the_methods_are_of_first_order_around_obstacles(method):
    patches = lay_patches(BOUNDED, 1.0, pillar)
    matrix = brute_force(patches, 1.0, 0.5)
    start = np.random.default_rng(0).random(patches.shape) * patches.free
    exact = (expm(matrix) @ start.ravel()).reshape(patches.shape)
    errors = []
    for steps in (16, 32, 64):
        spread, values = METHODS[method](patches, 1.0, 0.5), start
        for _ in range(steps):
            values = spread.advance(values, np.zeros(patches.shape), 1.0 / steps)
        errors.append(np.abs(values - exact).max() / exact.max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.15)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(1.0, abs=0.1)
    assert errors[2] < 7e-3


def test_a_spot_spreads_like_the_heat_kernel():
    """Second order in the patch's side."""
    errors = []
    for count in (48, 96, 192):
        patches = lay_patches(PERIODIC, SIDE / count)
        x, y = patches.centres()
        r_2 = (x - 6) ** 2 + (y - 6) ** 2
        found = METHODS["exact"](patches, 0.5, 0.2).advance(np.exp(-r_2), np.zeros(x.shape), 0.5)
        exact = np.exp(-0.1) * np.exp(-r_2 / 2.0) / 2.0
        errors.append(np.abs(found - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)
    assert errors[2] < 1e-3


# -- how it is laid and sensed ---------------------------------------------------------


@pytest.mark.parametrize(
    ("sensing", "obstacles"), [("bilinear", None), ("vicinity", None), ("vicinity", pillar)]
)
def test_a_linear_signal_is_sensed_exactly(sensing, obstacles):
    signal = field(sensing=sensing, obstacles=obstacles, start=lambda x, y: 2.0 + 0.3 * x - 0.5 * y)
    inside = 1.0 if sensing == "bilinear" else 0.0  # bilinear sees the border as flat
    positions = np.random.default_rng(2).random((50, 2)) * (SIDE - 2 * inside) + inside
    model = scene(signal, domain=BOUNDED, positions=positions)
    signal.perceived()
    x, y = positions.T
    near = slice(None) if sensing == "vicinity" else np.abs(positions - 6).max(axis=1) < 4.5
    gradient = model.particles.signal_gradient[near]
    np.testing.assert_allclose(gradient, np.tile([0.3, -0.5], (len(gradient), 1)), rtol=1e-11)
    value = model.particles.signal[near]
    np.testing.assert_allclose(value, (2.0 + 0.3 * x - 0.5 * y)[near], rtol=1e-11)


def test_nobody_is_pushed_by_its_own_signal():
    """Laid by cloud and read bilinear, at any place of a patch, once it has spread, too."""
    signal = field()
    model = scene(signal, positions=np.array([[3.21, 7.93]]), sensitivity=1.0)
    for _ in range(5):
        model.step()
    np.testing.assert_allclose(model.particles.position, [[3.21, 7.93]], rtol=1e-13)


def test_a_view_cone_sees_what_is_ahead_only():
    class Hunter(Animal):
        heading = Column(2, start=(1.0, 0.0))
        view = Column(start=np.cos(0.25 * np.pi))

    signal = field(sensing="vicinity", view="view", start=lambda x, y: np.abs(x - 6.0))
    model = ParticleModel(
        Hunter, core_radius=3.0, domain=BOUNDED, laws=[Follow(signal, 0.1)], skills=[signal],
        dt=0.1,
    )  # fmt: skip
    Hunter.create_agents(model, 2, position=(6.0, 6.0), heading=[(1.0, 0.0), (-2.0, 0.0)])
    signal.perceived()
    np.testing.assert_allclose(
        model.particles.signal_gradient, [[1.0, 0.0], [-1.0, 0.0]], atol=1e-12
    )


def test_animals_may_perceive_differently_far():
    """One sees the food 3 patches away, one does not, and nobody farther than the core radius."""

    class Eyed(Animal):
        sight = Column()

    signal = field(sensing="vicinity", sight="sight", start=lambda x, y: 1.0 * (x == 8.5))
    model = ParticleModel(Eyed, core_radius=4.0, domain=BOUNDED, skills=[signal], dt=0.1)
    Eyed.create_agents(model, 3, position=(5.5, 6.5), sight=[2.0, 4.0, 1e9])
    signal.perceived()
    near, far, farther = model.particles.signal_gradient
    assert np.array_equal(farther, far)
    assert near.tolist() == [0.0, 0.0]
    assert far[0] > 0.01


@pytest.mark.parametrize("sensing", ["nearest", "bilinear", "vicinity"])
@pytest.mark.parametrize("laying", ["nearest", "cloud"])
def test_both_tiers_lay_and_sense_alike(laying, sensing):
    models = []
    for tier in ("compiled", "agents"):
        signal = field(laying=laying, sensing=sensing, obstacles=pillar)
        models.append(scene(signal, count=30, tier=tier, domain=MIXED))
        for _ in range(3):
            models[-1].step()
    for name in ("position", "signal", "signal_gradient"):
        ours, theirs = (getattr(model.particles, name) for model in models)
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-14)


class Hunter(Animal):
    sight = Column(start=2.0)
    view = Column(start=0.3)


def test_both_tiers_follow_what_they_see_alike():
    draw, models = np.random.default_rng(6), []
    options = {
        "position": SIDE * draw.random((30, 2)), "sight": draw.uniform(1.0, 4.0, 30),
        "view": draw.uniform(-1.0, 0.9, 30),
    }  # fmt: skip
    for tier in ("compiled", "agents"):
        signal = field(sensing="vicinity", sight="sight", view="view", obstacles=pillar)
        model = ParticleModel(
            Hunter, core_radius=3.0, domain=MIXED, laws=[Diffusion(0.05), Follow(signal, 0.5)],
            skills=[signal, Life()], dt=0.3, tier=tier,
        )  # fmt: skip
        Hunter.create_agents(model, 30, **options)
        for _ in range(3):
            model.step()
        models.append(model)
    assert (models[0].particles.heading != (1.0, 0.0)).any(axis=1).all()
    for name in ("position", "heading", "signal", "signal_gradient"):
        ours, theirs = (getattr(model.particles, name) for model in models)
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-14)


@pytest.mark.filterwarnings("ignore::apmethod.Unstable")  # patches much smaller than agents feel
@pytest.mark.parametrize("sensing", ["bilinear", "vicinity"])
def test_threads_change_no_bit(sensing):
    found, before = [], threads()
    try:
        for count in (1, 2, 3):
            set_threads(count)
            model = scene(
                field(sensing=sensing, patch=SIDE / 600), count=20_000, core_radius=0.1, dt=0.02
            )
            model.step()
            model.step()
            found.append((model.particles.position, model.skills[0].values))
    finally:
        set_threads(before)
    for position, values in found[1:]:
        assert np.array_equal(position, found[0][0])
        assert np.array_equal(values, found[0][1])


# -- in a scene ------------------------------------------------------------------------


def test_a_scene_may_have_several_signals():
    class Ant(Animal):
        food = Column(start=0.5)
        home = Column(kept=False)
        home_gradient = Column(2, kept=False)

    one, other = field(), field(name="home", by="food", diffusivity=0.05)
    model = ParticleModel(
        Ant,
        core_radius=3.0,
        domain=PERIODIC,
        laws=[Follow(one, 0.1), Follow(other, -0.2)],
        skills=[one, other],
        dt=0.5,
    )
    Ant.create_agents(model, 5, position=[(2 * k + 0.3, 1.1 * k) for k in range(5)])
    model.step()
    model.step()
    assert one.total == pytest.approx(2 * other.total)
    assert {"signal_total", "home_total"} <= set(model.diagnostics())
    assert model.particles.agents[0].home_gradient.shape == (2,)


def test_walls_that_stop_animals_hold_the_signal_back():
    walls = Obstacles([square((6.0, 6.0), 4.0), square((1.0, 1.0), 1.0)])
    signal = field(patch=0.5, obstacles=walls)
    outside = np.array([[3.1, 6.0], [9.0, 9.0]])
    model = scene(signal, positions=outside, obstacles=walls, domain=BOUNDED)
    x, y = signal.patches.centres()
    inside = (np.maximum(abs(x - 6), abs(y - 6)) < 2) | (np.maximum(abs(x - 1), abs(y - 1)) < 0.5)
    assert np.array_equal(signal.patches.free == 0.0, inside)
    for _ in range(60):
        model.step()
    assert (signal.values[inside] == 0.0).all()
    assert (signal.values[~inside] > 0.0).all()


def test_a_failed_step_takes_the_signal_back(monkeypatch):
    signal = field()
    model = scene(signal)
    model.step()
    before = signal.values.copy()
    monkeypatch.setattr(model.motion, "arrived", lambda: model.particles.array("mass").fill(np.nan))
    with pytest.raises(StepFailed):
        model.step()
    assert np.array_equal(signal.values, before)


@pytest.mark.parametrize("sensing", ["nearest", "bilinear", "vicinity"])
def test_nobody_and_all_on_one_point_are_defined(sensing):
    empty = scene(field(sensing=sensing), positions=np.empty((0, 2)))
    empty.step()
    assert empty.skills[0].total == 0.0
    crowd = scene(field(sensing=sensing), positions=np.full((500, 2), 6.1))
    for _ in range(10):
        crowd.step()
    with pytest.warns(Unstable, match=r"step 11 .*: law 'follows \w+' allows at most"):
        crowd.step()
    assert np.isfinite(crowd.particles.position).all()
    assert crowd.skills[0].total > 0.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"patch": 0.7}, "patch is 0.7 and the domain is 12 long"),
        ({"patch": 4.0}, "patch is 4 and the core radius is 3"),
        ({"patch": 0.0}, "patch is 0.0"),
        ({"production": -1.0}, "production is -1.0"),
        ({"diffusivity": np.nan}, "diffusivity is nan"),
        ({"evaporation": "much"}, "evaporation is 'much'"),
        ({"method": "rk4"}, "method is 'rk4'; it must be one of euler, exact, implicit"),
        ({"sensing": "smell"}, "sensing is 'smell'"),
        ({"diffusivity": 5.0, "substeps": False}, "sub-stepping is off"),
        ({"method": "exact", "obstacles": pillar}, "knows no obstacles"),
        ({"obstacles": lambda x, y: x > -1}, "some patch must be free"),
        ({"obstacles": np.zeros((3, 3))}, "obstacles has shape"),
        ({"start": np.zeros(7)}, "start has shape"),
        ({"by": "charm"}, "reads column 'charm'"),
        ({"view": "view"}, "view is 'view' and sensing 'bilinear'; it needs 'vicinity'"),
        ({"sight": "sight"}, "sight is 'sight' and sensing 'bilinear'; it needs 'vicinity'"),
        ({"sight": "eyes", "sensing": "vicinity"}, "reads column 'eyes'"),
        ({"view": "eyes", "sensing": "vicinity"}, "reads column 'eyes'"),
        ({"name": "my scent"}, "name is 'my scent'"),
    ],
)
def test_bad_input_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        scene(field(**options))


def test_an_open_domain_is_refused():
    with pytest.raises(ValueError, match="bounded or periodic"):
        scene(field(), domain=Open())


def test_a_step_too_long_for_the_steepest_peak_is_refused():
    signal = field(start=lambda x, y: 100.0 * np.exp(-((x - 6) ** 2) - (y - 6) ** 2))
    with pytest.raises(ValueError, match="unstable"):
        scene(signal, sensitivity=1.0)
