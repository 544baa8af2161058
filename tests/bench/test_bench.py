"""The benchmarks run, check before they time, and count what the paper predicts."""

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from apmethod.bench.aggregation import dispersion, gatherings
from apmethod.bench.aggregation import study as aggregation
from apmethod.bench.cloud import Cloud, core_radius_for
from apmethod.bench.mesa_spaces import SPACES
from apmethod.bench.neighbours import report as neighbours_report
from apmethod.bench.neighbours import study as neighbours
from apmethod.bench.obstacles import study as obstacles
from apmethod.bench.population import candidates, exchange, population, put, take
from apmethod.bench.results import Disagreement
from apmethod.bench.sums import study as sums
from apmethod.bench.sums.pysph_peer import PySPH
from apmethod.bench.timing import Progress, alternate
from apmethod.run.main import main


def bench(capsys, tmp_path, name, *arguments):
    """The JSON that a benchmark prints, once its files have been looked at."""
    code = main(["bench", name, *arguments, "--json", "--out", str(tmp_path)])
    captured = capsys.readouterr()
    assert code == 0, captured.err
    results = json.loads(captured.out)
    assert results["benchmark"] == name
    assert {"processor", "threads", "versions"} <= set(results["machine"])
    with open(tmp_path / f"{name}.csv") as file:
        assert len(list(csv.DictReader(file))) == len(results["rows"])
    assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    written = json.loads((tmp_path / f"{name}.json").read_text())
    assert written["rows"] == results["rows"]
    return results


def test_obstacles(capsys, tmp_path):
    arguments = ["--quick", "--sizes", "80,400", "--rounds", "1"]
    results = bench(capsys, tmp_path, "obstacles", *arguments)
    ours = [row for row in results["rows"] if row["contender"] == "surface area"]
    assert {(row["walls"], row["rays"]) for row in ours} == {
        (size, length) for size in (80, 400) for length in ("short", "long")
    }
    for row in ours:
        assert row["other_hits"] == 0
        assert row["skipped"] > (0.5 if row["rays"] == "short" else 0.0)
    assert len(results["moving"]) == 2
    assert {(row["agents"], row["moving"]) for row in results["far"]} == {
        (agents, moving) for agents in (2000, 16_000) for moving in (0, 10)
    }


def test_a_peer_that_finds_other_walls_is_refused(monkeypatch):
    monkeypatch.setattr(
        obstacles, "shapely_finder", lambda walls: lambda starts, ends: np.zeros(len(starts))
    )
    with pytest.raises(Disagreement, match=r"shapely STRtree: .* other first walls"):
        obstacles.study([80], rounds=1, count=500)


def test_neighbours(capsys, tmp_path):
    arguments = ["--quick", "--sizes", "300,1000", "--steps", "2", "--mesa"]
    results = bench(capsys, tmp_path, "neighbours", *arguments)
    found = {(row["agents"], row["tier"], row["algorithm"]) for row in results["rows"]}
    assert len(found) == 2 * 2 * 3
    for row in results["rows"]:
        assert row["median_seconds"] >= row["minimum_seconds"] > 0.0
        assert row["gain_in_time"] is None or row["algorithm"] != "A1"
    assert {row["contender"] for row in results["mesa"]} > set(SPACES)
    assert [len(cells) for _, _, cells in neighbours_report.tables(results)] == [6, 4, 4]


@pytest.mark.parametrize("level", [0, 1, 2])
def test_counted_candidates_are_those_of_table_2(level):
    size = 2000
    core_radius = core_radius_for(size)
    cloud = Cloud(size, core_radius, periodic=True, seed=3)
    model = population(
        cloud.positions, core_radius, [neighbours.near], domain=neighbours.DOMAIN, level=level
    )
    counted = []
    for _ in range(5):
        cloud.move()
        put(model, cloud.positions)
        counted.append(candidates(model))
    predicted = neighbours.predicted_candidates(size, core_radius, level)
    assert np.mean(counted) == pytest.approx(predicted, rel=0.02)


def test_levels_that_find_other_neighbours_are_not_timed():
    cloud = Cloud(400, 0.0, periodic=True, seed=1)
    models = neighbours.build_levels(cloud.positions, 0.1)
    assert neighbours.check_same_neighbours(models, cloud.positions) > 0
    models["A2"].space.core_radius = 0.101
    with pytest.raises(Disagreement, match="A2"):
        neighbours.check_same_neighbours(models, cloud.positions)


def test_sums(capsys, tmp_path):
    results = bench(capsys, tmp_path, "sums", "--sizes", "300,2500", "--rounds", "2")
    assert {"arithmetic_candidates_per_second", "peak_candidates_per_second", "how"} <= set(
        results["roofline"]
    )
    rows = {(row["agents"], row["contender"]): row for row in results["rows"]}
    assert (300, "SciPy cKDTree") in rows
    assert (300, "Mesa, space") in rows
    assert (2500, "Mesa, space") not in rows  # beyond its limit
    ours = [row for (_, name), row in rows.items() if name.startswith("apmethod")]
    assert ours[0]["factor_to_arithmetic"] > 0.0
    assert all(row["relative_difference"] <= sums.TOLERANCE for row in ours)


class Contender:
    """Says what it has found."""

    def __init__(self, found, pairs):
        self._found, self._pairs = found, pairs

    def sums(self):
        return self._found

    def pairs(self):
        return self._pairs


def test_sums_are_checked():
    draw = np.random.default_rng(2)
    positions, core_radius = draw.random((300, 2)) - 0.5, 0.15
    model = population(positions, core_radius, [sums.density, sums.density_gradient])
    exchange(model)
    expected = sums.brute_force_sums(positions, core_radius)
    found = take(model, "density"), take(model, "density_gradient")
    pairs = len(model.space.pairs())
    differences = sums.check_same_sums({"true": Contender(found, pairs)}, expected, pairs)
    assert differences["true"] < 1e-13

    for part, name in enumerate(("density", "gradient")):
        tampered = [array.copy() for array in found]
        tampered[part].flat[7] += 1e-9 * np.abs(tampered[part]).max()
        with pytest.raises(Disagreement, match=f"wrong {name}"):
            sums.check_same_sums({f"wrong {name}": Contender(tampered, pairs)}, expected, pairs)
    lost = found[0] * np.nan, found[1]
    with pytest.raises(Disagreement, match="nan"):
        sums.check_same_sums({"lost": Contender(lost, pairs)}, expected, pairs)
    with pytest.raises(Disagreement, match=f"short finds {pairs - 1} pairs"):
        sums.check_same_sums({"short": Contender(None, pairs - 1)}, expected, pairs)


def test_agents_are_put_where_they_should_be():
    here, there = np.random.default_rng(4).random((2, 50, 2)) - 0.5
    model = population(here, 0.3, [sums.density])
    put(model, there)
    assert np.array_equal(take(model, "position"), there)


@pytest.mark.parametrize("periodic", [True, False])
def test_moves_stay_in_the_square(periodic):
    cloud = Cloud(2000, 0.3, periodic=periodic, seed=6)
    before = cloud.positions
    cloud.move()
    assert np.abs(cloud.positions).max() <= 0.5
    assert (np.abs(cloud.positions - before) <= 0.3).mean() > 0.5
    assert np.histogram2d(*cloud.positions.T, bins=4)[0].min() > 80


@pytest.mark.parametrize("name", list(SPACES))
def test_mesas_spaces_find_the_same_neighbours(name):
    positions = np.random.default_rng(5).random((200, 2)) - 0.5
    model = population(positions, 0.2, [neighbours.near], domain=neighbours.DOMAIN)
    assert SPACES[name](positions, 0.2, torus=True)() == 2 * len(model.space.pairs())
    counts = np.bincount(model.space.pairs().ravel(), minlength=200)
    assert SPACES[name](positions, 0.2, torus=True, sample=20)() == counts[:20].sum()


def test_scale(capsys, tmp_path):
    arguments = ["--sizes", "1000,2000,9000000", "--largest", "2000"]
    results = bench(
        capsys, tmp_path, "scale", *arguments, "--rounds", "1", "--steps", "2", "--threads", "1"
    )
    assert results["machine"]["threads"] == 1
    assert [row["agents"] for row in results["rows"]] == [1000, 2000]
    for row in results["rows"]:
        phases = [row[f"nanoseconds_{name}"] for name in ("perceive", "contribute", "move")]
        assert min(phases) > 0.0
        assert row["nanoseconds_step"] > max(phases)
        assert row["build_over_mesa"] > 0.0
        assert {"bytes_built", "bytes_stepped", "bytes_at_most", "bytes_mesa_alone"} <= set(row)
    assert [first["cache"] for first in results["first_steps"]] == ["empty", "filled"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["neighbours", "--steps", "0"], "steps is 0; it must be a whole number, 1 or more"),
        (["scale", "--largest", "5"], "largest is 5; no size is that small"),
        (["sums", "--sizes", "50", "--pysph", "no-such-python"], "'no-such-python', which cannot"),
    ],
)
def test_bad_input_is_refused(capsys, tmp_path, arguments, message):
    assert main(["bench", *arguments, "--out", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err


def test_sizes_must_grow(capsys):
    with pytest.raises(SystemExit):
        main(["bench", "sums", "--sizes", "2000,1000"])
    assert "it must be growing whole numbers" in capsys.readouterr().err


def test_an_environment_without_pysph_is_named():
    with pytest.raises(ValueError, match="which failed: ModuleNotFoundError"):
        PySPH(sys.executable, np.zeros((2, 2)), 0.1, 1)


def test_contenders_run_in_turn():
    ran = []
    contenders = {name: lambda name=name: ran.append(name) or 1.0 for name in "ab"}
    times = alternate(contenders, 3, before=lambda: ran.append("-"))
    assert "".join(ran) == "-ab-ba-ab"
    assert times["a"].seconds == (1.0, 1.0, 1.0)


def test_contenders_warm_up_by_runs_and_by_seconds():
    for seconds, runs in ((1.0, 3), (0.004, 9)):
        ran = []
        alternate({"a": lambda s=seconds, ran=ran: ran.append(s) or s}, 1, warm=2, awake=0.03)
        assert len(ran) == runs


def test_progress_ends_at_one():
    told = []
    progress = Progress(lambda share, rounds: told.append((share, rounds)), [100, 300])
    progress.made(100)
    progress.made(300)
    assert told == [(0.0, 0), (0.25, 1), (1.0, 2)]


def test_aggregation(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(dispersion, "WAVES", (2,))
    monkeypatch.setattr(dispersion, "ALONG", 30)
    arguments = ["--quick", "--seeds", "2", "--sizes", "2000", "--rounds", "1"]
    monkeypatch.setattr(aggregation, "_LEADERS", (500, 5))
    monkeypatch.setattr(gatherings, "QUICK", 2.0)
    results = bench(capsys, tmp_path, "aggregation", *arguments)
    assert len(results["rows"]) == 3 * 2 * 2
    assert {row["contender"] for row in results["costs"]["groups"]} == {"apmethod", "scikit-learn"}
    for path in results["pictures"].values():
        assert Path(path).read_bytes().startswith(b"\x89PNG")
