"""Pictures of runs, with an exact solution, without one, and of agents alone."""

import numpy as np
import pytest

from apmethod import AgentParticle, FieldModel, ParticleModel
from apmethod.run.runner import run
from apmethod.scenes.diffusion import DensityDiffusion
from apmethod.scenes.moving_obstacle import MovingObstacle
from apmethod.view.picture import draw_run


def unsolved():
    return FieldModel(lambda x, y: np.exp(-9.0 * (x * x + y * y)), (-2, 2, -2, 2), particles=100)


def dots():
    model = ParticleModel(AgentParticle, core_radius=1.0, dt=1.0)
    AgentParticle.create_agents(model, 5, position=np.eye(5, 2))
    return model


@pytest.mark.parametrize(
    "make",
    [unsolved, dots, lambda: DensityDiffusion(100), lambda: MovingObstacle(50, rng=1)],
)
def test_every_kind_of_run_is_drawn(make, tmp_path):
    result = run(make(), steps=2)
    draw_run(result, "a run", tmp_path / "picture.png")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
