"""Each integrator reaches its order on a system whose solution is known."""

import numpy as np
import pytest
from scipy.linalg import expm

from apmethod import (
    INTEGRATORS,
    AgentParticle,
    Bounded,
    Flow,
    InertialParticle,
    Law,
    ParticleModel,
    Periodic,
    term,
)

FIRST_ORDER = [each for each in INTEGRATORS.values() if each.of == "velocity"]
SECOND_ORDER = [each for each in INTEGRATORS.values() if each.of == "acceleration"]
by_name = {"ids": lambda each: each.name}

TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])
PULL = np.array([[-0.5, 0.3], [0.1, -0.2]])
START = np.array([[0.7, -0.4]])


def turn(x, y, t):
    return y, -x


def pull(agent, p):
    x, y = agent.position[0], agent.position[1]
    return -0.5 * x + 0.3 * y, 0.1 * x - 0.2 * y


def breathe(agent, p):
    return agent.position[0] * np.cos(p.time), -agent.position[1] * np.sin(p.time)


def end_of_run(integrator, laws, steps, until, agent_class=AgentParticle, tier="compiled", **start):
    model = ParticleModel(
        agent_class, core_radius=1.0, laws=laws, integrator=integrator, dt=until / steps, tier=tier
    )
    agent_class.create_agents(model, 1, position=START, **start)
    for _ in range(steps):
        model.step()
    return model


def fitted_order(error_at, steps=(20, 40, 80)):
    errors = np.array([error_at(count) for count in steps])
    return np.polyfit(np.log(1.0 / np.array(steps)), np.log(errors), 1)[0]


@pytest.mark.parametrize("tier", ["compiled", "agents"])
@pytest.mark.parametrize("integrator", FIRST_ORDER, **by_name)
def test_order_with_a_flow_and_a_law_that_do_not_commute(integrator, tier):
    exact = START @ expm((TURN + PULL) * 2.0).T

    def error(steps):
        model = end_of_run(integrator, [Flow(turn), Law("pull", pull, reads=("position",))],
                           steps, 2.0, tier=tier)  # fmt: skip
        return np.abs(model.particles.position - exact).max()

    assert fitted_order(error) == pytest.approx(integrator.order, abs=0.25)


@pytest.mark.parametrize("integrator", FIRST_ORDER, **by_name)
def test_order_with_a_law_that_changes_in_time(integrator):
    until = 2.0
    exact = START * np.exp([np.sin(until), np.cos(until) - 1.0])

    def error(steps):
        law = Law("breathe", breathe, reads=("position",))
        model = end_of_run(integrator, [law], steps, until)
        return np.abs(model.particles.position - exact).max()

    # Without a flow to split off, only the rule for the interactions is left.
    order = 3 if integrator.name == "strang_3" else integrator.order
    assert fitted_order(error, (40, 80, 160)) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("integrator", FIRST_ORDER, **by_name)
def test_real_stability_limit_is_what_the_integrator_says(integrator):
    """dx/dt = -x stays bounded for dt just below the reach and grows just above it."""

    def decay(agent, p):
        return -agent.position[0], -agent.position[1]

    law = Law("decay", decay, reads=("position",))
    for share, grows in ((0.98, False), (1.02, True)):
        steps = 600
        until = share * integrator.reach * steps
        model = end_of_run(integrator, [law], steps, until)
        assert (np.abs(model.particles.position).max() > 1.0) == grows


def test_a_split_flow_alone_is_carried_exactly():
    """To round-off, however long the step."""
    model = end_of_run("strang", [Flow(turn)], 4, 8.0)
    assert model.particles.position == pytest.approx(START @ expm(TURN * 8.0).T, abs=1e-12)


def test_a_split_flow_is_carried_in_parts_as_short_as_it_takes():
    """It swings 50 times as fast as it turns, which only its convergence can tell."""
    flow = Flow(lambda x, y, t: (50.0 * np.cos(50.0 * t), 0.0))
    model = end_of_run("strang", [flow], 1, 2.0)
    assert model.particles.position == pytest.approx(
        START + np.array([np.sin(100.0), 0.0]), abs=1e-10
    )


def test_a_flow_that_jumps_is_carried_too():
    """No rule converges across the jump; the error is that of a part or two, 2/1024 long."""
    flow = Flow(lambda x, y, t: (1.0, 0.0) if x < 1.0 else (0.25, 0.0))
    model = end_of_run("strang", [flow], 1, 2.0)
    assert model.particles.position == pytest.approx(START + np.array([0.3 + 0.425, 0.0]), abs=4e-3)


def spring(agent, p):
    return -agent.position[0], -4.0 * agent.position[1]


@pytest.mark.parametrize("tier", ["compiled", "agents"])
@pytest.mark.parametrize("integrator", SECOND_ORDER, **by_name)
def test_order_on_the_harmonic_oscillator(integrator, tier):
    until = 3.0
    exact = START[0] * np.cos([until, 2.0 * until])

    def error(steps):
        model = end_of_run(integrator, [Law("spring", spring, reads=("position",))], steps, until,
                           InertialParticle, tier)  # fmt: skip
        return np.abs(model.particles.position - exact).max()

    assert fitted_order(error) == pytest.approx(2.0, abs=0.25)


@pytest.mark.parametrize("integrator", SECOND_ORDER, **by_name)
def test_energy_does_not_drift(integrator):
    model = end_of_run(integrator, [Law("spring", spring, reads=("position",))], 1, 0.05,
                       InertialParticle)  # fmt: skip
    energies = []
    for _ in range(5000):
        model.step()
        x, v = model.particles.position[0], model.particles.velocity[0]
        energies.append(0.5 * (v @ v) + 0.5 * (x[0] ** 2 + 4.0 * x[1] ** 2))
    first, last = np.mean(energies[:500]), np.mean(energies[-500:])
    assert last == pytest.approx(first, rel=2e-3)


class Ball(InertialParticle):
    """Pushes others away, by a force that both ends feel."""

    @term("odd", components=2)
    def push(pair, i, j):
        return pair.w * pair.x, pair.w * pair.y


def pushed(agent, p):
    return agent.push[0] / agent.mass, agent.push[1] / agent.mass


@pytest.mark.parametrize("tier", ["compiled", "agents"])
@pytest.mark.parametrize("integrator", SECOND_ORDER, **by_name)
def test_momentum_is_kept_by_an_odd_force(integrator, tier):
    model = ParticleModel(
        Ball, core_radius=0.5, laws=[Law("push", pushed, reads=("push", "mass"))],
        integrator=integrator, dt=0.05, tier=tier,
    )  # fmt: skip
    draw = np.random.default_rng(1)
    Ball.create_agents(model, 40, position=draw.random((40, 2)), mass=draw.uniform(1, 3, 40))
    for _ in range(5):
        model.step()
    table = model.particles
    momentum = table.mass[:, None] * table.velocity
    assert np.abs(momentum).max() > 0.1
    assert np.abs(momentum.sum(axis=0)).max() < 1e-13 * np.abs(momentum).sum()


@pytest.mark.parametrize("integrator", SECOND_ORDER, **by_name)
def test_agents_that_come_later_are_started_properly(integrator):
    """A late agent moves as one that was there from the start of its own time."""
    law = Law("spring", spring, reads=("position",))
    model = end_of_run(integrator, [law], 7, 0.7, InertialParticle)
    late = InertialParticle(model, position=START[0])
    for _ in range(20):
        model.step()
    alone = end_of_run(integrator, [law], 20, 2.0, InertialParticle)
    assert late.position == pytest.approx(alone.particles.position[0], abs=1e-13)


@pytest.mark.parametrize("integrator", SECOND_ORDER, **by_name)
def test_a_bounded_side_turns_the_velocity_round(integrator):
    model = ParticleModel(
        InertialParticle, core_radius=0.1, domain=Bounded((0, 0), (1, 1)), integrator=integrator,
        dt=0.1,
    )  # fmt: skip
    ball = InertialParticle(model, position=(0.95, 0.5), velocity=(1.0, 0.0))
    model.step()
    assert ball.position == pytest.approx([0.95, 0.5])
    assert ball.velocity.tolist() == [-1.0, 0.0]
    for _ in range(5):
        model.step()
    assert ball.position == pytest.approx([0.45, 0.5])


def test_a_periodic_side_is_crossed():
    model = ParticleModel(
        InertialParticle, core_radius=0.1, domain=Periodic((0, 0), (1, 1)),
        integrator="velocity_verlet", dt=0.1,
    )  # fmt: skip
    ball = InertialParticle(model, position=(0.95, 0.5), velocity=(1.0, 0.0))
    model.step()
    assert ball.position == pytest.approx([0.05, 0.5])
    assert ball.velocity.tolist() == [1.0, 0.0]


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="integrator is 'simpson'; it must be one of euler"):
        ParticleModel(AgentParticle, core_radius=1.0, integrator="simpson")
    with pytest.raises(ValueError, match="no agent class has a velocity; derive one from Inertial"):
        ParticleModel(AgentParticle, core_radius=1.0, integrator="leap_frog", dt=0.1)
    with pytest.raises(ValueError, match="dt is None; a second-order law needs one given"):
        ParticleModel(InertialParticle, core_radius=1.0, integrator="leap_frog")
    with pytest.raises(ValueError, match="splits off one flow and the scene has 2"):
        ParticleModel(
            AgentParticle, core_radius=1.0, laws=[Flow(turn), Flow(turn)], integrator="strang"
        )
