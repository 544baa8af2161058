"""The compiled evaluations give the same sums, and the same bits on any number of threads."""

import numpy as np
import pytest

from apmethod import (
    Bounded,
    Column,
    Mirrored,
    Open,
    Periodic,
    brute_force_pairs,
    explain,
    set_threads,
    term,
)
from apmethod.compile import memory, threads
from apmethod.message import parts
from apmethod.message.passes import EVALUATIONS
from apmethod.perceive.domain import Domain
from apmethod.perceive.images import MIRROR
from apmethod.perceive.lists import neighbour_lists
from samples import Curious, build, column_by_id

DOMAINS = {
    "open": Open(),
    "bounded": Bounded((0.0, 0.0), (1.0, 1.0)),
    "periodic": Periodic((0.0, 0.0), (1.0, 1.0)),
    "mirrored": Mirrored((0.0, 0.0), (1.0, 1.0)),
    "pipe": Domain((0.0, 0.0), (1.0, 1.0), ("periodic", "mirrored")),
    "channel": Domain((0.0, 0.0), (1.0, 1.0), ("periodic", "bounded")),
}


class Seer(Curious):
    """Perceives in Python, as all do."""

    def perceive(self):
        super().perceive()


def after_two_steps(**options):
    model = build(300, agent_class=Curious, dt=1e-3, **options)
    model.particles.assign("charge", 1.0 + model.particles.position[:, 0])
    for _ in range(2):
        model.step()
    return model


@pytest.mark.parametrize("level", [0, 1, 2])
@pytest.mark.parametrize("domain", list(DOMAINS))
@pytest.mark.parametrize("evaluation", ["scattered", "stored"])
def test_all_evaluations_agree(evaluation, domain, level):
    options = {"domain": DOMAINS[domain], "level": level}
    expected = after_two_steps(evaluation="gathered", **options)
    found = after_two_steps(evaluation=evaluation, **options)
    for name in expected.particles.names:
        a, b = getattr(expected.particles, name), getattr(found.particles, name)
        assert np.abs(a - b).max() <= 1e-12 * np.abs(a).max(), name


@pytest.mark.parametrize("domain", list(DOMAINS))
def test_parts_that_reach_over_several_others_agree(domain, monkeypatch):
    options = {"domain": DOMAINS[domain], "level": 1}
    expected = after_two_steps(evaluation="gathered", **options)
    monkeypatch.setattr(parts, "_LEAST", 1)  # as many parts as there can be
    monkeypatch.setattr(parts, "_COPIES", np.inf)
    found = after_two_steps(evaluation="scattered", **options)
    for name in expected.particles.names:
        a, b = getattr(expected.particles, name), getattr(found.particles, name)
        assert np.abs(a - b).max() <= 1e-12 * np.abs(a).max(), name


class Kind(Curious):
    """Is of one of two kinds."""

    kind = Column()

    @term("directed", reads=("kind",))
    def liked(pair, i, j):
        """It fails, as one would that looks a column up in a table."""
        if j.kind > 1e6:
            raise ValueError("there are not so many kinds")
        return i.kind * j.kind * pair.w


@pytest.mark.parametrize("domain", ["open", "periodic", "mirrored"])
@pytest.mark.parametrize("evaluation", EVALUATIONS)
def test_formulas_are_given_agents_only(evaluation, domain, monkeypatch):
    def far_off(shape, dtype=float):
        array = np.empty(shape, dtype)
        if array.dtype == float:
            array[...] = 1e9
        return array

    def liked():
        model = build(203, agent_class=Kind, domain=DOMAINS[domain], evaluation=evaluation)
        model.particles.assign("kind", np.arange(203) % 2)
        model.step()
        return model.particles.liked

    expected = liked()
    monkeypatch.setattr(memory, "empty", far_off)
    assert np.array_equal(liked(), expected)


@pytest.mark.parametrize("evaluation", EVALUATIONS)
def test_mixed_scenes_agree(evaluation):
    models = [
        after_two_steps(evaluation=evaluation, others=[Seer], tier=tier)
        for tier in ("compiled", "agents")
    ]
    for name in models[0].particles.names:
        a, b = (column_by_id(model, name) for model in models)
        assert np.abs(a - b).max() <= 1e-12 * np.abs(a).max(), name


@pytest.mark.parametrize("evaluation", EVALUATIONS)
def test_threads_change_no_bit(evaluation):
    before, found = threads(), set()
    try:
        for count in (1, 2, 3):
            set_threads(count)
            model = build(5000, agent_class=Curious, core_radius=0.05, evaluation=evaluation,
                          domain=DOMAINS["periodic"])  # fmt: skip
            model.step()
            table = model.particles
            found.add(b"".join(getattr(table, name).tobytes() for name in table.names))
    finally:
        set_threads(before)
    assert len(found) == 1


@pytest.mark.parametrize("domain", list(DOMAINS))
def test_lists_hold_the_neighbours_and_nothing_else(domain):
    positions = np.random.default_rng(8).integers(0, 12, (200, 2)) / 11.0
    model = build(positions=positions, domain=DOMAINS[domain], core_radius=0.2)
    cells = model.space.cells
    lists = neighbour_lists(cells)
    found = {
        (cells.row[k], cells.row[other])
        for k in range(len(cells.row))
        for other in lists.other[lists.start[k] : lists.start[k + 1]]
        if not DOMAINS[domain].mirrors or cells.image[other] != MIRROR
    }
    pairs = brute_force_pairs(positions, 0.2, DOMAINS[domain])
    assert found == {(i, j) for i, j in pairs} | {(j, i) for i, j in pairs}
    if not DOMAINS[domain].mirrors:
        assert len(lists.other) == 2 * len(pairs)


def test_which_one_runs_is_told_and_can_be_forced():
    assert dict(explain(build(5)))["contribute 1"].endswith("compiled, scattered")
    forced = build(5, evaluation="stored")
    assert dict(explain(forced))["contribute 2"].endswith("compiled, stored")
    with pytest.raises(ValueError, match="evaluation is 'fast'; it must be 'auto', 'gathered'"):
        build(5, evaluation="fast")
