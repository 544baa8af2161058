"""Columns behind agents: attributes, growth, removal, and refusals."""

import tracemalloc

import mesa
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesa.agent import AgentSet

from apmethod import AgentParticle, Column, DiffusingParticle, ParticleModel
from samples import build


class Ant(AgentParticle):
    """An agent with columns of its own."""

    energy = Column(start=2.0, minimum=0.0, unit="J")
    heading = Column(2, start=(1.0, 0.0))
    trips = Column(dtype=int)


def nest(count=5):
    model = ParticleModel(Ant, core_radius=0.5, rng=3)
    Ant.create_agents(model, count, position=np.arange(2.0 * count).reshape(count, 2))
    return model


def test_an_attribute_is_a_place_in_a_column():
    model = nest()
    ant = model.agents[2]
    assert ant.energy == 2.0
    assert ant.trips == 0
    assert ant.heading.tolist() == [1.0, 0.0]
    ant.energy, ant.heading, ant.trips = 5.0, (0.0, 1.0), 7
    assert model.particles.energy.tolist() == [2.0, 2.0, 5.0, 2.0, 2.0]
    assert model.particles.heading[2].tolist() == [0.0, 1.0]
    assert isinstance(ant.trips, int)


def test_position_has_mesas_name_too():
    ant = nest().agents[1]
    ant.pos = (0.25, 0.5)
    assert ant.position.tolist() == ant.pos.tolist() == [0.25, 0.5]


def test_what_is_handed_out_cannot_change_the_column_by_accident():
    model = nest()
    before = model.agents[0].position
    with pytest.raises(ValueError, match="read-only"):
        before[0] = 9.0
    with pytest.raises(ValueError, match="read-only"):
        model.particles.position[0, 0] = 9.0
    model.agents[0].position = before + 1.0
    assert before.tolist() == [0.0, 1.0]


@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(0, 1000), max_size=60))
def test_handles_stay_right_while_agents_come_and_go(script):
    """Each agent keeps a number of its own that must always be read back."""
    model = ParticleModel(Ant, core_radius=0.5, rng=3)
    known = {}
    for event in script:
        if event % 3 == 0 and known:
            agent = list(known)[event % len(known)]
            agent.remove()
            del known[agent]
        elif event % 3 == 1:
            known[Ant(model, energy=float(event))] = float(event)
        else:
            for agent in Ant.create_agents(model, event % 4, energy=float(event)):
                known[agent] = float(event)
    assert len(model.particles) == len(known) == len(model.agents)
    assert all(agent.energy == value for agent, value in known.items())
    assert [a.energy for a in model.particles.agents] == model.particles.energy.tolist()


def test_a_removed_agent_says_so():
    model = nest()
    ant = model.agents[0]
    ant.remove()
    ant.remove()  # a second time does nothing, as in Mesa
    with pytest.raises(ValueError, match="agent 1 has been removed"):
        _ = ant.energy
    assert len(model.agents) == len(model.particles) == 4


@settings(max_examples=30, deadline=None)
@given(st.sets(st.integers(0, 29)), st.sets(st.integers(0, 29)))
def test_many_agents_leave_at_once(first, second):
    model = build(30)
    agents = model.particles.agents
    masses = {agent: agent.mass for agent in agents}
    for leaving in (first, second):
        DiffusingParticle.remove_agents([agents[k] for k in leaving])
    stay = [agent for k, agent in enumerate(agents) if k not in first | second]
    assert list(model.particles.agents) == stay
    assert set(model.agents) == set(stay)
    assert [agent.mass for agent in stay] == [masses[agent] for agent in stay]
    assert model.particles.mass.tolist() == [masses[agent] for agent in stay]
    if len(stay) > 1:
        model.step()


def test_an_agent_with_its_own_way_to_leave_leaves_by_it():
    class Heir(DiffusingParticle):
        def remove(self):
            DiffusingParticle(self.model, position=self.position, mass=self.mass)
            super().remove()

    model = build(4, agent_class=DiffusingParticle, others=[Heir])
    mass = model.particles.mass.sum()
    Heir.remove_agents([agent for agent in model.particles.agents if isinstance(agent, Heir)])
    assert len(model.particles) == 4
    assert not any(isinstance(agent, Heir) for agent in model.particles.agents)
    assert model.particles.mass.sum() == pytest.approx(mass, rel=1e-15)


def test_mesas_own_ways_work():
    model = nest()
    assert isinstance(model.agents.select(at_most=2), AgentSet)
    assert len(model.agents.select(lambda ant: ant.position[0] > 3.0)) == 3
    assert sum(model.agents.get("energy")) == 10.0
    model.agents.set("energy", 1.0)
    assert model.particles.energy.tolist() == [1.0] * 5
    assert model.agents_by_type[Ant] == model.agents


def memory_of_one(cls, model, count=2000):
    """Bytes of an agent among as many, on average."""
    tracemalloc.start()
    try:
        cls.create_agents(model, count)
        return tracemalloc.get_traced_memory()[0] / count
    finally:
        tracemalloc.stop()


def test_beside_its_columns_an_agent_takes_hardly_more_memory_than_one_of_mesas():
    class Bare(mesa.Agent):
        pass

    class Bee(AgentParticle):
        pass

    model = ParticleModel(Bee, core_radius=0.5, rng=3)
    ours, mesas = memory_of_one(Bee, model), memory_of_one(Bare, mesa.Model())
    table = model.particles
    columns = sum(table.array(name).nbytes for name in table.columns) / len(table)
    # The number of the row, the class by row and the table's list of agents.
    assert 0.0 < ours - mesas - columns < 64.0


def test_a_class_with_its_own_constructor_is_created_through_it():
    class Queen(Ant):
        def __init__(self, model, **columns):
            super().__init__(model, energy=100.0, **columns)

    model = nest(0)
    Queen.create_agents(model, 3, position=np.zeros((3, 2)))
    assert model.particles.energy.tolist() == [100.0] * 3


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"energy": -1.0}, r"energy is -1.0 .*must be 0 or more"),
        ({"mass": np.nan}, r"mass is nan .*must be finite"),
        ({"mass": -2.0}, r"mass is -2.0 .*must be 0 or more"),
        ({"heading": (1.0, 2.0, 3.0)}, r"heading has shape \(3,\); it must be \(2,\)"),
        ({"position": (np.inf, 0.0)}, r"position is \[inf  0.\] .*must be finite"),
        ({"energy": "much"}, r"energy is 'much'; it must be a number"),
    ],
)
def test_bad_values_are_refused_by_name_and_leave_no_agent(columns, message):
    model = nest()
    with pytest.raises(ValueError, match=message):
        Ant(model, **columns)
    with pytest.raises(ValueError, match=message):
        Ant.create_agents(model, 3, **columns)
    assert len(model.agents) == len(model.particles) == 5


def test_an_unknown_column_is_refused_with_those_there_are():
    with pytest.raises(
        TypeError, match="Ant has no column 'colour'; it has position, mass, energy"
    ):
        Ant(nest(), colour="red")


def test_one_value_for_each_agent_or_one_for_all():
    model = nest(0)
    Ant.create_agents(model, 2, position=(3.0, 4.0), energy=[1.0, 2.0])
    assert model.particles.position.tolist() == [[3.0, 4.0], [3.0, 4.0]]
    assert model.particles.energy.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match=r"energy has shape \(3,\)"):
        Ant.create_agents(model, 2, energy=[1.0, 2.0, 3.0])


def test_two_shapes_under_one_name_are_refused():
    class Wasp(AgentParticle):
        energy = Column(2)

    with pytest.raises(ValueError, match="column 'energy' is declared with shapes"):
        ParticleModel([Ant, Wasp], core_radius=0.5)


def test_a_column_that_the_scene_lacks_names_those_it_has():
    with pytest.raises(AttributeError, match="no column 'density'; it has position, mass"):
        _ = nest().particles.density


def test_rows_may_be_put_in_another_order():
    model = nest()
    agents = list(model.agents)
    for k, ant in enumerate(agents):
        ant.energy = float(k)
    model.particles.reorder(np.array([3, 1, 4, 0, 2]))
    assert [ant.energy for ant in agents] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert model.particles.energy.tolist() == [3.0, 1.0, 4.0, 0.0, 2.0]
    assert list(model.agents) == agents


def test_a_large_scene_tidies_its_rows_and_nothing_else_changes():
    model = build(20_000, core_radius=0.03, form="plain", flow=None, dt=1e-6, integrator="euler")
    places = {agent: agent.position for agent in list(model.agents)[::100]}
    before = model.particles.position.copy()
    model.step()
    rows = np.array([agent._row for agent in model.agents])
    assert sorted(rows) == list(range(20_000))
    assert (rows != np.arange(20_000)).mean() > 0.9
    assert all(agent.position == pytest.approx(there, abs=1e-4) for agent, there in places.items())
    scattered = np.hypot(*np.diff(before, axis=0).T).mean()
    assert np.hypot(*np.diff(model.particles.position, axis=0).T).mean() < 0.1 * scattered
