"""The bus: every pair once, and what one end gives the other gets."""

import numpy as np
import pytest

from apmethod import AgentParticle, DiffusingParticle, ParticleModel, Periodic, term
from apmethod.message.bus import MessageBus
from samples import Curious, build


def curious(tier="compiled", **options):
    model = build(120, agent_class=Curious, tier=tier, dt=1e-4, **options)
    draw = np.random.default_rng(9)
    model.particles.assign("charge", draw.uniform(0.5, 2.0, 120))
    return model


@pytest.mark.parametrize("domain", [None, Periodic((0, 0), (1, 1))], ids=["open", "periodic"])
@pytest.mark.parametrize("tier", ["compiled", "agents"])
def test_odd_messages_sum_to_zero_and_even_ones_are_symmetric(tier, domain):
    model = curious(tier, domain=domain)
    model.step()
    table = model.particles
    scale = np.abs(table.force).sum()
    assert np.abs(table.force.sum(axis=0)).max() < 1e-14 * scale
    momentum = table.mass @ table.blob_gradient
    assert np.abs(momentum).max() < 1e-14 * (table.mass @ np.abs(table.blob_gradient)).max()
    # Every pair counts one for each end, every agent one for itself.
    assert table.count.sum() == 120 + 2 * len(model_pairs_at_start(tier, domain))


def model_pairs_at_start(tier, domain):
    return curious(tier, domain=domain).space.pairs()


def test_sums_equal_brute_force():
    model = curious()
    pairs = model.space.pairs()
    position, mass = model.particles.position.copy(), model.particles.mass.copy()
    model.step()
    kernel, h = model.kernel, model.bus.smoothing_length
    rho = mass * kernel.w(0.0, h)
    for i, j in pairs:
        w = kernel.w(np.hypot(*(position[i] - position[j])), h)
        rho[i] += mass[j] * w
        rho[j] += mass[i] * w
    # The midpoint rule perceives a second time half a step on, 5e-5 in time.
    assert model.particles.density == pytest.approx(rho, rel=1e-2)
    still = curious()
    still.motion.begin(0.0, 1e-4)
    still.procedure.perceive()
    still.contribute(0)
    still.message()
    assert still.particles.density == pytest.approx(rho, rel=1e-12)


def test_a_pair_is_computed_once(monkeypatch):
    """Agents that find a message do not compute the pair again (paper 2.3)."""
    computed = []
    exchange = MessageBus.exchange

    def counted(bus, agent, other):
        computed.append(frozenset((agent.unique_id, other.unique_id)))
        return exchange(bus, agent, other)

    monkeypatch.setattr(MessageBus, "exchange", counted)
    model = curious("agents", integrator="euler")
    expected = len(model.space.pairs())
    model.step()
    assert len(computed) == len(model.bus.rounds) * expected
    assert len(set(computed)) == expected


def test_messages_really_are_posted_and_read():
    model = build(2, positions=np.array([[0.0, 0.0], [0.1, 0.0]]), form="plain", flow=None)
    a, b = model.agents
    model.procedure.perceive()
    model.bus.open(0)
    a.perceive()
    b.perceive()
    a.contribute()
    assert set(model.bus.messages(b)) == {a}
    assert set(model.bus.messages(a)) == {a, b}
    assert model.bus.received(b, sender=a)
    b.contribute()
    assert set(model.bus.messages(b)) == {a, b}
    to_a, to_b = model.bus.messages(a)[b], model.bus.messages(b)[a]
    assert to_a[0] / b.mass == pytest.approx(to_b[0] / a.mass)  # density is even
    assert to_a[1] / b.mass == pytest.approx(-to_b[1] / a.mass)  # its gradient is odd
    a.message()
    assert a.density == pytest.approx(sum(m[0] for m in model.bus.messages(a).values()))


def test_a_directed_relation_is_not_mirrored():
    class OneEyed(AgentParticle):
        """Sees only what is to its east."""

        def perceive(self):
            near = self.model.space.neighbours_of(self)
            self.neighbours = [o for o in near if o.position[0] > self.position[0]]

        @term("even")
        def seen(pair, i, j):
            return 1.0

    model = ParticleModel(OneEyed, core_radius=1.0, dt=1.0)
    row = OneEyed.create_agents(model, 4, position=[[0.4 * k, 0.0] for k in range(4)])
    model.step()
    assert [agent.seen for agent in row] == [2.0, 2.0, 1.0, 0.0]


def test_coincident_and_lonely_agents_are_no_trouble():
    positions = np.array([[0.0, 0.0], [0.0, 0.0], [9.0, 9.0]])
    for form in ("paper", "plain", "blob"):
        model = build(positions=positions, form=form, flow=None)
        model.step()
        assert model.particles.position == pytest.approx(positions)
    empty = build(0, flow=None)
    empty.step()
    assert len(empty.particles) == 0


class Folder(DiffusingParticle):
    """Its formula makes an array, as people's may."""

    @term("even")
    def folded(pair, i, j):
        return np.array([pair.w, 2.0 * pair.w]).sum()


def test_a_formula_may_make_arrays():
    models = [build(40, agent_class=Folder, tier=tier, dt=1e-4) for tier in ("compiled", "agents")]
    for model in models:
        model.step()
    compiled, agents = (model.particles.folded for model in models)
    assert (agents > 0.0).any()
    assert np.allclose(compiled, agents, rtol=1e-12, atol=0.0)
