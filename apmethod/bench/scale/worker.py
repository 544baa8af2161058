"""One fresh process of ``apmethod bench scale``, whose memory is nobody else's.

    python -m apmethod.bench.scale.worker mesa AGENTS            bare Mesa agents
    python -m apmethod.bench.scale.worker scene AGENTS STEPS     the rotating hill
    python -m apmethod.bench.scale.worker first AGENTS           its first steps, from nothing

Prints what it measured as JSON.
"""

from __future__ import annotations

import gc
import json
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

_BEGAN = perf_counter()
#: How often things are built; the memory is that of the first.
_BUILDS = 3
#: Agents of a model that is stepped beforehand, so that code and its compiler are loaded.
_WARM = 1000


def resident_bytes() -> int:
    """Memory of this process that is in use now; the most so far where only that is told."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except FileNotFoundError:
        return most_bytes()
    from resource import getpagesize

    return pages * getpagesize()


def most_bytes() -> int:
    """The most memory that this process has had."""
    from resource import RUSAGE_SELF, getrusage

    return getrusage(RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def bare_mesa(agents: int) -> dict[str, Any]:
    """Time and memory of agents that are nothing but Mesa's."""
    import mesa

    def build() -> mesa.Model:
        model = mesa.Model(rng=0)
        mesa.Agent.create_agents(model, agents)
        return model

    before = _resident_when_clean()
    seconds, model = _timed(build)
    size = (resident_bytes() - before) / agents
    del model
    return {"build_seconds": [seconds, *_again(build)], "bytes": size}


def scene(agents: int, steps: int) -> dict[str, Any]:
    """Time by phase and memory of the rotating hill."""
    from apmethod import load_scene

    hill = load_scene("rotating_hill")
    hill(particles=_WARM, rng=0).step()

    def build():
        return hill(particles=agents, rng=0)

    before = _resident_when_clean()
    seconds, model = _timed(build)
    built = resident_bytes()
    model.step()
    rows = [_phases_of_a_step(model) for _ in range(steps)]
    memory = {"built": built, "stepped": resident_bytes(), "at_most": most_bytes()}
    del model  # the memory has been taken before others are built where this one was
    return {
        "build_seconds": [seconds, *_again(build)],
        "bytes": {name: (value - before) / agents for name, value in memory.items()},
        "steps": rows,
    }


def _phases_of_a_step(model) -> dict[str, float]:
    """Seconds of one step: in all, by phase, and the rest."""
    from apmethod.bench.timing import stopwatch

    began = dict(model.procedure.seconds)
    step = stopwatch(model.step)
    phases = {name: now - began[name] for name, now in model.procedure.seconds.items()}
    return {"step": step, **phases, "rest": step - sum(phases.values())}


def first_steps(agents: int) -> dict[str, float]:
    """Seconds from the start of this process: imports, building, a first and a second step."""
    from apmethod import load_scene

    hill = load_scene("rotating_hill")
    times = [_BEGAN, perf_counter()]
    model = hill(particles=agents, rng=0)
    times.append(perf_counter())
    for _ in range(2):
        model.step()
        times.append(perf_counter())
    names = ("imports", "build", "first_step", "second_step")
    return {name: times[k + 1] - times[k] for k, name in enumerate(names)}


def _timed(build: Callable) -> tuple[float, Any]:
    began = perf_counter()
    built = build()
    return perf_counter() - began, built


def _again(build: Callable) -> list[float]:
    """Seconds of further builds, each gone before the next."""
    seconds = []
    for _ in range(_BUILDS - 1):
        gc.collect()
        seconds.append(_timed(build)[0])
    return seconds


def _resident_when_clean() -> int:
    gc.collect()
    return resident_bytes()


def main(arguments: list[str]) -> None:
    """Measure what the arguments ask for."""
    measure = {"mesa": bare_mesa, "scene": scene, "first": first_steps}[arguments[0]]
    print(json.dumps(measure(*map(int, arguments[1:]))))


if __name__ == "__main__":
    main(sys.argv[1:])
