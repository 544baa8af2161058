"""Pictures of runs, with an exact solution, without one, and of agents alone."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from apmethod import AgentParticle, FieldModel, ParticleModel, Trajectories
from apmethod.run.runner import run
from apmethod.scenes.aggregation import Aggregation
from apmethod.scenes.diffusion import DensityDiffusion
from apmethod.scenes.moving_obstacle import MovingObstacle
from apmethod.view.animals import draw_animals
from apmethod.view.picture import draw_run


def unsolved():
    return FieldModel(lambda x, y: np.exp(-9.0 * (x * x + y * y)), (-2, 2, -2, 2), particles=100)


def dots():
    model = ParticleModel(AgentParticle, core_radius=1.0, dt=1.0)
    AgentParticle.create_agents(model, 5, position=np.eye(5, 2))
    return model


@pytest.mark.parametrize(
    "make",
    [
        unsolved,
        dots,
        lambda: DensityDiffusion(100),
        lambda: Aggregation(100),
        lambda: MovingObstacle(50, rng=1),
    ],
)
def test_every_kind_of_run_is_drawn(make, tmp_path):
    result = run(make(), steps=2)
    draw_run(result, "a run", tmp_path / "picture.png")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")


def test_groups_are_outlined_and_trajectories_end_at_the_sides():
    model = Aggregation(200, followed=1, core_radius=2.0, rng=1)
    positions = np.random.default_rng(0).normal(size=(200, 2)) % 50.0  # a group at a corner
    model.particles.assign("position", positions)
    (group,) = model.groups.find()
    (paths,) = (skill for skill in model.skills if isinstance(skill, Trajectories))
    paths.paths[1] = [(49.0, 1.0), (49.8, 1.0), (0.4, 1.0), (1.0, 1.0)]
    ax = Figure().subplots()
    draw_animals(ax, model)
    (outline,) = ax.patches
    assert np.ptp(outline.get_xy(), axis=0).max() < 12.0
    assert outline.contains_point(ax.transData.transform((group.x, group.y)))
    assert [line.get_xdata().tolist() for line in ax.lines] == [[49.0, 49.8], [0.4, 1.0]]
