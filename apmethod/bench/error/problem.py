"""What a problem of diffusion and flow whose exact solution is known has to say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from apmethod.field.model import FieldModel
from apmethod.perceive.domain import Domain


class FreeFem(NamedTuple):
    """A flow in FreeFem++'s language.

    Attributes:
        velocity: V.
        foot: where the flow has been a time s before it is at (x, y).
        round: whether a disc is enough of the box.
    """

    velocity: tuple[str, str]
    foot: tuple[str, str]
    round: bool = False


class Problem:
    """du/dt + div(V u) - D lap u = growth u, from u(x, y, 0) on.

    Args:
        name: what the command line calls it.
        box: (x_min, x_max, y_min, y_max) that the field stays in.
        diffusivity: D.
        until: when errors are taken.
        flow: V(x, y, t) giving (x, y), or None.
        growth: rate of growth.
        walls: no-flux walls, or None.
        freefem: the flow in FreeFem++'s language; None where it is not compared with.
    """

    def __init__(
        self,
        name: str,
        box: Sequence[float],
        *,
        diffusivity: float,
        until: float,
        flow: Callable | None = None,
        growth: float = 0.0,
        walls: Domain | None = None,
        freefem: FreeFem | None = None,
    ):
        self.name = name
        self.box = tuple(box)
        self.diffusivity = diffusivity
        self.until = until
        self.flow = flow
        self.growth = growth
        self.walls = walls
        self.freefem = freefem

    def exact(self, x: np.ndarray, y: np.ndarray, time: float) -> np.ndarray:
        """The solution."""
        raise NotImplementedError

    def freefem_start(self) -> str:
        """u(x, y, 0) in FreeFem++'s language."""
        raise NotImplementedError

    def model(self, particles: int, **options: Any) -> FieldModel:
        """Agents for the problem; ``options`` are those of `FieldModel`."""
        return ProblemModel(self, particles, **options)


class ProblemModel(FieldModel):
    """A problem as a scene."""

    def __init__(self, problem: Problem, particles: int, **options: Any):
        self.problem = problem
        self.until = problem.until
        super().__init__(
            lambda x, y: problem.exact(x, y, 0.0),
            problem.box,
            particles=particles,
            diffusivity=problem.diffusivity,
            flow=problem.flow,
            growth=problem.growth,
            domain=problem.walls,
            **options,
        )

    def exact(self, x, y, time):
        """The problem's solution."""
        return self.problem.exact(x, y, time)
