"""Diffusion velocities: momentum, limits, stability, and what is refused."""

import numpy as np
import pytest

from apmethod import (
    FORMS,
    INTEGRATORS,
    KERNELS,
    AgentParticle,
    DiffusingParticle,
    Diffusion,
    Flow,
    InertialParticle,
    Law,
    ParticleModel,
    Periodic,
    Unstable,
)
from samples import build, rotation


def velocities(model):
    model.step()
    return model.particles.array("_rate")


def test_only_the_blob_form_keeps_momentum():
    share = {}
    for form in FORMS:
        model = build(400, form=form, flow=None, integrator="euler")
        rate, mass = velocities(model), model.particles.mass
        share[form] = np.abs(mass @ rate).max() / (mass @ np.abs(rate)).max()
    assert share["blob"] < 1e-14
    assert share["plain"] > 1e-5
    assert share["paper"] > 1e-5


@pytest.mark.parametrize("form", list(FORMS))
def test_velocity_is_limited(form):
    """A light agent beside heavy ones would be thrown out by a first-order formula."""
    positions = np.array([[0.0, 0.0], [0.03, 0.0], [0.0, 0.03]])
    model = build(positions=positions, form=form, flow=None, integrator="euler")
    model.particles.assign("mass", [1e-12, 1.0, 1.0])
    rate = velocities(model)
    largest = 6.0 * 1e-2 / model.bus.smoothing_length
    assert np.hypot(*rate.T).max() <= largest * (1.0 + 1e-12)


def wave_growth(form, kernel, share):
    """How the amplitude of the finest dangerous wave changes over 40 steps at a share of
    the largest stable step, on a periodic lattice."""
    count = 48
    side = np.arange(count) / count
    x, y = (part.ravel() for part in np.meshgrid(side, side))
    spacing, chosen = 1.0 / count, KERNELS[kernel]
    h = 2.0 * spacing
    k, transform = chosen.transform
    worst = k[np.argmax(k * k * FORMS[form].decay(transform))] / h
    waves = 2.0 * np.pi * round(worst / (2.0 * np.pi))
    model = build(
        positions=np.column_stack([(x + 1e-6 * np.sin(waves * x)) % 1.0, y]),
        form=form, kernel=kernel, core_radius=h * chosen.support, flow=None, integrator="euler",
        domain=Periodic((0, 0), (1, 1)), dt=1e-12,
    )  # fmt: skip
    model.particles.assign("mass", 1.0 / count**2)
    model.dt = share * model.largest_dt()  # set in a built model, and not refused

    def amplitude():
        shift = (model.particles.position[:, 0] - x + 0.5) % 1.0 - 0.5
        return abs(shift @ np.sin(waves * x))

    before = amplitude()
    for _ in range(40):
        model.step()
    return amplitude() / before


@pytest.mark.parametrize(
    ("form", "kernel"),
    [("plain", "gaussian"), ("plain", "wendland_c4"), ("plain", "gaussian_4"),
     ("blob", "gaussian"), ("paper", "gaussian")],
)  # fmt: skip
def test_the_stability_limit_is_where_waves_begin_to_grow(form, kernel):
    assert wave_growth(form, kernel, 0.85) < 1.0
    with pytest.warns(Unstable, match=r"^step 1 .*the time step \S+ is unstable: .* at most"):
        assert wave_growth(form, kernel, 1.15) > 10.0


def test_an_unstable_step_is_refused_with_both_numbers():
    with pytest.raises(ValueError, match=r"dt is 0.5, which is unstable: .*at most 0\.\d+"):
        build(10, core_radius=0.2, dt=0.5)


@pytest.mark.parametrize("form", list(FORMS))
@pytest.mark.parametrize("kernel", list(KERNELS))
def test_every_combination_refuses_a_step_outside_its_limit(form, kernel):
    if form == "blob" and KERNELS[kernel].order > 2:
        return  # refused for the kernel, see below
    for name, integrator in INTEGRATORS.items():
        options = {"form": form, "kernel": kernel, "integrator": name, "core_radius": 0.2}
        if integrator.of == "acceleration":
            with pytest.raises(ValueError, match=f"{name}', .* unstable at every dt with a law"):
                build(0, agent_class=InertialParticle, **options)
            continue
        limit = build(0, **options).largest_dt()
        assert build(0, dt=0.999 * limit, **options).largest_dt() == limit
        with pytest.raises(ValueError, match=rf"dt is \S+, which is unstable: .* {limit:.6g}"):
            build(0, dt=1.001 * limit, **options)


@pytest.mark.parametrize(
    ("form", "kernel", "limit"),
    [("plain", "gaussian", 1.36), ("plain", "gaussian_4", 0.60), ("blob", "gaussian", 0.81),
     ("plain", "cubic", 0.90), ("plain", "wendland_c4", 0.60)],
)  # fmt: skip
def test_limits_of_the_second_order_rules_by_hand(form, kernel, limit):
    """D dt/h^2 <= 2 / max(k^2 g(k)), with the maxima read off the transforms' curves."""
    assert Diffusion(1.0, form).largest_step(KERNELS[kernel], 1.0, 2.0) == (
        pytest.approx(limit, rel=0.02)
    )


def test_the_chosen_step_is_inside_the_limit():
    model = build(10, dt=None)
    assert model.next_dt() == pytest.approx(min(0.7 * model.largest_dt(), 0.05))
    assert build(10, dt=None, integrator="euler", core_radius=2.0).next_dt() == (
        pytest.approx(0.005, rel=1e-6)
    )


def test_a_split_off_rotation_does_not_shorten_the_step_and_a_strain_does():
    """Rigid rotation commutes with diffusion; it is carried in steps of its own."""
    options = {"dt": None, "integrator": "strang", "core_radius": 2.0}
    turned, sheared = build(10, **options), build(10, flow=lambda x, y, t: (y, 0.0), **options)
    assert turned.next_dt() == pytest.approx(0.7 * turned.largest_dt())
    assert sheared.next_dt() == pytest.approx(0.2 * np.sqrt(2.0), rel=1e-6)


def test_a_strain_that_comes_within_a_step_shortens_it():
    model = build(10, dt=None, integrator="strang", core_radius=2.0,
                  flow=lambda x, y, t: (t * y, 0.0))  # fmt: skip
    assert model.next_dt() < 0.1 * model.largest_dt()


def test_a_rotation_without_diffusion_takes_a_radian_a_step():
    model = ParticleModel(DiffusingParticle, core_radius=1.0, laws=[Flow(rotation)],
                          integrator="strang")  # fmt: skip
    DiffusingParticle.create_agents(model, 3, position=[(0.0, 0.0), (1.0, 0.0), (0.0, 2.0)])
    assert model.next_dt() == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"diffusivity": -1.0}, "diffusivity is -1.0; it must be a finite number, 0 or more"),
        ({"diffusivity": np.nan}, "diffusivity is nan"),
        ({"diffusivity": 1.0, "form": "laplace"}, "form is 'laplace'; it must be one of paper"),
        ({"diffusivity": 1.0, "limit": -1.0}, "limit is -1.0"),
    ],
)
def test_bad_diffusion_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        Diffusion(**arguments)


def test_the_blob_form_needs_a_positive_kernel():
    with pytest.raises(ValueError, match="kernel is 'gaussian_4', which makes densities negative"):
        build(10, kernel="gaussian_4", form="blob")


@pytest.mark.parametrize("dt", [0.0, -1.0, np.nan, np.inf, "soon"])
def test_a_bad_time_step_is_refused(dt):
    with pytest.raises(ValueError, match=r"dt is .*; it must be a finite number above 0"):
        ParticleModel(AgentParticle, core_radius=1.0, dt=dt)


def test_a_step_that_nothing_limits_must_be_given():
    model = ParticleModel(AgentParticle, core_radius=1.0)
    with pytest.raises(ValueError, match="dt is None and no law limits it; give dt"):
        model.step()


@pytest.mark.parametrize("field", [lambda x, y: (y, x), lambda x, y, t: 1.0])
def test_a_flow_must_be_a_velocity_field(field):
    with pytest.raises(ValueError, match=r"is not V\(x, y, t\) giving \(x, y\)"):
        Flow(field)


def test_a_law_refuses_numbers_that_are_none():
    with pytest.raises(ValueError, match="strength is nan; it must be a finite number"):
        Law("push", lambda agent, p: (p.strength, 0.0), parameters={"strength": np.nan})


def test_no_diffusivity_no_motion():
    model = ParticleModel(AgentParticle, core_radius=1.0, laws=[Diffusion(0.0)], dt=1e9,
                          kernel="gaussian")  # fmt: skip
    agent = AgentParticle(model, position=(1.0, 2.0))
    model.step()
    assert agent.position.tolist() == [1.0, 2.0]
