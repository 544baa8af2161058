"""The largest stable step for agents that stand in disorder or weigh very different.

Nothing is at rest there, so a run is compared with one of a small step: it is stable
if its velocities at the end are at most twice those of the other one.  Where that one has not
come to rest itself, there is no limit to be found: no step is stable.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from apmethod.bench.stability.boxes import STARTS, Box
from apmethod.bench.stability.limits import Scheme
from apmethod.model import MARGIN

#: Schemes as the named accuracies have them, and smoothing length over spacing.
SCHEMES: dict[str, tuple[Scheme, float]] = {
    "paper": (("paper", "cubic", "predictor_corrector"), 1.3),
    "conservative": (("blob", "gaussian", "strang_3"), 1.4),
    "accurate": (("plain", "gaussian_6", "strang_3"), 1.9),
}
#: Length of a run in steps of the theory's limit; the share of it that is a small step, and those
#: that are tried.
_SPAN, _CALM, _SHARES = 30.0, 0.05, (0.1, 3.0)
#: Slower than this, |A| h/D, agents have come to rest.
_REST = 0.03
#: A small disorder, in smoothing lengths, that lattices start from, too.
_SHAKEN = 1e-3


#: Agents along a side: the widest kernel reaches eight spacings, half the box.
_ALONG = 16


def disorder(name: str, halvings: int) -> list[dict[str, Any]]:
    """One row for each way to stand at the start, with equal masses."""
    return [measured(name, start, 1.0, halvings) for start in STARTS]


def mass_ratios(name: str, decades: Sequence[int], halvings: int) -> list[dict[str, Any]]:
    """One row for each ratio of the largest mass to the least, on a jittered lattice.

    Their logarithms are uniform and random: the worst case, next to each other stand agents
    that have nothing in common.
    """
    return [measured(name, "jittered", 10.0**decade, halvings) for decade in decades]


def measured(name: str, start: str, ratio: float, halvings: int) -> dict[str, Any]:
    """The limit of one start, by that many halvings, 0 where no step is stable.

    Beside it the step that the model chooses, and what the first velocities are like.
    """
    scheme, spacings = SCHEMES[name]
    box = Box(*scheme, along=_ALONG, spacings=spacings, start=start, mass_ratio=ratio)
    calm = _speeds(box, _CALM)
    low, high = _SHARES
    for _ in range(halvings):
        middle = np.sqrt(low * high)
        if _speeds(box, middle)[-1] < 2.0 * calm[-1]:
            low = middle
        else:
            high = middle
    box.put(_SHAKEN * box.bus.smoothing_length)
    box.speeds(_CALM * box.limit, 1)
    rate, mass = box.particles.array("_rate"), box.particles.mass
    size = np.hypot(*rate.T)
    top = box.motion.laws[0].largest_speed(box.bus.smoothing_length)
    return {
        "study": "start", "accuracy": name, "start": start, "mass_ratio": ratio,
        "share_of_limit": float(np.sqrt(low * high)) if calm[-1] < _REST else 0.0,
        "chosen": MARGIN * box.watch.share_left(), "unevenness": box.watch.unevenness,
        "speed_first": float(calm[0]), "speed_last": float(calm[-1]),
        "mass_at_limit": float(mass[size >= top * (1.0 - 1e-9)].sum() / mass.sum()),
        "momentum": float(np.abs(mass @ rate).max() / (mass @ size)),
    }  # fmt: skip


def _speeds(box: Box, share: float) -> np.ndarray:
    """Velocities of a run."""
    box.put(_SHAKEN * box.bus.smoothing_length)
    return box.speeds(share * box.limit, round(_SPAN / share))
