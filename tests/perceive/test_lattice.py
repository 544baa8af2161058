"""The lattice finds what trying every pair finds, wherever agents stand."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import (
    AgentParticle,
    Bounded,
    Mirrored,
    Open,
    ParticleModel,
    Periodic,
    QuadLattice,
    brute_force_pairs,
)
from apmethod.particles import Particles
from apmethod.perceive.domain import Domain
from samples import build

DOMAINS = {
    "open": Open(),
    "bounded": Bounded((0.0, 0.0), (1.0, 1.0)),
    "periodic": Periodic((0.0, 0.0), (1.0, 1.0)),
    "mirrored": Mirrored((0.0, 0.0), (1.0, 1.0)),
    "pipe": Domain((0.0, 0.0), (1.0, 1.0), ("periodic", "mirrored")),
    "channel": Domain((0.0, 0.0), (1.0, 1.0), ("periodic", "bounded")),
}


def cloud(kind, count, seed, radius):
    """Positions in the unit square, placed to be hard for a lattice."""
    draw = np.random.default_rng(seed)
    positions = draw.random((count, 2))
    if kind == "clustered":
        positions = 0.5 + 0.01 * draw.standard_normal((count, 2))
        positions[: count // 3] = draw.random((count // 3, 2))
        positions = positions.clip(0.0, 1.0)
    elif kind == "lattice":
        positions = draw.integers(0, 11, (count, 2)) / 10.0
    elif kind == "coincident":
        positions = positions[draw.integers(0, max(count // 4, 1), count)]
    elif kind == "cell border":
        positions = (np.round(positions / radius) * radius).clip(0.0, 1.0)
    return positions


def lattice_pairs(positions, radius, domain, level):
    lattice = QuadLattice(Particles(), radius, domain, level)
    from apmethod import neighbour_pairs

    return neighbour_pairs(lattice.sorted(positions))


@settings(max_examples=120, deadline=None)
@given(
    kind=st.sampled_from(["random", "clustered", "lattice", "coincident", "cell border"]),
    domain=st.sampled_from(list(DOMAINS)),
    level=st.integers(0, 3),
    count=st.integers(0, 120),
    radius=st.sampled_from([0.05, 0.1, 0.2, 0.25, 0.1 * np.sqrt(2.0), 0.5]),
    seed=st.integers(0, 2**32),
)
def test_pairs_equal_brute_force(kind, domain, level, count, radius, seed):
    positions = cloud(kind, count, seed, radius)
    found = lattice_pairs(positions, radius, DOMAINS[domain], level)
    assert found.tolist() == brute_force_pairs(positions, radius, DOMAINS[domain]).tolist()


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("shift", [0.0, 1e3, -1e6])
def test_pairs_do_not_depend_on_units_nor_on_where_the_cloud_is(scale, shift):
    positions = (cloud("random", 200, 5, 0.1) + shift) * scale
    found = lattice_pairs(positions, 0.1 * scale, Open(), 1)
    assert found.tolist() == brute_force_pairs(positions, 0.1 * scale).tolist()


def test_agents_spread_over_a_huge_plane_take_no_huge_table():
    draw = np.random.default_rng(2)
    positions = draw.random((100, 2))
    positions[:4] = [[1e9, 1e9], [-1e9, 1e9], [1e9 + 0.01, 1e9], [0.0, -1e12]]
    found = lattice_pairs(positions, 0.1, Open(), 2)
    assert found.tolist() == brute_force_pairs(positions, 0.1).tolist()
    assert [0, 2] in found.tolist()


@pytest.mark.parametrize("level", [0, 1, 2])
@pytest.mark.parametrize("domain", list(DOMAINS))
def test_one_agent_finds_what_the_population_finds(domain, level):
    model = ParticleModel(
        AgentParticle, core_radius=0.2, domain=DOMAINS[domain], level=level, dt=1.0
    )
    positions = cloud("lattice", 80, 7, 0.2)
    AgentParticle.create_agents(model, len(positions), position=positions)
    found = {
        (i, other._row)
        for i, agent in enumerate(model.particles.agents)
        for other in model.space.neighbours_of(agent)
    }
    pairs = brute_force_pairs(positions, 0.2, DOMAINS[domain])
    assert found == {(i, j) for i, j in pairs} | {(j, i) for i, j in pairs}


#: The paper's Table 1: for an agent in a sub-domain (row, column of the cell, 0 north and
#: west), the sub-domains of each surrounding cell in which neighbours may be.
ALL = {"00", "01", "10", "11"}
TABLE_1 = {
    "00": {"N": ALL, "S": {"00", "01"}, "E": {"00", "10"}, "W": ALL,
           "NW": ALL, "NE": {"00", "10"}, "SW": {"00", "01"}, "SE": {"00"}},
    "01": {"N": ALL, "S": {"00", "01"}, "E": ALL, "W": {"01", "11"},
           "NW": {"01", "11"}, "NE": ALL, "SW": {"01"}, "SE": {"00", "01"}},
    "10": {"N": {"10", "11"}, "S": ALL, "E": {"00", "10"}, "W": ALL,
           "NW": {"10", "11"}, "NE": {"10"}, "SW": ALL, "SE": {"00", "10"}},
    "11": {"N": {"10", "11"}, "S": ALL, "E": ALL, "W": {"01", "11"},
           "NW": {"11"}, "NE": {"10", "11"}, "SW": {"01", "11"}, "SE": ALL},
}  # fmt: skip


@pytest.mark.parametrize("own", list(TABLE_1))
def test_level_1_looks_into_the_sub_domains_of_the_papers_table_1(own):
    """One agent in the middle of each sub-domain of 5 x 5 cells around the cell (2, 2)."""
    centres = (np.arange(10) + 0.5) / 2.0
    x, y = (part.ravel() for part in np.meshgrid(centres, centres))
    lattice = QuadLattice(Particles(), 1.0, level=1)
    # Two corners pin the lattice to whole cells.
    positions = np.vstack([np.column_stack([x, y]), [[0.0, 0.0], [4.99, 4.99]]])
    cells = lattice.sorted(positions)
    row, column = int(own[0]), int(own[1])
    me = np.array([[2.25 + 0.5 * column, 2.75 - 0.5 * row]])
    low, high = cells.around(me)
    found = np.concatenate([cells.row[a:b] for a, b in zip(low[0], high[0], strict=True)])
    looked = {}
    for x, y in positions[found[found < 100]]:
        side = ("S" if y < 2 else "N" if y >= 3 else "") + ("W" if x < 2 else "E" if x >= 3 else "")
        name = f"{int(y % 1.0 < 0.5)}{int(x % 1.0 >= 0.5)}"
        looked.setdefault(side, set()).add(name)
    assert looked.pop("") == ALL
    assert looked == TABLE_1[own]


def test_candidates_fall_with_the_level_as_in_the_papers_table_2():
    """Counted in a periodic square, where every agent has a full surrounding."""
    positions = np.random.default_rng(4).random((20_000, 2))
    radius, domain = 0.05, Periodic((0.0, 0.0), (1.0, 1.0))
    for level in range(4):
        cells = QuadLattice(Particles(), radius, domain, level).sorted(positions)
        share = (2 * 2**level + 1) ** 2 / 4.0**level
        expected = share * len(positions) * radius**2 * len(positions)
        assert cells.candidates() == pytest.approx(expected, rel=0.02)


def test_questions_between_steps_are_answered_from_where_agents_stand():
    model = ParticleModel(AgentParticle, core_radius=0.2, dt=1.0)
    a, b, c = AgentParticle.create_agents(model, 3, position=[[0, 0], [0.1, 0], [1, 0]])
    assert a.neighbours == [b]
    model.step()
    c.position = (0.0, 0.1)
    model.space.forget()
    assert set(a.neighbours) == {b, c}
    b.remove()
    assert a.neighbours == [c]


def test_what_mesa_asks_a_space():
    model = build(50, domain=Periodic((0.0, 0.0), (1.0, 1.0)))
    space = model.space
    assert space.torus
    assert space.bounds == (0.0, 1.0, 0.0, 1.0)
    assert space.get_distance((0.05, 0.5), (0.95, 0.5)) == pytest.approx(0.1)
    assert space.out_of_bounds(np.array([1.5, 0.5]))
    agent = model.agents[0]
    near = space.get_neighbors(agent.position, 0.2)
    assert set(near) == {agent, *agent.neighbours}


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan, np.inf, "wide"])
def test_a_bad_core_radius_is_refused(radius):
    with pytest.raises(ValueError, match=r"core_radius is .*; it must be a finite number above 0"):
        ParticleModel(AgentParticle, core_radius=radius)


def test_a_periodic_domain_must_be_two_core_radii_long():
    with pytest.raises(ValueError, match=r"1 long along x and the core radius is 0\.6"):
        ParticleModel(AgentParticle, core_radius=0.6, domain=Periodic((0, 0), (1, 2)))


@pytest.mark.parametrize("level", [-1, 7, 1.5])
def test_a_bad_level_is_refused(level):
    with pytest.raises(ValueError, match=r"level is .*whole number from 0 to 6"):
        ParticleModel(AgentParticle, core_radius=0.1, level=level)


def test_a_crowd_in_one_cell_is_reported_once():
    model = ParticleModel(AgentParticle, core_radius=1.0, dt=1.0)
    AgentParticle.create_agents(model, 5001, position=(2.0, 3.0))
    with pytest.warns(UserWarning, match=r"around <AgentParticle 1 at \(2, 3\)> .* 5001 others"):
        model.space.take_down()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model.space.take_down()
