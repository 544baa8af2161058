"""What a scene does not name costs nothing: no import, no column, no compilation."""

import subprocess
import sys

import pytest

from apmethod import AgentParticle, DiffusingParticle, Diffusion, ParticleModel, explain
from apmethod.message import gather

OBSTACLES = "apmethod.move.obstacles.collection"
HEAVY = ("mesa", "numba", "solara", "matplotlib", "scipy", "pandas", "shapely", OBSTACLES)


def imported_after(statement):
    script = f"import sys\n{statement}\nprint(*[m for m in {HEAVY} if m in sys.modules])"
    found = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return set(found.stdout.split())


def test_importing_the_package_imports_nothing_heavy():
    assert imported_after("import apmethod") == set()


def test_a_step_needs_no_browser_and_no_picture():
    statement = (
        "from apmethod.scenes.rotating_hill import RotatingHill\n"
        "RotatingHill(particles=200, rng=1).step()"
    )
    assert not imported_after(statement) & {"solara", "matplotlib", OBSTACLES}


def test_obstacles_need_no_shapely():
    statement = "from apmethod.scenes.harbour import Harbour\nHarbour(particles=20, rng=1)"
    assert imported_after(statement) & {"shapely", OBSTACLES} == {OBSTACLES}


def test_a_scene_without_skills_knows_nothing_of_them():
    script = (
        "import sys\n"
        "from apmethod.scenes.rotating_hill import RotatingHill\n"
        "model = RotatingHill(particles=200, rng=1)\n"
        "model.step()\n"
        "assert 'skills' not in model.procedure.seconds\n"
        "print(*sorted(m for m in sys.modules if m.startswith('apmethod.skills.')))"
    )
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert found.stdout.split() == ["apmethod.skills.skill"], found.stderr


def test_the_public_names_are_there():
    import apmethod

    assert set(apmethod.__all__) <= set(dir(apmethod))
    for name in apmethod.__all__:
        assert getattr(apmethod, name).__doc__ or name.isupper()
    with pytest.raises(AttributeError, match="no attribute 'Tree'"):
        _ = apmethod.Tree


def test_a_scene_without_terms_sorts_and_sums_nothing(monkeypatch):
    def never(*arguments):
        raise AssertionError("a pass was compiled")

    monkeypatch.setattr(gather, "_compile", never)
    model = ParticleModel(AgentParticle, core_radius=1.0, dt=1.0)
    AgentParticle.create_agents(model, 5, position=[[k, 0.0] for k in range(5)])
    model.step()
    assert model.particles.names == ["position", "mass"]
    assert model.space._cells is None
    assert model.procedure.seconds["perceive"] == 0.0
    assert dict(explain(model))["contribute"].startswith("skipped")


def test_only_the_sums_of_the_chosen_form_have_columns():
    model = ParticleModel(DiffusingParticle, core_radius=1.0, laws=[Diffusion(1.0, "plain")])
    assert model.particles.names == ["position", "mass", "density", "density_gradient"]
    agent = DiffusingParticle(model)
    with pytest.raises(AttributeError, match="this scene has no column 'blob_gradient'"):
        _ = agent.blob_gradient


def test_one_stage_integrators_allocate_for_one_stage_only():
    model = ParticleModel(AgentParticle, core_radius=1.0, dt=1.0, integrator="strang")
    assert "_carried" not in model.particles
    assert "_acceleration" not in model.particles


def test_a_model_without_obstacles_has_nothing_of_them():
    model = ParticleModel(AgentParticle, core_radius=1.0, dt=1.0)
    assert model.obstacles is None
    assert not {"_domain", "_held", "_fate", "_tried"} & set(model.particles.columns)
    assert "absorbed" not in model.diagnostics()
    assert "obstacles" not in dict(explain(model))
