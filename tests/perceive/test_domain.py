"""Borders: wrapping, reflecting, and what they refuse."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apmethod import (
    AgentParticle,
    Bounded,
    Domain,
    Mirrored,
    Open,
    ParticleModel,
    Periodic,
)
from apmethod.contribute.terms import density

anywhere = st.floats(-1e6, 1e6)


@given(anywhere, anywhere)
def test_every_place_ends_inside(x, y):
    for domain in (Bounded((-1.0, 2.0), (0.5, 7.0)), Periodic((-1.0, 2.0), (0.5, 7.0))):
        place = np.array(domain.place(x, y))
        assert (place >= domain.lower).all()
        assert (place <= domain.upper).all()


@given(st.floats(-0.999, 0.499), st.integers(-5, 5))
def test_a_period_more_is_the_same_place(x, turns):
    domain = Periodic((-1.0, 0.0), (0.5, 1.0))
    assert domain.place(x + 1.5 * turns, 0.5)[0] == pytest.approx(x, abs=1e-12)


def test_a_bounded_side_reflects():
    domain = Bounded((0.0, 0.0), (1.0, 1.0))
    assert domain.place(-0.25, 1.25) == pytest.approx((0.25, 0.75))
    assert domain.place(2.25, 0.5) == pytest.approx((0.25, 0.5))


def test_an_open_domain_changes_nothing():
    assert Open().place(-1e300, 5.0) == (-1e300, 5.0)


def test_an_agent_that_is_set_outside_ends_where_the_border_lets_it():
    model = ParticleModel(AgentParticle, core_radius=0.1, domain=Periodic((0, 0), (1, 1)))
    agent = AgentParticle(model, position=(0.5, 0.5))
    agent.position = (1.25, -0.25)
    assert agent.position == pytest.approx([0.25, 0.75])


def test_an_agent_cannot_start_outside():
    model = ParticleModel(AgentParticle, core_radius=0.1, domain=Bounded((0, 0), (1, 1)))
    with pytest.raises(ValueError, match=r"position is \[2.0, 0.5\] \(agent 1 of 2 given\)"):
        AgentParticle.create_agents(model, 2, position=[[0.5, 0.5], [2.0, 0.5]])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (((0, 0), (1, 0), "bounded"), "from 0.0 to 0.0 along y"),
        (((0, 0), (np.inf, 1), "periodic"), "from 0.0 to inf along x"),
        (((0, 0), (1, 1), "closed"), "borders is 'closed'; each must be one of open, bounded"),
        (((0, 0, 0), (1, 1, 1), "bounded"), "each must be two numbers"),
    ],
)
def test_bad_domains_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        Domain(*arguments)


def test_a_mirrored_side_completes_the_density():
    """Half a lattice and its mirror images have the density of the whole lattice."""
    x, y = (part.ravel() for part in np.meshgrid(*[np.arange(-9.5, 10.0)] * 2))
    places = np.column_stack([x, y])
    whole = ParticleModel(AgentParticle, core_radius=2.5, terms=[density], dt=1.0)
    corner = Mirrored((0.0, 0.0), (10.0, 20.0))
    part = ParticleModel(AgentParticle, core_radius=2.5, terms=[density], dt=1.0, domain=corner)
    inside = (x > 0.0) & (y > 0.0)
    AgentParticle.create_agents(whole, len(places), position=places, mass=1.0)
    AgentParticle.create_agents(part, inside.sum(), position=places[inside], mass=1.0)
    for model in (whole, part):
        model.step()
    near = (x[inside] < 7.0) & (y[inside] < 7.0)
    found, expected = part.particles.density, whole.particles.density[inside]
    assert found[near] == pytest.approx(expected[near], rel=1e-14)


def test_a_mirrored_domain_shorter_than_the_core_radius_is_refused():
    with pytest.raises(ValueError, match="at least one core radius long"):
        ParticleModel(AgentParticle, core_radius=2.0, domain=Mirrored((0, 0), (1, 5)))
