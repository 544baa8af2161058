"""Running a model to its end, however it ends, and keeping what was computed."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from apmethod.checks import finite_number, whole_number
from apmethod.errors import StepFailed

if TYPE_CHECKING:
    from collections.abc import Callable

    from apmethod.model import ParticleModel

#: Steps of a scene that names neither an end nor a number of steps.
_STEPS = 100


@dataclass
class Run:
    """A model's run: its diagnostics by step, and how it ended.

    Attributes:
        model: the model, as the run left it.
        series: one dictionary of diagnostics for the start and for each completed step.
        start: the agents' positions at the start, of shape (n, 2).
        seconds: wall time of all steps.
        ended: "finished", "interrupted" or "failed".
        failure: what went wrong, for people, where the run failed.
    """

    model: ParticleModel
    series: list[dict[str, float]] = field(default_factory=list)
    start: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    seconds: float = 0.0
    ended: str = "finished"
    failure: str = ""

    def summary(self) -> dict[str, Any]:
        """The numbers of the run in one flat dictionary."""
        model, first, last = self.model, self.series[0], self.series[-1]
        numbers: dict[str, Any] = {
            "ended": self.ended,
            "agents": last["agents"],
            "steps": last["step"],
            "time": last["time"],
            "seconds": self.seconds,
        }
        for phase, seconds in model.procedure.seconds.items():
            numbers[f"seconds_{phase}"] = seconds
        numbers["mass_drift"] = abs(last["mass"] / first["mass"] - 1.0) if first["mass"] else 0.0
        drift = self._centroid_drift()
        if drift is not None:
            numbers["centroid_drift"] = drift
        numbers.update(getattr(model, "errors", dict)())
        if self.failure:
            numbers["failure"] = self.failure
        return numbers

    def _centroid_drift(self) -> float | None:
        """How far the centre of mass is from where it should be; None where that is unknown."""
        expected = getattr(self.model, "exact_centroid", None)
        if expected is None:
            return None
        off = [
            np.array([row["centroid_x"], row["centroid_y"]]) - expected(row["time"])
            for row in (self.series[0], self.series[-1])
        ]
        return float(np.hypot(*(off[1] - off[0])))


def run(
    model: ParticleModel,
    *,
    until: float | None = None,
    steps: int | None = None,
    progress: Callable[[float, int], None] | None = None,
) -> Run:
    """Step a model to a time or for a number of steps.

    Ctrl-C and a failing step end the run with what has been completed.

    Args:
        model: the model; by default it runs to its own ``until``, or 100 steps.
        until: physical time to end at.
        steps: number of steps to make.
        progress: called with the share done, 0 to 1, and the steps made.

    Raises:
        ValueError: for both an end and a number of steps, or one that is not ahead.
    """
    if until is not None and steps is not None:
        raise ValueError(f"until is {until} and steps is {steps}; give one of them")
    if steps is not None:
        steps = whole_number("steps", steps, least=1)
    if until is not None:
        until = finite_number("until", until, above=model.elapsed)
    if steps is not None:
        model.until = None
    elif until is not None:
        model.until = until
    elif model.until is None:
        steps = _STEPS
    result = Run(model, [model.diagnostics()], model.particles.position.copy())
    began, first = perf_counter(), model.steps
    try:
        while model.steps - first < steps if steps else model.elapsed < model.until:
            model.step()
            result.series.append(model.diagnostics())
            if progress is not None:
                made = model.steps - first
                progress(made / steps if steps else model.elapsed / model.until, made)
    except KeyboardInterrupt:
        result.ended = "interrupted"
    except StepFailed as failure:
        result.ended = "failed"
        result.failure = "; ".join([str(failure), *getattr(failure, "__notes__", ())])
    result.seconds = perf_counter() - began
    return result
