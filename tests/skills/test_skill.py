"""Skills have their turns in each step, and work with what Mesa offers."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from mesa import DataCollector
from mesa.discrete_space import OrthogonalMooreGrid
from mesa.visualization.components import PropertyLayerStyle
from mesa.visualization.mpl_space_drawing import draw_property_layers

from apmethod import (
    Animal,
    AnimalModel,
    Column,
    Law,
    ParticleModel,
    Skill,
    StepFailed,
    neighbour_pairs,
    term,
)
from apmethod.run.batch import batch_run


class Diary(Skill):
    """Writes down its turns, and how often it has been taken back."""

    def __init__(self):
        self.turns, self.taken_back = [], 0

    def begin(self, dt):
        self.turns.append(("begin", dt))

    def perceived(self):
        self.turns.append(("perceived", self.model.motion.stage.at))

    def end(self, dt):
        self.turns.append(("end", dt))

    def state(self):
        return len(self.turns)

    def restore(self, state):
        del self.turns[state:]
        self.taken_back += 1

    def diagnostics(self):
        return {"turns": len(self.turns)}


def test_turns_come_once_a_step_or_once_a_stage():
    diary = Diary()
    model = ParticleModel(
        Animal, core_radius=1.0, dt=0.5, integrator="midpoint", skills=[diary],
        laws=[Law("still", lambda agent, p: (0.0, 0.0))],
    )  # fmt: skip
    Animal(model)
    model.step()
    assert diary.turns == [("begin", 0.5), ("perceived", 0.0), ("perceived", 0.5), ("end", 0.5)]
    assert model.diagnostics()["turns"] == 4


def test_a_failed_step_is_taken_back():
    diary = Diary()
    law = Law("lost", lambda agent, p: (1.0 / (1.0 - p.time), 0.0))
    model = ParticleModel(Animal, core_radius=1.0, dt=1.0, skills=[diary], laws=[law])
    Animal(model)
    model.step()
    with pytest.raises(StepFailed):
        model.step()
    assert len(diary.turns) == 3
    assert diary.taken_back == 1


class Watcher(Animal):
    heading = Column(2, start=(1.0, 0.0))
    sight = Column(start=2.0)

    @term("directed", reads=("heading", "sight"))
    def ahead(pair, i, j):
        """How many it sees within 45 degrees of where it is heading, as far as it sees."""
        # pair.x is from the other one to this one.
        facing = -(pair.x * i.heading[0] + pair.y * i.heading[1])
        return 1.0 if pair.distance <= i.sight and facing >= 0.7071 * pair.distance else 0.0


@pytest.mark.parametrize("tier", ["compiled", "agents"])
def test_what_an_animal_sees_of_others_is_a_directed_term(tier):
    model = ParticleModel(Watcher, core_radius=2.0, dt=1.0, tier=tier)
    Watcher.create_agents(model, 3, position=[(0, 0), (1, 0.2), (0, 1.5)], sight=[2, 2, 1])
    Watcher(model, position=(-1.0, 1.5), sight=1.2)
    model.step()
    assert [agent.ahead for agent in model.particles.agents] == [1.0, 0.0, 0.0, 1.0]
    assert len(neighbour_pairs(model.space.cells)) == 5


def test_mesa_collects_and_draws_them():
    model = AnimalModel(particles=300, side=20.0, rng=1)
    collector = DataCollector(
        {"groups": lambda model: len(model.groups.current), "signal": "total_of_signal"},
        {"group": "group"},
    )
    model.total_of_signal = model.signal.total
    model.step()
    collector.collect(model)
    assert collector.model_vars["groups"] == [len(model.groups.current)]
    assert set(collector.get_agent_vars_dataframe()["group"]) == set(model.particles.group)
    assert model.agents.get("signal") == [agent.signal for agent in model.agents]


def test_mesa_draws_and_selects_by_a_signal():
    model = AnimalModel(particles=50, side=10.0, rng=1)
    model.particles.assign("position", (7.5, 2.5))
    grid = OrthogonalMooreGrid(model.signal.patches.shape, random=model.random)
    grid.add_property_layer(model.signal.layer)
    for _ in range(3):
        model.step()
    assert np.array_equal(grid.signal.data, model.signal.values)
    assert grid[7, 2].signal == model.signal.values.max() > 0.0
    assert [tuple(map(int, at)) for at in grid.select_cells(extreme_values={"signal": "highest"})
            ] == [(7, 2)]  # fmt: skip
    ax = Figure().subplots()
    draw_property_layers(grid, lambda layer: PropertyLayerStyle(colormap="magma_r"), ax)
    assert np.array_equal(ax.images[0].get_array(), model.signal.values.T)


def test_batches_run_scenes_with_skills():
    rows = batch_run(
        "aggregation", {"particles": 100, "diffusivity": [0.1, 0.01]}, seeds=[1, 2], steps=2
    )
    assert [row["ended"] for row in rows] == ["finished"] * 4
    assert np.isfinite([row["signal_total"] for row in rows]).all()
