"""What signals, groups and strategies cost a step.

The same animals step without a signal, with one, and with signal and groups; groups are
held against scikit-learn's DBSCAN, whose labels they must equal before anything is timed;
and leaders with a strategy in Python are counted among compiled animals.
"""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np

from apmethod.agent import AgentParticle
from apmethod.bench.results import Disagreement
from apmethod.bench.timing import alternate, stopwatch
from apmethod.model import ParticleModel
from apmethod.move.diffusion import Diffusion
from apmethod.perceive.domain import Periodic
from apmethod.skills.animal import Animal
from apmethod.skills.cluster import clusters
from apmethod.skills.follow import Follow
from apmethod.skills.groups import Groups
from apmethod.skills.signal import SignalField

#: Groups: distance at which animals are near, and how many make one a core agent.
_NEAR, _LEAST = 1.0, 10


class _Leader(Animal):
    """Adds a push of its own in Python."""

    def dynamics(self) -> np.ndarray:
        return super().dynamics() + np.array([0.1, 0.0])


def population(
    size: int, *, signal: bool = False, groups: bool = False, sensing: str = "vicinity",
    leaders: int = 0,
) -> ParticleModel:  # fmt: skip
    """Animals at random, one to a unit of area, with 28 neighbours."""
    side = float(np.ceil(np.sqrt(size)))
    field = SignalField(
        1.0, production=0.3, diffusivity=0.2, evaporation=0.1, sensing=sensing
    )  # fmt: skip
    model = ParticleModel(
        [Animal, _Leader],
        core_radius=3.0,
        domain=Periodic((0, 0), (side, side)),
        laws=[Diffusion(0.1), *([Follow(field, 0.1)] if signal else [])],
        skills=[*([field] if signal else []), *([Groups(_NEAR, _LEAST)] if groups else [])],
        dt=0.25,
        rng=0,
    )
    draw = np.random.default_rng(0)
    for cls, count in ((Animal, size - leaders), (_Leader, leaders)):
        cls.create_agents(model, count, position=side * draw.random((count, 2)))
    return model


def steps(size: int, rounds: int) -> list[dict[str, Any]]:
    """Seconds of a step without signal, with one sensed either way, and with groups, too."""
    models = {
        "diffusion only": population(size),
        "signal, bilinear": population(size, signal=True, sensing="bilinear"),
        "signal, vicinity": population(size, signal=True),
        "signal, vicinity, and groups": population(size, signal=True, groups=True),
    }
    return _timed(models, size, rounds)


def leaders(size: int, count: int, rounds: int) -> list[dict[str, Any]]:
    """Seconds of a step with and without leaders in Python, and of their methods alone."""
    with_leaders = population(size, signal=True, groups=True, leaders=count)
    models = {
        "all compiled": population(size, signal=True, groups=True),
        f"{count} leaders in Python": with_leaders,
    }
    rows = _timed(models, size, rounds)
    own = [agent for agent in with_leaders.particles.agents if isinstance(agent, _Leader)]
    motion = with_leaders.motion
    motion.begin(with_leaders.elapsed, with_leaders.dt)
    motion.enter(motion.stages()[0], with_leaders.bus.smoothing_length)
    calls = alternate({"calls": lambda: stopwatch(lambda: _move(own))}, rounds)["calls"]
    motion.end()
    row = {"contender": f"their {count} calls of move alone", "agents": count,
           "median_seconds": calls.median, "minimum_seconds": calls.minimum}  # fmt: skip
    return [*rows, row | {"times": calls.median / rows[0]["median_seconds"]}]


def _move(agents: list[AgentParticle]) -> None:
    for agent in agents:
        agent.move()


def _timed(models: dict[str, ParticleModel], size: int, rounds: int) -> list[dict[str, Any]]:
    for model in models.values():
        model.step()
        model.step()
    times = alternate({k: lambda m=m: stopwatch(m.step) for k, m in models.items()}, rounds)
    first = next(iter(times.values())).median
    return [
        {
            "contender": name, "agents": size, "median_seconds": found.median,
            "minimum_seconds": found.minimum, "times": found.median / first,
        }
        for name, found in times.items()
    ]  # fmt: skip


def groups(size: int, rounds: int) -> list[dict[str, Any]]:
    """Seconds of finding groups, by scikit-learn where it is installed.

    Raises:
        Disagreement: if the labels differ.
    """
    draw = np.random.default_rng(1)
    side = np.sqrt(size)
    gathered = size // 2
    centres = side * draw.random((max(1, size // 200), 2))
    positions = np.concatenate([
        side * draw.random((size - gathered, 2)),
        centres[draw.integers(0, len(centres), gathered)] + draw.normal(size=(gathered, 2)),
    ])  # fmt: skip
    contenders = {"apmethod": lambda: stopwatch(lambda: clusters(positions, _NEAR, _LEAST))}
    if importlib.util.find_spec("sklearn") is not None:
        from sklearn.cluster import DBSCAN

        search = DBSCAN(eps=_NEAR, min_samples=_LEAST)
        if not np.array_equal(search.fit(positions).labels_, clusters(positions, _NEAR, _LEAST)):
            raise Disagreement("groups differ from scikit-learn's; nothing has been timed")
        contenders["scikit-learn"] = lambda: stopwatch(lambda: search.fit(positions))
    times = alternate(contenders, rounds)
    return [
        {
            "contender": name, "agents": size, "median_seconds": found.median,
            "minimum_seconds": found.minimum, "times": found.median / times["apmethod"].median,
        }
        for name, found in times.items()
    ]  # fmt: skip
