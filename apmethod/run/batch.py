"""Many runs of one scene: parameter values times seeds, in one process or several.

`mesa.batch_run` does the work, and takes a scene that has a data collector directly, too.
`batch_run` needs no data collector, returns the same rows in the same order with every
version of Mesa, and does not lose the other runs when one fails.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mesa

from apmethod.checks import whole_number
from apmethod.compile.threads import set_threads, threads
from apmethod.run.runner import run
from apmethod.run.scenes import build, load_scene

if TYPE_CHECKING:
    from apmethod.model import ParticleModel

    Scene = type[ParticleModel] | str | Path


def batch_run(
    scene: Scene,
    parameters: Mapping[str, Any | Sequence[Any]],
    seeds: int | Sequence[int] = 0,
    *,
    steps: int | None = None,
    until: float | None = None,
    processes: int = 1,
    progress: bool = False,
) -> list[dict[str, Any]]:
    """Run a scene with every combination of parameter values and seeds.

    Other processes import the file that calls this one: where ``processes`` is above 1, call
    it under ``if __name__ == "__main__":``.

    Args:
        scene: a model class, the path of a scene's folder, or a shipped scene's name.
        parameters: for each setting of the scene a value, or a list of values.
        seeds: one seed or a list, each for every combination.
        steps: number of steps of each run.
        until: physical time at which each run ends; by default the scene's own end.
        processes: how many runs go on at a time; they share the threads.
        progress: whether to show a progress bar.

    Returns:
        One dictionary a run, seed after seed: the parameters, the seed as ``rng``, how it
        ``ended``, its ``failure`` ("" where there was none), and the model's diagnostics and
        errors at the end.

    Raises:
        ValueError: for less than one process, an ``rng`` among the parameters, a class or
            program that other processes cannot import, or what the scene or the run refuses.
    """
    processes = whole_number("processes", processes, least=1)
    if "rng" in parameters:
        raise ValueError(f"parameters has rng={parameters['rng']!r}; give it as seeds")
    if processes > 1:
        _check_importable(scene)
    share = max(1, threads() // processes)
    rows = mesa.batch_run(
        partial(_WholeRun, scene, {"steps": steps, "until": until}, share),
        **_seeded(parameters, seeds),
        number_processes=processes,
        max_steps=1,
        display_progress=progress,
    )
    return [row["outcome"] for row in sorted(rows, key=lambda row: row["RunId"])]


def _check_importable(scene: Scene) -> None:
    """Refuse what other processes would try in vain to import while this one waits."""
    program = sys.modules["__main__"]
    file = getattr(program, "__file__", None)
    home = sys.modules[scene.__module__.partition(".")[0]] if isinstance(scene, type) else None
    if program.__spec__ is None and file is not None and not Path(file).exists():
        missing = f"the program {file}"
    elif home is not None and home.__spec__ is None and not hasattr(home, "__file__"):
        missing = scene.__name__
    else:
        return
    raise ValueError(
        f"processes is above 1, and other processes cannot import {missing}; put it into a file, "
        "give a scene by the path of its folder, or use one process"
    )


def _seeded(parameters: Mapping[str, Any], seeds: int | Sequence[int]) -> dict[str, Any]:
    """Parameters and seeds as this version of Mesa takes them, seeds in the outer loop."""
    if "rng" in inspect.signature(mesa.batch_run).parameters:
        return {"parameters": parameters, "rng": seeds}
    return {"parameters": {"rng": seeds, **parameters}}


class _WholeRun(mesa.Model):
    """A model whose single step is the whole run of another one.

    Versions of Mesa differ in how many steps a batch makes and which records it keeps; of
    one step with one record, all of them make the same.
    """

    def __init__(
        self,
        scene: Scene,
        length: dict[str, float | None],
        thread_count: int,
        rng: int | None = None,
        **settings: Any,
    ):
        super().__init__(rng=rng)
        if threads() != thread_count:
            set_threads(thread_count)
        self.length = length
        self.settings = {**settings, "rng": rng}
        model_class = scene if isinstance(scene, type) else load_scene(scene)
        self.subject = build(model_class, self.settings)
        self.datacollector = mesa.DataCollector({"outcome": _WholeRun.outcome})

    def step(self) -> None:
        """Run the other model to its end."""
        self.result = run(self.subject, **self.length)
        if self.result.ended == "interrupted":
            raise KeyboardInterrupt  # Ctrl-C is meant for the batch, not for one run of it
        self.running = False
        self.datacollector.collect(self)

    def outcome(self) -> dict[str, Any]:
        """The row of the run."""
        ended = {"ended": self.result.ended, "failure": self.result.failure}
        errors = getattr(self.subject, "errors", dict)()
        return {**self.settings, **ended, **self.subject.diagnostics(), **errors}
