"""The stability study: its parts on small runs, its files, and the shipped scenes."""

import csv
import json

import numpy as np
import pytest

from apmethod.bench.stability import limits, long_runs, scales, starts, study
from apmethod.bench.stability.boxes import STARTS, Box, places
from apmethod.model import MARGIN
from apmethod.run.main import main
from apmethod.run.scenes import shipped_scenes


@pytest.mark.parametrize(
    "scheme",
    [("paper", "cubic", "euler"), ("plain", "gaussian", "midpoint"),
     ("plain", "wendland_c4", "midpoint"), ("plain", "gaussian_4", "midpoint"),
     ("blob", "gaussian", "euler"), ("blob", "gaussian", "heun_3"), ("blob", "gaussian", "rk4")],
)  # fmt: skip
def test_limits_are_those_of_the_theory(scheme):
    found = limits.limit(scheme)
    assert found["measured"] == pytest.approx(found["theory"], rel=0.05)
    assert found["measured_over_theory"] > MARGIN


def test_splines_pair_and_kernels_with_a_positive_transform_do_not():
    assert limits.pairing_rate("blob", "cubic") > limits.pairing_rate("blob", "quintic") > 0.0
    assert limits.pairing_rate("blob", "cubic") == pytest.approx(0.0703, rel=0.01)
    for kernel in ("wendland_c2", "wendland_c4", "gaussian"):
        assert limits.pairing_rate("blob", kernel) == 0.0
    assert limits.pairing_rate("paper", "cubic") == 0.0  # a square is never negative


def test_a_map_tells_growth_from_decay():
    rows = limits.growths(("blob", "gaussian", "midpoint"), [1.0, 1.6], [0.5, 0.9, 1.3], along=16)
    growth = np.array([row["growth"] for row in rows]).reshape(2, 3)
    assert growth[1, 0] < growth[1, 1] + 0.05 < 1.05
    assert growth[1, 2] > 1.1
    assert growth[0, 1] > 1.1  # too few neighbours: the sums are no integrals


@pytest.mark.parametrize("start", STARTS)
def test_starts_stand_in_the_box(start):
    found = places(start, 12, np.random.default_rng(1))
    assert found.shape == (144, 2)
    assert found.min() >= 0.0
    assert found.max() < 1.0


@pytest.mark.parametrize(("start", "ratio"), [("random", 1), ("clustered", 1), ("jittered", 1e4)])
def test_a_chosen_step_is_stable_however_agents_stand_and_whatever_they_weigh(start, ratio):
    row = starts.measured("conservative", start, ratio, 4)
    assert row["chosen"] < 0.9 * row["share_of_limit"]
    assert row["speed_last"] < 0.1 * row["speed_first"]
    assert row["momentum"] < 1e-14
    assert row["mass_at_limit"] == 0.0


def test_where_no_step_is_stable_there_is_no_limit():
    (row,) = starts.mass_ratios("paper", [5], 1)
    assert row["share_of_limit"] == 0.0
    assert study.margin([row | {"mass_ratio": 1.0}, *_known()])["with uneven masses"] == (0.4, 0.5)


def _known():
    """Rows of a study, to find margins in."""
    limit = {"study": "limit", "measured_over_theory": 0.9}
    start = {"study": "start", "mass_ratio": 1.0, "chosen": 0.7, "share_of_limit": 0.8}
    uneven = [
        start | {"mass_ratio": 10.0, "chosen": chosen, "share_of_limit": 0.5}
        for chosen in (0.3, 0.4)
    ]
    return [limit, start, *uneven]


def test_a_run_that_fails_is_infinitely_fast(monkeypatch):
    box = Box("blob", "gaussian", "euler", along=16, spacings=1.4)

    def fail():
        raise RuntimeError

    monkeypatch.setattr(box, "step", fail)
    assert box.speeds(1.0, 3).tolist() == [np.inf] * 3


@pytest.mark.parametrize("accuracy", ["paper", "conservative", "accurate"])
def test_twelve_decades_of_units_change_nothing(accuracy):
    rows = scales.units(accuracy, (0, -9, -4, 3), 300)
    assert max(row["off"] for row in rows) < 1e-10
    assert len({row["steps"] for row in rows if row["flow"] == "none"}) == 1


def test_errors_stay_bounded_at_every_peclet_number():
    rows = scales.peclet("accurate", (1e-2, 1e-5, 1e-9), 300)
    assert max(row["error"] for row in rows) < 5e-3
    assert max(row["mass_drift"] for row in rows) < 1e-13


def test_long_runs_keep_mass_momentum_and_centre_and_gain_order():
    rest = long_runs.at_rest(300)
    assert rest["order_last"] > rest["order_first"]
    turning = long_runs.turning("conservative", 50)
    assert turning["order_last"] > 0.9
    for row in (rest, turning):
        assert row["mass_drift"] == 0.0
        assert row["largest_momentum"] < 1e-13
        assert row["centroid_drift"] < 1e-12


@pytest.mark.parametrize("name", ["obstacles", "rotating_hill"])
def test_scenes_stay_within_their_bounds(name):
    assert long_runs.scene(name)["kept"], name


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped_scenes())
def test_every_shipped_scene_stays_within_its_bounds_ten_times_its_length(name):
    row = long_runs.scene(name)
    assert row["kept"], row


def small_study(tmp_path, capsys):
    assert main(["bench", "stability", "--quick", "--out", str(tmp_path)]) == 0
    return capsys.readouterr().out, json.loads((tmp_path / "stability.json").read_text())


def test_the_command_and_that_it_resumes(monkeypatch, capsys, tmp_path):
    scheme, scale = ("blob", "gaussian", "euler"), {"accuracy": "conservative", "particles": 100}
    parts = [
        study.Part(limits.limit, {"scheme": scheme}),
        study.Part(
            limits.growths, {"scheme": scheme, "spacings": [1.4], "shares": [0.5, 1.5], "along": 16}
        ),
        study.Part(starts.disorder, {"name": "conservative", "halvings": 1}),
        study.Part(starts.mass_ratios, {"name": "conservative", "decades": [1], "halvings": 1}),
        study.Part(scales.units, {"decades": [0, 3], **scale}),
        study.Part(scales.peclet, {"diffusivities": [1e-2, 1e-4], **scale}),
        study.Part(long_runs.at_rest, {"steps": 5}),
        study.Part(long_runs.scene, {"name": "obstacles", "times": 0.2}),
    ]
    monkeypatch.setattr(study, "_quick", lambda: parts)
    out, results = small_study(tmp_path, capsys)
    for title in ("largest stable D dt/h^2", "disorder and uneven masses", "long runs", "chosen"):
        assert title in out
    assert results["margin"]["on a lattice"][0] == MARGIN
    with open(tmp_path / "stability.csv") as file:
        assert len(list(csv.DictReader(file))) == len(results["rows"]) == 16
    assert (tmp_path / "stability.png").read_bytes().startswith(b"\x89PNG")

    # As if it had been stopped before the last part.
    kept = (tmp_path / "runs.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "runs.jsonl").write_text("".join(kept[:-1]))
    made, or_made = [], study.Kept.or_made
    monkeypatch.setattr(
        study.Kept, "or_made",
        lambda kept, key, make: or_made(kept, key, lambda: made.append(key["part"]) or make()),
    )  # fmt: skip
    assert small_study(tmp_path, capsys)[1]["rows"] == results["rows"]
    assert made == ["scene"]


def test_the_study_has_sizes_of_its_own(capsys):
    assert main(["bench", "stability", "--sizes", "10"]) == 2
    assert "sizes is [10]; the stability study has" in capsys.readouterr().err
