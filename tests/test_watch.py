"""A run that turns unstable says so once; one that is lost stops by name."""

import warnings

import numpy as np
import pytest

from apmethod import (
    DiffusingParticle,
    Diffusion,
    Flow,
    FollowDensity,
    Law,
    ParticleModel,
    Periodic,
    StepFailed,
    Unstable,
)
from samples import build


def told(model, steps):
    """What a model warns of in some steps."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(steps):
            model.step()
    return [str(warning.message) for warning in caught if warning.category is Unstable]


@pytest.mark.parametrize("tier", ["compiled", "agents"])
@pytest.mark.parametrize("form", ["paper", "plain", "blob"])
def test_a_healthy_run_says_nothing(form, tier):
    model = build(60, form=form, core_radius=0.4, dt=None, tier=tier)
    assert told(model, 25) == []


def test_a_step_that_has_become_too_long_is_told_once_with_both_numbers():
    model = build(40, core_radius=0.4, dt=1e-2)
    assert told(model, 11) == []
    model.space.core_radius = 0.03
    (message,) = told(model, 40)
    assert message.startswith(
        "step 21 (from time 0.2): the time step 0.01 is unstable: law 'diffusion velocity, blob "
        f"form' allows at most {model.largest_dt():.6g} with the core radius 0.03 of now"
    )


@pytest.mark.parametrize("tier", ["compiled", "agents"])
def test_a_velocity_at_its_limit_is_told(tier):
    model = ParticleModel(
        DiffusingParticle, core_radius=0.3, kernel="gaussian", dt=1e-3, tier=tier,
        laws=[Diffusion(1e-2, limit=1e-3)],
    )  # fmt: skip
    DiffusingParticle.create_agents(model, 12, position=[(0.1 * k, 0.0) for k in range(12)])
    (message,) = told(model, 11)
    assert message.startswith("step 1 (from time 0): law 'diffusion velocity, blob form' is at")
    assert "and 1 more (DiffusingParticle)" in message or "more (DiffusingParticle)" in message


class Hopeful(Diffusion):
    """A diffusion that believes in steps twice as long as it can bear."""

    def largest_step(self, kernel, smoothing_length, reach):
        """Twice the limit."""
        return 2.0 * super().largest_step(kernel, smoothing_length, reach)


@pytest.mark.parametrize(("share", "unstable"), [(0.7, False), (1.5, True)])
@pytest.mark.parametrize("form", ["paper", "plain", "blob"])
def test_a_velocity_that_grows_is_told(form, share, unstable):
    """A lattice, shaken a little, with a step that the law should have refused."""
    side = (np.arange(16) + 0.5) / 16
    places = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    model = ParticleModel(
        DiffusingParticle, core_radius=3.4 * 2.0 / 16, kernel="gaussian", dt=1e-3,
        laws=[Hopeful(1e-2, form)], domain=Periodic((0, 0), (1, 1)),
    )  # fmt: skip
    shaken = (places + 1e-4 * np.random.default_rng(1).normal(size=places.shape)) % 1.0
    DiffusingParticle.create_agents(model, len(places), position=shaken, mass=1.0 / len(places))
    model.dt = share * Diffusion(1e-2, form).largest_step(model.kernel, 2.0 / 16, 2.0)
    messages = told(model, 200)
    if not unstable:
        assert messages == []
        return
    (message,) = messages
    assert "has grown by" in message
    assert "most of all for agents " in message


def test_a_collapsed_core_radius_is_told():
    def sink(x, y, t):
        return -10.0 * (x - 0.5), -10.0 * (y - 0.5)

    model = ParticleModel(
        DiffusingParticle, core_radius=0.4, kernel="gaussian", integrator="midpoint", dt=5e-3,
        laws=[Diffusion(1e-6), Flow(sink)], radius_rule=FollowDensity(),
    )  # fmt: skip
    places = np.random.default_rng(1).random((60, 2))
    DiffusingParticle.create_agents(model, 60, position=places)
    (message,) = told(model, 100)
    assert "the core radius has collapsed to" in message
    assert "at first it was 0.4; agents " in message


def test_agents_that_have_run_out_of_neighbours_are_told_of():
    """A cloud that is torn apart faster than its fixed core radius can bear."""
    model = build(300, core_radius=0.2, flow=lambda x, y, t: (2.0 * x, 2.0 * y), dt=1e-2)
    (message,) = told(model, 200)
    assert "neighbours on average, at first they had" in message


def scattered(form, decades, tier="compiled"):
    """Agents in a periodic square whose masses differ at random, that choose their steps."""
    draw = np.random.default_rng(3)
    model = ParticleModel(
        DiffusingParticle, core_radius=3.4 * 2.0 / 14, kernel="gaussian", integrator="midpoint",
        laws=[Diffusion(1e-2, form)], domain=Periodic((0, 0), (1, 1)), tier=tier,
    )  # fmt: skip
    masses = 10.0 ** (-decades * draw.random(196))
    DiffusingParticle.create_agents(model, 196, position=draw.random((196, 2)), mass=masses)
    return model


@pytest.mark.parametrize("form", ["plain", "blob"])
def test_steps_are_shorter_between_uneven_neighbours_and_stable(form):
    model = scattered(form, 4)
    even = model.margin * model.largest_dt()
    first = model.next_dt()
    assert first < 0.5 * even  # by the masses, as nobody has received a density
    assert told(model, 200) == []
    assert 5.0 < model.watch.unevenness < 40.0
    assert model.next_dt() < 0.6 * even


def test_a_step_too_long_between_uneven_neighbours_is_told_with_both_numbers():
    model = scattered("plain", 4)
    model.dt = 0.9 * model.largest_dt()
    (message,) = told(model, 11)
    assert f"the time step {model.dt:.6g} is unstable" in message
    assert "of now, as one of two neighbours typically stands for" in message


def test_even_agents_take_whole_steps_however_they_stand():
    model = scattered("blob", 0)
    assert told(model, 11) == []
    assert model.next_dt() == pytest.approx(model.margin * model.largest_dt(), rel=1e-12)


def test_massless_agents_make_nobody_uneven():
    model = scattered("plain", 0)
    model.particles.array("mass")[::2] = 0.0
    assert told(model, 11) == []
    assert model.watch.unevenness < 1.65


def test_neighbours_too_uneven_for_the_form_are_told_of():
    (message,) = told(scattered("paper", 6), 11)
    assert "times the area (mass over density) of the other" in message
    assert "by the form 'blob' they do" in message


class Hurried(Law):
    """A law that limits its own speed and knows nothing of unevenness."""

    def largest_speed(self, smoothing_length):
        """Twice what the formula gives."""
        return 0.02


def test_a_law_that_limits_itself_need_not_know_of_unevenness():
    model = ParticleModel(
        DiffusingParticle, core_radius=0.4, domain=Periodic((0, 0), (1, 1)), dt=1e-2,
        laws=[Hurried("hurried", lambda agent, p: (0.01, 0.0))],
    )  # fmt: skip
    draw = np.random.default_rng(1)
    places, masses = draw.random((60, 2)), draw.random(60)
    DiffusingParticle.create_agents(model, 60, position=places, mass=masses)
    assert told(model, 11) == []
    assert model.watch.share_left() == 1.0


def test_unevenness_is_the_same_in_both_tiers():
    ours = [scattered("plain", 3, tier) for tier in ("compiled", "agents")]
    for model in ours:
        model.step()
    assert ours[0].watch.unevenness == pytest.approx(ours[1].watch.unevenness, rel=1e-9)


def test_agents_of_their_own_mind_are_not_judged():
    class Jumper(DiffusingParticle):
        def dynamics(self):
            return np.array([1.0, 0.0])

    model = build(30, agent_class=Jumper, core_radius=0.4)
    model.motion.laws[0].parameters["limit"] = 1e-9
    assert told(model, 11) == []


def test_nobody_and_one_are_healthy():
    assert told(build(0, dt=1e-3), 11) == []
    assert told(build(1, dt=1e-3), 11) == []


def test_places_that_are_nowhere_stop_the_step_by_name():
    """Before the agents are sorted: sorting a NaN would lead out of the arrays."""

    def wild(x, y, t):
        return (np.inf if x > 0.9 else 0.0), 0.0

    for field in (wild, lambda x, y, t: (np.nan, 0.0), lambda x, y, t: (1e300, 0.0)):
        model = ParticleModel(
            DiffusingParticle, core_radius=0.2, kernel="gaussian", integrator="midpoint",
            laws=[Diffusion(1e-2), Flow(field)], dt=1e-3,
        )  # fmt: skip
        DiffusingParticle.create_agents(model, 2, position=[(0.0, 0.0), (1.0, 0.0)])
        before = model.particles.position
        with (
            np.errstate(all="ignore"),
            pytest.raises(
                StepFailed, match=r"step 1 .*agent \d \(DiffusingParticle\).* went to .*nan|inf|e\+"
            ) as caught,
        ):
            model.step()
        assert caught.value.step == 1
        assert "the agents were put back" in caught.value.__notes__[0]
        np.testing.assert_array_equal(model.particles.position, before)
