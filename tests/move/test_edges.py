"""Diffusion where sums have little to go by: isolated, coincident, light and massless agents."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import FORMS, DiffusingParticle, Diffusion, ParticleModel

forms = st.sampled_from(list(FORMS))
tiers = st.sampled_from(["compiled", "agents"])
seeds = st.integers(0, 1000)
few = settings(max_examples=12, deadline=None)


def rates(form, positions, masses, tier="compiled", core_radius=0.3):
    """Diffusion velocities of agents at these places, and the model."""
    model = ParticleModel(
        DiffusingParticle, core_radius=core_radius, kernel="gaussian",
        laws=[Diffusion(1e-2, form)], dt=1e-6, tier=tier, rng=1,
    )  # fmt: skip
    DiffusingParticle.create_agents(
        model, len(positions), position=np.asarray(positions, float), mass=np.asarray(masses, float)
    )
    model.step()
    return model.particles.array("_rate").copy(), model


def cloud(seed, count=12):
    draw = np.random.default_rng(seed)
    return draw.uniform(0.0, 0.6, (count, 2)), draw.uniform(0.1, 1.0, count)


@few
@given(forms, tiers, seeds, st.floats(1e-30, 1e30))
def test_an_isolated_agent_has_no_velocity(form, tier, seed, mass):
    positions = np.arange(4)[:, None] * np.array([1.0, 0.5]) + cloud(seed, 4)[0] * 0.1
    rate, model = rates(form, positions, mass, tier)
    assert not rate.any()
    assert np.array_equal(model.particles.position, positions)


@few
@given(forms, tiers, seeds, st.floats(0.01, 0.99))
def test_coincident_agents_are_one_of_their_joint_mass(form, tier, seed, share):
    positions, masses = cloud(seed)
    whole, _ = rates(form, positions, masses, tier)
    parts = np.concatenate([masses, [share * masses[0]]])
    parts[0] *= 1.0 - share
    split, model = rates(form, np.concatenate([positions, positions[:1]]), parts, tier)
    scale = np.abs(whole).max()
    np.testing.assert_allclose(split[:-1], whole, rtol=1e-10, atol=1e-12 * scale)
    np.testing.assert_allclose(split[-1], whole[0], rtol=1e-10, atol=1e-12 * scale)
    first, *_, last = model.particles.position
    np.testing.assert_allclose(first, last, rtol=1e-14)


@few
@given(forms, tiers, seeds, st.integers(1, 4))
def test_massless_agents_are_tracers(form, tier, seed, count):
    """They change nobody's velocity, and their own is finite."""
    positions, masses = cloud(seed)
    alone, _ = rates(form, positions, masses, tier)
    draw = np.random.default_rng(seed + 1)
    tracers = np.concatenate([draw.uniform(0.0, 0.6, (count, 2)), [[5.0, 5.0], [5.0, 5.01]]])
    together, _ = rates(
        form, np.concatenate([positions, tracers]), [*masses, *np.zeros(count + 2)], tier
    )
    np.testing.assert_allclose(
        together[: len(alone)], alone, rtol=1e-10, atol=1e-12 * np.abs(alone).max()
    )
    assert np.isfinite(together).all()
    assert not together[-2:].any()  # neighbours, where the field is zero


@few
@given(forms, tiers, seeds, st.floats(0.0, 150.0))
def test_only_ratios_of_masses_count(form, tier, seed, decades):
    """u -> 0 everywhere is the same flow: A is that of log u."""
    positions, masses = cloud(seed)
    once, _ = rates(form, positions, masses, tier)
    again, _ = rates(form, positions, 10.0**-decades * masses, tier)
    np.testing.assert_allclose(again, once, rtol=1e-9, atol=1e-11 * np.abs(once).max())


@pytest.mark.parametrize(("form", "times"), [("plain", 2.0), ("blob", 4.0)])
def test_a_heavy_agent_drives_off_a_light_one(form, times):
    h, distance = 0.3 / 3.4, 1e-4
    rate, _ = rates(form, [[0.0, 0.0], [distance, 0.0]], [1.0, 1e-12])
    assert rate[1, 0] == pytest.approx(times * 1e-2 * distance / h**2, rel=1e-3)
    assert abs(rate[0, 0]) < 1e-10 * rate[1, 0]
    rate, _ = rates(form, [[0.0, 0.0], [0.2999, 0.0]], [1.0, 1e-12])
    assert rate[1, 0] == pytest.approx(6.0 * 1e-2 / h)
