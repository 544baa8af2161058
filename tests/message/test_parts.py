"""Parts of a scattered round: they cover all sub-domains, and their tables what these reach."""

from itertools import pairwise

import numpy as np
import pytest

from apmethod import Mirrored, Open, Periodic
from apmethod.compile import LANES
from apmethod.message import parts
from samples import Curious, build

UNIT = (0.0, 0.0), (1.0, 1.0)
DOMAINS = {"open": Open(), "periodic": Periodic(*UNIT), "mirrored": Mirrored(*UNIT)}


@pytest.mark.parametrize("least", [1, 1000, 10_000])
@pytest.mark.parametrize("domain", list(DOMAINS))
def test_parts_cover_all_sub_domains_and_reach_as_far_as_their_runs(domain, least):
    cells = build(300, agent_class=Curious, domain=DOMAINS[domain], level=1).space.cells
    runs = cells.runs, cells.image
    cell, begin, end, base = parts._divide(*runs, least, 8, np.inf)
    assert [cell[0], cell[-1]] == [0, len(cells.number)]
    assert (np.diff(cell) > 0).all()
    assert (5 if least == 1 else 1) <= len(begin) <= 8
    for part, (first, last) in enumerate(pairwise(cell)):
        assert begin[part] == cells.start[first]
        runs_of_part = slice(cells.first[first], cells.first[last])
        assert end[part] >= max(cells.high[runs_of_part].max(), cells.start[last])
    assert np.array_equal(np.diff(base), end - begin + LANES)  # whole vectors end behind them
    for copies in (1.0, 2.5):
        less = parts._divide(*runs, least, 8, copies)[-1]
        assert less[-1] <= copies * len(cells.row) or len(less) <= 3
        assert len(less) <= len(base)
