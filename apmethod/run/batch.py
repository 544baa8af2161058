"""Many runs of one scene: parameter values times seeds, in one process or several.

`mesa.batch_run` does the work, and also takes a scene that has a data collector directly.
`batch_run` asks for no data collector, gives every version of Mesa's rows in one order and
with the same keys, and keeps a failing run from costing the others.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import mesa

from apmethod.compile.threads import set_threads, threads
from apmethod.run.runner import run

if TYPE_CHECKING:
    from apmethod.model import ParticleModel


def batch_run(
    model_class: type[ParticleModel],
    parameters: Mapping[str, Any | Sequence[Any]],
    seeds: int | Sequence[int] = 0,
    *,
    steps: int | None = None,
    until: float | None = None,
    processes: int = 1,
    progress: bool = False,
) -> list[dict[str, Any]]:
    """Run a scene with every combination of parameter values and seeds.

    Several processes need a call under ``if __name__ == "__main__":``, for each of them
    imports the calling file, and a model class that can be imported.

    Args:
        model_class: the scene; its constructor takes the parameters and ``rng``.
        parameters: for each constructor argument a value or a list of values.
        seeds: one seed or several, each tried with every combination.
        steps: number of steps of each run.
        until: physical time that each run ends at; without either, the scene's own end.
        processes: how many runs go on at a time; they share the threads.
        progress: whether to show a progress bar.

    Returns:
        One dictionary a run, seed after seed: the parameters, the seed as ``rng``, how it
        ``ended`` and its ``failure`` ("" if it has not failed), and the model's diagnostics
        and errors at the end.

    Raises:
        ValueError: for fewer than one process, an ``rng`` among the parameters, or what the
            scene or `apmethod.run.runner.run` refuses.
    """
    if processes < 1:
        raise ValueError(f"processes is {processes!r}; it must be 1 or more")
    if "rng" in parameters:
        raise ValueError(f"parameters has rng={parameters['rng']!r}; give it as seeds")
    share = max(1, threads() // processes)
    rows = mesa.batch_run(
        partial(_WholeRun, model_class, {"steps": steps, "until": until}, share),
        **_seeded(parameters, seeds),
        number_processes=processes,
        max_steps=1,
        display_progress=progress,
    )
    return [row["outcome"] for row in sorted(rows, key=lambda row: row["RunId"])]


def _seeded(parameters: Mapping[str, Any], seeds: int | Sequence[int]) -> dict[str, Any]:
    """Parameters and seeds as this version of Mesa takes them, seeds in the outer loop."""
    if "rng" in inspect.signature(mesa.batch_run).parameters:
        return {"parameters": parameters, "rng": seeds}
    return {"parameters": {"rng": seeds, **parameters}}


class _WholeRun(mesa.Model):
    """A model whose single step is the whole run of another one.

    How many steps a batch makes and which records it keeps differs between versions of
    Mesa; of one step with one record, all of them make the same.
    """

    def __init__(
        self,
        model_class: type[ParticleModel],
        length: dict[str, float | None],
        thread_count: int,
        rng: int | None = None,
        **settings: Any,
    ):
        super().__init__(rng=rng)
        if threads() != thread_count:
            set_threads(thread_count)
        self.settings = {**settings, "rng": rng}
        self.length = length
        self.subject = model_class(**self.settings)
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
