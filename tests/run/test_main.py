"""The command line, as a user types it."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from apmethod.run.main import main

SMALL = ["--particles", "300", "--steps", "3"]


def call(capsys, *arguments):
    code = main([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_run_prints_a_table_and_writes_open_files(capsys, tmp_path):
    code, out, _ = call(capsys, "run", "rotating_hill", *SMALL, "--out", tmp_path / "new")
    assert code == 0
    for label in ("agents", "steps", "perceive, s", "mass drift", "centroid drift", "L2 error"):
        assert label in out
    with open(tmp_path / "new" / "series.csv") as file:
        series = list(csv.DictReader(file))
    assert [row["step"] for row in series] == ["0", "1", "2", "3"]
    with open(tmp_path / "new" / "agents.csv") as file:
        agents = list(csv.DictReader(file))
    assert len(agents) == 300
    assert {"unique_id", "position_x", "position_y", "mass", "density"} <= set(agents[0])
    assert not any(name.startswith("_") for name in agents[0])
    assert (tmp_path / "new" / "picture.png").read_bytes().startswith(b"\x89PNG")


def test_json_is_json_and_nothing_else(capsys, tmp_path):
    code, out, _ = call(capsys, "run", "diffusion", *SMALL, "--json", "--out", tmp_path)
    numbers = json.loads(out)
    assert code == 0
    assert numbers["scene"] == "diffusion"
    assert numbers["steps"] == 3
    assert numbers["mass_drift"] <= 1e-12
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["l2_error"] == numbers["l2_error"]


def test_a_full_turn_of_the_hill_with_the_defaults(capsys, tmp_path):
    _, out, _ = call(capsys, "run", "rotating_hill", "--json", "--out", tmp_path)
    numbers = json.loads(out)
    assert numbers["ended"] == "finished"
    assert numbers["time"] == pytest.approx(2.0 * np.pi, abs=1e-15)
    assert numbers["l2_error"] <= 1e-3
    assert numbers["mass_drift"] <= 1e-12
    assert numbers["centroid_drift"] <= 1e-6


def test_settings_reach_the_scene(capsys, tmp_path):
    arguments = ["--set", "form=plain", "--set", "diffusivity=2e-3", "--set", "dt=0.01"]
    code, out, _ = call(capsys, "explain", "rotating_hill", *arguments, "--seed", 5, "--json")
    steps = json.loads(out)["steps"]
    assert code == 0
    assert "plain form (diffusivity=0.002" in steps["move"]
    assert steps["time step"].startswith("0.01, given")


def test_the_tiers_end_at_the_same_place(capsys, tmp_path):
    found = []
    for tier in ("agents", "compiled"):
        call(capsys, "run", "rotating_hill", *SMALL, "--tier", tier, "--out", tmp_path / tier)
        with open(tmp_path / tier / "agents.csv") as file:
            found.append([float(row["position_x"]) for row in csv.DictReader(file)])
    assert found[0] == pytest.approx(found[1], rel=1e-12)


def test_until(capsys, tmp_path):
    _, out, _ = call(
        capsys,
        "run",
        "rotating_hill",
        "--particles",
        300,
        "--until",
        0.5,
        "--json",
        "--out",
        tmp_path,
    )
    assert json.loads(out)["time"] == 0.5


def test_a_scene_is_named_by_its_folder(capsys, tmp_path):
    """A copied folder is a scene of its own, siblings and all."""
    folder = tmp_path / "my_scene"
    folder.mkdir()
    (folder / "agents.py").write_text(
        "from apmethod import AgentParticle\n\nclass Dot(AgentParticle):\n    '''A dot.'''\n"
    )
    (folder / "model.py").write_text(
        "from apmethod import ParticleModel\nfrom .agents import Dot\n\n"
        "class Dots(ParticleModel):\n    '''Dots.'''\n"
        "    def __init__(self, particles: int = 5, rng=None):\n"
        "        super().__init__(Dot, core_radius=1.0, dt=0.5, rng=rng)\n"
        "        Dot.create_agents(self, particles, position=(0.0, 0.0))\n"
    )
    code, out, _ = call(capsys, "run", folder, "--steps", 2, "--json", "--out", tmp_path / "out")
    assert code == 0
    assert json.loads(out)["agents"] == 5
    assert "centroid_drift" not in json.loads(out)


def test_scenes_are_listed(capsys):
    _, out, _ = call(capsys, "scenes", "--json")
    animals = {"aggregation", "aggregation_perception", "group_strategies"}
    assert {"diffusion", "rotating_hill", *animals} <= set(json.loads(out))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "rotatin_hill"], "did you mean 'rotating_hill'?"),
        (["run", "rotating_hill", "--set", "particels=9"], "did you mean 'particles'?"),
        (["run", "rotating_hill", "--set", "particles"], "it must be name=value"),
        (
            ["run", "rotating_hill", "--steps", "0"],
            "steps is 0; it must be a whole number, 1 or more",
        ),
        (
            ["run", "rotating_hill", "--until", "-1"],
            "until is -1.0; it must be a finite number above 0",
        ),
        (["run", "rotating_hill", "--set", "dt=9"], "dt is 9, which is unstable"),
        (["run", "rotating_hill", "--particles", "-5"], "particles is -5"),
        (["run", "rotating_hill", "--set", "diffusivity=-1"], "diffusivity is -1"),
        (["run", "rotating_hill", "--seed", "-1"], "rng (the seed) is -1; it must be a whole"),
        (["run", "rotating_hill", "--threads", "0"], "threads is 0"),
        (["run", "rotating_hill", "--set", "form=laplace"], "form is 'laplace'"),
        (["run", "rotating_hill", "--set", "diffusivity=much"], "diffusivity is 'much'"),
    ],
)
def test_bad_input_is_refused_in_one_line(capsys, arguments, message):
    code, out, err = call(capsys, *arguments)
    assert code == 2
    assert out == ""
    assert message in err
    assert len(err.strip().splitlines()) == 1


def test_a_run_that_fails_keeps_what_it_has(capsys, tmp_path):
    folder = tmp_path / "trap"
    folder.mkdir()
    (folder / "model.py").write_text(
        "import math\nfrom apmethod import AgentParticle, Flow, ParticleModel\n\n"
        "def trap(x, y, t):\n    return (1.0 if t < 2.5 else math.inf), 0.0\n\n"
        "class Trap(ParticleModel):\n    '''Trap.'''\n"
        "    def __init__(self, rng=None):\n"
        "        super().__init__(AgentParticle, core_radius=1.0, laws=[Flow(trap)], dt=1.0)\n"
        "        AgentParticle(self)\n"
    )
    code, out, err = call(capsys, "run", folder, "--steps", 9, "--json", "--out", tmp_path / "out")
    assert code == 1
    assert "step 4" in err
    assert "column 'position' of agent 1" in err
    assert json.loads(out)["ended"] == "failed"
    with open(tmp_path / "out" / "series.csv") as file:
        assert [row["centroid_x"] for row in csv.DictReader(file)] == ["0.0", "1.0", "2.0", "3.0"]
    with open(tmp_path / "out" / "agents.csv") as file:
        assert [row["position_x"] for row in csv.DictReader(file)] == ["3.0"]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT to send")
def test_ctrl_c_ends_a_run_with_what_it_has(tmp_path):
    started = tmp_path / "started"
    (tmp_path / "model.py").write_text(
        "from pathlib import Path\nfrom apmethod import AgentParticle, ParticleModel\n\n"
        "class Endless(ParticleModel):\n    '''Endless.'''\n"
        "    def __init__(self, rng=None):\n"
        "        super().__init__(AgentParticle, core_radius=1.0, dt=1.0)\n"
        "        AgentParticle(self)\n"
        "    def step(self):\n        super().step()\n"
        f"        if self.steps == 3:\n            Path({str(started)!r}).touch()\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-m", "apmethod", "run", str(tmp_path), "--steps", "1000000000",
         "--json", "--out", str(tmp_path)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    while not started.exists() and process.poll() is None:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    numbers = json.loads(out)
    assert numbers["ended"] == "interrupted"
    assert numbers["steps"] >= 2
    with open(tmp_path / "series.csv") as file:
        assert len(list(csv.DictReader(file))) == numbers["steps"] + 1
