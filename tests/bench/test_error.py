"""The work-precision study: exact solutions, its bookkeeping, and tiny runs of it."""

import csv
import json

import numpy as np
import pytest

from apmethod.bench.error import freefem, scikit_fem, study
from apmethod.bench.error.compare import comparisons, front, orders, seconds_at
from apmethod.bench.error.problems import PROBLEMS
from apmethod.run.main import main


@pytest.mark.parametrize("name", list(PROBLEMS))
def test_exact_solutions_solve_the_equation(name):
    """du/dt + div(V u) - D lap u - growth u = 0 by differences, where u is not tiny."""
    problem = PROBLEMS[name]
    draw = np.random.default_rng(1)
    x_min, x_max, y_min, y_max = problem.box
    x, y = draw.uniform(x_min, x_max, 4000), draw.uniform(y_min, y_max, 4000)
    t, h, dt = 0.6 * problem.until, 2e-3, 2e-3
    u = problem.exact(x, y, t)
    most = u.max()
    x, y, u = (part[u > 0.01 * most] for part in (x, y, u))
    at = {(i, j): problem.exact(x + i * h, y + j * h, t) for i in (-1, 0, 1) for j in (-1, 0, 1)}
    vx, vy = problem.flow(x, y, t) if problem.flow else (0.0, 0.0)
    rate = (problem.exact(x, y, t + dt) - problem.exact(x, y, t - dt)) / (2.0 * dt)
    carried = (vx * (at[1, 0] - at[-1, 0]) + vy * (at[0, 1] - at[0, -1])) / (2.0 * h)
    laplacian = (at[1, 0] + at[-1, 0] + at[0, 1] + at[0, -1] - 4.0 * u) / h**2
    residual = rate + carried - problem.diffusivity * laplacian - problem.growth * u
    scale = np.abs(rate).max() + np.abs(carried).max() + problem.diffusivity * most / h
    assert np.abs(residual).max() < 2e-3 * scale


@pytest.mark.parametrize("name", ["walls", "box", "relaxation"])
def test_nothing_flows_through_the_walls(name):
    problem = PROBLEMS[name]
    y = np.linspace(*problem.box[2:], 50)
    for wall in problem.box[:2]:
        x = np.full(50, wall)
        slope = problem.exact(x + 1e-5, y, 0.3) - problem.exact(x - 1e-5, y, 0.3)
        assert np.abs(slope).max() < 1e-12


def runs(*pairs, kind="agents"):
    return [{"problem": "p", "contender": kind, "kind": kind, "size": 1000 * 4**k,
             "seconds": s, "error": e} for k, (s, e) in enumerate(pairs)]  # fmt: skip


def test_fronts_and_times_at_equal_error():
    rows = runs((1.0, 1e-2), (2.0, 2e-2), (4.0, 1e-4))
    best = front(rows)
    assert [row["seconds"] for row in best] == [1.0, 4.0]
    assert seconds_at(best, 1e-3) == pytest.approx(2.0)
    assert seconds_at(best, 0.5) == 1.0
    assert seconds_at(best, 1e-5) is None


def test_comparisons_and_orders():
    rows = runs((1.0, 1e-2), (4.0, 1e-4)) + runs((10.0, 1e-2), (40.0, 1e-4), kind="elements")
    assert orders(rows)[0]["order"] == pytest.approx(np.log(100) / np.log(2))
    found = comparisons(rows, ["p"])
    assert found[0]["times_less"] == pytest.approx(10.0)
    assert found[-1]["error"] == 1e-2  # the smallest within ten seconds


def small_study(tmp_path, capsys):
    arguments = ["--sizes", "150,300", "--problems", "diffusion", "--out", str(tmp_path)]
    assert main(["bench", "error", "--quick", *arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_study_and_that_it_resumes(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(study, "QUICK_EDGES", (4, 6))
    results = small_study(tmp_path, capsys)
    assert {row["contender"] for row in results["rows"]} >= set(study.SCHEMES)
    assert {row["size"] for row in results["rows"] if row["kind"] == "agents"} == {150, 300}
    with open(tmp_path / "error.csv") as file:
        assert len(list(csv.DictReader(file))) == len(results["rows"])
    assert (tmp_path / "error.png").read_bytes().startswith(b"\x89PNG")

    def never(*arguments):
        raise AssertionError("a run was made again")

    monkeypatch.setattr(study, "run_agents", never)
    monkeypatch.setattr(study, "run_elements", never)
    assert small_study(tmp_path, capsys)["rows"] == results["rows"]


def test_an_unknown_problem_is_refused(capsys):
    assert main(["bench", "error", "--problems", "weather"]) == 2
    assert "problem is 'weather'; it must be one of mixture-1e-3" in capsys.readouterr().err


@pytest.mark.skipif(freefem.executable() is None, reason="FreeFem++ is not installed")
@pytest.mark.parametrize("scheme", list(freefem.SCHEMES))
@pytest.mark.parametrize("name", ["hill-1e-3", "anisotropic", "shear", "disc", "box", "decay"])
def test_freefem_solves_the_same_problem(name, scheme):
    row = study.run_elements(freefem, PROBLEMS[name], scheme, 20, 100)
    assert row["error"] < 0.15
    assert row["seconds"] > 0.0


@pytest.mark.skipif(freefem.executable() is None, reason="FreeFem++ is not installed")
def test_the_shortest_run_of_freefem_is_timed_finer_than_by_the_tick_of_a_clock():
    (scheme, *_), problem = freefem.SCHEMES, PROBLEMS["diffusion"]
    seconds = {study.run_elements(freefem, problem, scheme, 4, 2)["seconds"] for _ in range(8)}
    assert min(seconds) > 0.0
    assert len(seconds) == 8


@pytest.mark.skipif(not scikit_fem.installed(), reason="scikit-fem is not installed")
@pytest.mark.parametrize("name", ["hill-1e-3", "box"])
def test_scikit_fem_solves_the_same_problem(name):
    (scheme,) = scikit_fem.SCHEMES
    assert study.run_elements(scikit_fem, PROBLEMS[name], scheme, 20, 100)["error"] < 0.15
