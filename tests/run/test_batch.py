"""Batches of runs, by Mesa's own batch_run and by apmethod's, in one process and in two."""

import inspect
import multiprocessing
import subprocess
import sys
import threading
import types

import mesa
import pytest

from apmethod import StepFailed, set_threads
from apmethod.compile.threads import threads
from apmethod.run.batch import batch_run
from apmethod.run.runner import run
from apmethod.scenes.rotating_hill import RotatingHill

PARAMETERS = {"particles": 60, "form": ["blob", "plain"]}
SEEDS = [1, 2]
COMBINATIONS = [("blob", 1), ("plain", 1), ("blob", 2), ("plain", 2)]


class CollectingHill(RotatingHill):
    """A scene as one writes it for `mesa.batch_run`: with a data collector."""

    def __init__(self, particles=60, form="blob", rng=None):
        super().__init__(particles=particles, form=form, dt=0.1, rng=rng)
        self.datacollector = mesa.DataCollector(
            model_reporters={"elapsed": "elapsed", "l2_error": lambda m: m.errors()["l2_error"]},
            agent_reporters={"mass": "mass", "x": lambda agent: agent.position[0]},
        )

    def step(self):
        super().step()
        self.datacollector.collect(self)


class BrittleHill(RotatingHill):
    """A scene whose second step fails for one value of a parameter."""

    def __init__(self, particles=60, breaks=False, rng=None):
        super().__init__(particles=particles, rng=rng)
        self.breaks = breaks

    def step(self):
        if self.breaks and self.steps == 2:
            raise StepFailed("it broke", self.steps, self.elapsed)
        super().step()


@pytest.fixture
def two_threads():
    before = threads()
    set_threads(2)
    yield
    set_threads(before)


def _by_mesa(processes):
    """What `mesa.batch_run` reports, by parameters and seed and agent."""
    if "rng" in inspect.signature(mesa.batch_run).parameters:
        design = {"parameters": PARAMETERS, "rng": SEEDS}
    else:
        design = {"parameters": {**PARAMETERS, "rng": SEEDS}}
    rows = mesa.batch_run(
        CollectingHill, **design, max_steps=2, number_processes=processes, display_progress=False
    )
    return {
        (row["form"], row["rng"], row["AgentID"]): (
            row["elapsed"], row["l2_error"], row["mass"], row["x"],
        )
        for row in rows
    }  # fmt: skip


def _last_place(seed):
    model = RotatingHill(particles=4000, rng=seed)
    run(model, steps=1)
    return model.particles.position


def test_every_combination_has_a_row():
    rows = batch_run(RotatingHill, PARAMETERS, SEEDS, steps=2)
    assert [(row["form"], row["rng"]) for row in rows] == COMBINATIONS
    assert all(row["step"] == 2 and row["agents"] == 60 for row in rows)
    assert len({row["l2_error"] for row in rows}) == 4


def test_a_row_says_what_a_run_by_hand_would():
    [row] = batch_run(RotatingHill, {"particles": 60, "form": "plain"}, 2, until=0.3)
    model = RotatingHill(particles=60, form="plain", rng=2)
    run(model, until=0.3)
    settings = {"particles": 60, "form": "plain", "rng": 2, "ended": "finished", "failure": ""}
    assert row == {**settings, **model.diagnostics(), **model.errors()}


@pytest.mark.parametrize("scene", [RotatingHill, "rotating_hill"])
def test_processes_change_nothing(scene):
    alone, shared = (
        batch_run(scene, PARAMETERS, SEEDS, steps=2, processes=count) for count in (1, 2)
    )
    assert alone == shared


def test_a_failing_run_is_a_row():
    rows = batch_run(BrittleHill, {"breaks": [True, False]}, steps=3)
    assert [row["ended"] for row in rows] == ["failed", "finished"]
    assert "it broke" in rows[0]["failure"]


def test_what_is_refused():
    with pytest.raises(ValueError, match="processes is 0"):
        batch_run(RotatingHill, {}, processes=0)
    with pytest.raises(ValueError, match="give it as seeds"):
        batch_run(RotatingHill, {"rng": [1, 2]})
    with pytest.raises(ValueError, match="did you mean 'particles'"):
        batch_run(RotatingHill, {"particle": 60}, steps=1)


def test_a_class_from_a_notebook_needs_one_process(monkeypatch):
    notebook = types.ModuleType("notebook_without_file")
    monkeypatch.setitem(sys.modules, notebook.__name__, notebook)
    monkeypatch.setattr(CollectingHill, "__module__", notebook.__name__)
    with pytest.raises(ValueError, match="cannot import CollectingHill"):
        batch_run(CollectingHill, {}, processes=2)
    assert len(batch_run(CollectingHill, {}, steps=1)) == 1


def test_a_program_from_standard_input_needs_one_process():
    program = "from apmethod.run.batch import batch_run; batch_run('diffusion', {}, processes=2)"
    ended = subprocess.run(
        [sys.executable], input=program, capture_output=True, text=True, timeout=60
    )
    assert "cannot import the program <stdin>" in ended.stderr


def test_mesa_collects_the_same_in_one_process_and_in_two():
    alone, shared = _by_mesa(1), _by_mesa(2)
    assert alone == shared
    assert len(alone) == 60 * len(COMBINATIONS)
    assert {key[:2] for key in alone} == set(COMBINATIONS)


@pytest.mark.skipif(
    "fork" not in multiprocessing.get_all_start_methods(), reason="this system cannot fork"
)
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_fork_does_not_wait_for_threads_it_has_not(two_threads):
    here = _last_place(1)
    assert any(thread.name.startswith("apmethod") for thread in threading.enumerate())
    with multiprocessing.get_context("fork").Pool(1) as pool:
        there = pool.apply_async(_last_place, [1]).get(timeout=60)
    assert (here == there).all()
