"""Whether a small wave of animals grows as linear theory says (paper 3.2, eq 3.4).

Agents on a lattice in a periodic square are displaced by a small wave of number k, and the
signal starts as the wave's eigenvector.  The growth rate is fitted to the logarithm of the
wave's amplitude, which is the Fourier sum of the agents' positions: nothing stands between
the agents and the number.  There is one animal to a unit of area, as in the scene; an agent
is a tenth of one, so that the waves that decay, as short as three agents' perception there,
are long beside the smoothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from apmethod.bench.timing import Progress, Report
from apmethod.contribute.smoothing import GAUSSIAN
from apmethod.model import ParticleModel
from apmethod.move.diffusion import Diffusion
from apmethod.perceive.domain import Periodic
from apmethod.skills.animal import Animal
from apmethod.skills.follow import Follow, growth_rate
from apmethod.skills.signal import SignalField

#: The paper's parameters of Figure 9; the sensitivity is lambda.
PRODUCTION, EVAPORATION, SENSITIVITY = 0.3, 0.1, 0.1
SIGNAL_DIFFUSIVITY, DIFFUSIVITY = 0.2, 0.1
#: Waves in the box: the first four grow, the others decay.
WAVES = (1, 2, 3, 4, 6, 7, 8)
#: Agents along the box, and the box's side.
ALONG, SIDE = 100, 30.0
#: Displacement of the animals over the wave's length, and how long it is watched.
_AMPLITUDE, _TIME, _DT = 1e-4, 5.0, 0.05


def waves(
    numbers: Sequence[int] = WAVES, along: int = ALONG, report: Report | None = None
) -> list[dict[str, Any]]:
    """Growth rate of each wave, measured and by the dispersion relation.

    Args:
        numbers: how many waves fit in the box, for each measurement.
        along: agents along the box; their number is its square.
    """
    progress = Progress(report, [along**2] * len(numbers))
    rows = []
    for number in numbers:
        measured, expected = measure(number, along, SENSITIVITY)
        rows.append({
            "agents": along**2, "waves": number, "k": 2.0 * np.pi * number / SIDE,
            "expected": expected, "measured": measured, "off": measured / expected - 1.0,
        })  # fmt: skip
        progress.made(along**2)
    return rows


def threshold(number: int = 1, along: int = ALONG) -> dict[str, Any]:
    """The sensitivity at which a long wave neither grows nor decays, by regula falsi."""
    k = 2.0 * np.pi * number / SIDE
    loss = SIGNAL_DIFFUSIVITY * k * k + EVAPORATION
    expected = DIFFUSIVITY * loss / PRODUCTION
    below, above = 0.8 * expected, 1.2 * expected
    low, high = (measure(number, along, value)[0] for value in (below, above))
    for _ in range(3):
        found = below - low * (above - below) / (high - low)
        rate = measure(number, along, found)[0]
        if rate < 0.0:
            below, low = found, rate
        else:
            above, high = found, rate
    return {
        "agents": along**2, "waves": number, "k": k, "expected": expected,
        "measured": found, "off": found / expected - 1.0,
    }  # fmt: skip


def measure(number: int, along: int, sensitivity: float) -> tuple[float, float]:
    """Growth rate of a wave, measured and by the dispersion relation."""
    k = 2.0 * np.pi * number / SIDE
    model, expected = perturbed(k, along, sensitivity)
    times, sizes = [], []
    while model.elapsed < _TIME:
        times.append(model.elapsed)
        sizes.append(abs(np.exp(-1j * k * model.particles.position[:, 0]).sum()))
        model.step()
    return float(np.polyfit(times, np.log(sizes), 1)[0]), expected


def perturbed(k: float, along: int, sensitivity: float) -> tuple[ParticleModel, float]:
    """A uniform population with a wave of number k along x, and the rate it should grow at."""
    spacing = SIDE / along
    signal = SignalField(
        SIDE / 240, production=PRODUCTION, diffusivity=SIGNAL_DIFFUSIVITY, evaporation=EVAPORATION
    )
    follow = Follow(signal, sensitivity)
    model = ParticleModel(
        Animal,
        core_radius=1.35 * spacing * GAUSSIAN.support,
        domain=Periodic((0, 0), (SIDE, SIDE)),
        kernel=GAUSSIAN,
        laws=[Diffusion(DIFFUSIVITY), follow],
        skills=[signal],
        dt=_DT,
        rng=0,
    )
    rate = float(growth_rate(k, 1.0, DIFFUSIVITY, follow))
    x, y = spacing * (np.mgrid[:along, :along].reshape(2, -1) + 0.5)
    # A displacement d sin(k x) makes u = 1 - d k cos(k x) to first order.
    length = _AMPLITUDE * 2.0 * np.pi / k
    places = np.column_stack([(x + length * np.sin(k * x)) % SIDE, y])
    Animal.create_agents(model, along**2, position=places, mass=spacing**2)
    # The eigenvector: s1 (rate + Ds k^2 + beta) = alpha u1.
    share = PRODUCTION / (rate + SIGNAL_DIFFUSIVITY * k * k + EVAPORATION)
    wave = -length * k * np.cos(k * signal.patches.centres()[0])
    signal.values = PRODUCTION / EVAPORATION + share * wave
    return model, rate
