"""Terms: what is refused, and what the built-in ones mean."""

import numpy as np
import pytest

from apmethod import AgentParticle, Column, ParticleModel, Periodic, Term, term
from samples import build


def model_with(*terms):
    return ParticleModel(AgentParticle, core_radius=1.0, terms=terms, dt=1.0)


def test_a_term_of_undeclared_parity_is_refused():
    with pytest.raises(ValueError, match=r"'crowd' has parity None; declare it as one of 'even'"):

        @term()
        def crowd(pair, i, j):
            return pair.w


def test_a_term_that_does_not_hold_its_parity_is_refused():
    @term("odd")
    def crowd(pair, i, j):
        return pair.w

    with pytest.raises(ValueError, match=r"'crowd' is declared odd but gives 0\.7 to one end"):
        model_with(crowd)


def test_a_term_must_declare_what_it_reads():
    @term("directed")
    def envy(pair, i, j):
        return j.mass - i.mass

    with pytest.raises(ValueError, match="'envy' reads what it does not declare"):
        model_with(envy)


def test_a_term_must_have_as_many_numbers_as_it_says():
    @term("odd")
    def push(pair, i, j):
        return pair.x, pair.y

    with pytest.raises((ValueError, TypeError)):
        model_with(push)

    three = Term(lambda pair, i, j: (pair.x, pair.y), "odd", components=3)
    with pytest.raises(ValueError, match="gives 2 numbers; components says 3"):
        model_with(three)


def test_a_term_cannot_read_what_nobody_has():
    @term("even", reads=("colour",))
    def match(pair, i, j):
        return i.colour * j.colour

    with pytest.raises(ValueError, match="'match' reads column 'colour', which no agent class"):
        model_with(match)


def test_terms_that_wait_for_each_other_are_refused():
    @term("even", reads=("second",))
    def first(pair, i, j):
        return i.second * j.second

    @term("even", reads=("first",))
    def second(pair, i, j):
        return i.first * j.first

    with pytest.raises(ValueError, match="terms first, second wait for each other's sums"):
        model_with(first, second)


def test_terms_come_in_rounds():
    @term("even", own=True)
    def count(pair, i, j):
        return 1.0

    @term("even", reads=("count",))
    def shared(pair, i, j):
        return 1.0 / i.count + 1.0 / j.count

    @term("odd", components=2)
    def lean(pair, i, j):
        return pair.x, pair.y

    model = model_with(shared, count, lean)
    names = [[each.name for each in terms] for terms in model.bus.rounds]
    assert names == [["count", "lean"], ["shared"]]


def test_an_agent_class_declares_a_term_and_reads_it():
    class Sheep(AgentParticle):
        wool = Column(start=2.0)

        @term("directed", reads=("wool",))
        def warmth(pair, i, j):
            return j.wool

    model = ParticleModel(Sheep, core_radius=1.0, dt=1.0)
    a, b, c = Sheep.create_agents(model, 3, position=[[0, 0], [0.5, 0], [1.2, 0]], wool=[1, 2, 4])
    model.step()
    assert [a.warmth, b.warmth, c.warmth] == [2.0, 5.0, 2.0]


def test_density_of_a_uniform_field():
    side = np.arange(40) / 40.0
    x, y = (part.ravel() for part in np.meshgrid(side, side))
    model = build(
        positions=np.column_stack([x, y]),
        domain=Periodic((0, 0), (1, 1)),
        core_radius=0.2,
        form="plain",
        flow=None,
    )
    model.particles.assign("mass", 1.0 / 1600.0)
    model.step()
    assert model.particles.density == pytest.approx(1.0, abs=1e-6)
    assert model.particles.density_gradient == pytest.approx(0.0, abs=1e-10)


def test_a_class_that_comes_too_late_for_its_terms_is_refused():
    class Late(AgentParticle):
        @term("even")
        def crowd(pair, i, j):
            return pair.w

    model = model_with()
    with pytest.raises(ValueError, match="Late declares term 'crowd', which this model does not"):
        Late(model)
    assert len(model.agents) == 0
    assert len(Late.create_agents(ParticleModel(Late, core_radius=1.0, dt=1.0), 3)) == 3
