"""Two tiers, one meaning: the agents' own methods and the compiled steps agree."""

import numpy as np
import pytest

from apmethod import (
    FORMS,
    Bounded,
    Mirrored,
    Open,
    Periodic,
    StepFailed,
    explain,
)
from samples import Curious, build, column_by_id

DOMAINS = {
    "open": Open(),
    "bounded": Bounded((0.0, 0.0), (1.0, 1.0)),
    "mirrored": Mirrored((0.0, 0.0), (1.0, 1.0)),
    "periodic": Periodic((0.0, 0.0), (1.0, 1.0)),
}


class Walker(Curious):
    """Overrides where it wants to go."""

    def dynamics(self):
        return super().dynamics() + 0.1 * np.array([self.count, -1.0])


class Mover(Curious):
    """Overrides how it moves."""

    def move(self):
        super().move()
        self.position = self.position + 1e-3


class ShortSighted(Curious):
    """Sees only half as far as the others, who see it all the same."""

    def perceive(self):
        here = self.position
        near = self.model.space.neighbours_of(self)
        self.neighbours = [o for o in near if np.hypot(*(o.position - here)) < 0.1]


class Talker(Curious):
    """Contributes as all do, but in Python."""

    def contribute(self):
        super().contribute()


class Listener(Curious):
    """Takes in its messages itself."""

    def message(self):
        super().message()


def assert_same(one, other, steps=2):
    """The same columns, to 1e-12 of each column's size, after each of some steps."""
    for _ in range(steps):
        one.step()
        other.step()
        for name in one.particles.names:
            a, b = column_by_id(one, name), column_by_id(other, name)
            assert np.abs(a - b).max() <= 1e-12 * max(np.abs(a).max(), 1e-300), name


@pytest.mark.parametrize("level", [0, 1, 2])
@pytest.mark.parametrize("domain", list(DOMAINS))
def test_every_term_at_every_level_in_every_domain(domain, level):
    models = [
        build(90, agent_class=Curious, domain=DOMAINS[domain], level=level, tier=tier)
        for tier in ("compiled", "agents")
    ]
    assert_same(*models)


@pytest.mark.parametrize("kernel", ["cubic", "quintic", "wendland_c2", "wendland_c4", "gaussian"])
@pytest.mark.parametrize("form", list(FORMS))
def test_every_form_and_kernel(form, kernel):
    models = [build(80, form=form, kernel=kernel, tier=tier) for tier in ("compiled", "agents")]
    assert_same(*models)


def test_the_fourth_order_kernel():
    assert_same(
        *(build(80, form="plain", kernel="gaussian_4", tier=t) for t in ("compiled", "agents"))
    )


@pytest.mark.parametrize(
    "integrator", ["euler", "predictor_corrector", "midpoint", "rk4", "strang"]
)
def test_every_integrator(integrator):
    assert_same(
        *(build(60, integrator=integrator, dt=1e-2, tier=t) for t in ("compiled", "agents"))
    )


@pytest.mark.parametrize("domain", list(DOMAINS))
@pytest.mark.parametrize("integrator", ["euler", "strang"])
@pytest.mark.parametrize("other", [Walker, Mover, ShortSighted, Talker, Listener])
def test_mixed_scenes(other, integrator, domain):
    """Agents of an overriding class beside compiled ones, against all agents in Python."""
    models = [
        build(
            90,
            agent_class=Curious,
            others=[other],
            domain=DOMAINS[domain],
            integrator=integrator,
            tier=tier,
        )
        for tier in ("compiled", "agents")
    ]
    assert_same(*models)


def test_all_overriding_classes_in_one_scene():
    others = [Walker, Mover, ShortSighted, Talker, Listener]
    models = [
        build(90, agent_class=Curious, others=others, tier=tier) for tier in ("compiled", "agents")
    ]
    assert_same(*models)


def test_only_the_overriding_class_runs_in_python():
    model = build(20, agent_class=Curious, others=[Walker])
    procedure = model.procedure
    assert not procedure.in_python(Curious, "pairs")
    assert not procedure.in_python(Curious, "move")
    assert not procedure.in_python(Walker, "pairs")
    assert procedure.in_python(Walker, "move")
    assert "Walker overrides dynamics" in dict(explain(model))["move"]


@pytest.mark.parametrize("others", [[], [ShortSighted, Walker]], ids=["plain", "mixed"])
def test_tiers_agree_after_agents_have_come_and_gone(others):
    def changed(tier):
        model = build(60, agent_class=Curious, others=others, tier=tier)
        model.step()
        for agent in list(model.agents)[5:50:7]:
            agent.remove()
        draw = np.random.default_rng(5)
        Curious.create_agents(model, 20, position=draw.random((20, 2)), mass=0.01)
        for cls in others:
            cls(model, position=(0.5, 0.5), mass=0.01)
        return model

    assert_same(changed("compiled"), changed("agents"))


def test_agents_may_leave_while_they_move():
    class Leaver(Curious):
        def move(self):
            super().move()
            if self.unique_id % 4 == 0:
                self.remove()

    models = [
        build(40, agent_class=Curious, others=[Leaver], tier=tier)
        for tier in ("compiled", "agents")
    ]
    assert_same(*models, steps=1)
    assert len(models[0].agents) == 35


def test_an_unknown_tier_is_refused():
    with pytest.raises(ValueError, match="tier is 'fast'; it must be 'compiled' or 'agents'"):
        build(4, tier="fast")


@pytest.mark.parametrize("tier", ["compiled", "agents"])
def test_a_nan_stops_the_run_and_names_step_agent_and_column(tier):
    def trap(x, y, t):
        return (0.0, 0.0) if t < 0.0025 else (0.0, np.sqrt(x - 0.9) * 0.0)

    model = build(30, flow=trap, tier=tier, integrator="euler")
    for _ in range(3):
        model.step()
    before, density = model.particles.position.copy(), model.particles.density.copy()
    with (
        np.errstate(invalid="ignore"),
        pytest.raises(StepFailed, match=r"step 4 .*column 'position' of agent \d+ "),
    ):
        model.step()
    assert (model.particles.position == before).all()
    assert (model.particles.density == density).all()
    assert model.elapsed == pytest.approx(0.003)


def test_a_model_goes_on_after_a_step_that_failed():
    def hiccup(x, y, t):
        return (np.inf if stumble[0] else 1.0), 0.0

    stumble = [True]
    model = build(5, flow=hiccup, tier="agents", integrator="euler")
    for _ in range(2):
        with np.errstate(invalid="ignore"), pytest.raises(StepFailed):
            model.step()
    stumble[0] = False
    model.step()
    assert model.elapsed == pytest.approx(1e-3)


def test_ctrl_c_puts_the_agents_back():
    class Impatient(Curious):
        def move(self):
            raise KeyboardInterrupt

    model = build(10, agent_class=Curious, others=[Impatient])
    before = model.particles.position.copy()
    with pytest.raises(KeyboardInterrupt):
        model.step()
    assert (model.particles.position == before).all()
    assert model.elapsed == 0.0


def test_steps_called_by_hand_say_what_is_missing():
    agent = build(3).agents[0]
    with pytest.raises(RuntimeError, match=r"call model.bus.open\(0\) first"):
        agent.contribute()
    with pytest.raises(RuntimeError, match="agents move within a step of their model"):
        agent.move()


def test_agents_tell_who_they_are():
    model = build(2, positions=np.array([[0.25, 0.5], [1.0, 2.0]]))
    agent = model.agents[0]
    assert repr(agent) == "<DiffusingParticle 1 at (0.25, 0.5)>"
    agent.remove()
    assert repr(agent) == "<DiffusingParticle 1, removed>"


@pytest.mark.parametrize("integrator", ["euler", "rk4", "strang"])
def test_agents_may_arrive_while_others_predict_and_move(integrator):
    class Parent(Curious):
        def _bear(self):
            if self.unique_id < 40:
                Curious(self.model, position=self.position + 0.01, mass=1e-3)

        def predict(self):
            super().predict()
            self._bear()

        def move(self):
            super().move()
            self._bear()

    models = [
        build(30, agent_class=Curious, others=[Parent], tier=tier, integrator=integrator)
        for tier in ("compiled", "agents")
    ]
    for model in models:
        model.step()
        assert len(model.agents) > 30
        assert (np.abs(model.particles.position - 0.5) < 0.6).all()
