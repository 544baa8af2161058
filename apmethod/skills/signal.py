"""A signal that agents lay on patches, that spreads, evaporates, and is sensed (paper 3.2)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from apmethod.checks import finite_number
from apmethod.compile import in_blocks, plain
from apmethod.skills.patches import lay_patches
from apmethod.skills.sense import (
    lay_cloud,
    lay_nearest,
    perceived_patches,
    read_bilinear,
    read_nearest,
    read_vicinity,
    slopes,
    steepest_turn,
)
from apmethod.skills.skill import Skill
from apmethod.skills.spread import METHODS, Euler

if TYPE_CHECKING:
    from mesa.discrete_space import PropertyLayer

    from apmethod.model import ParticleModel
    from apmethod.skills.patches import Blocked

_LAYING = {"nearest": lay_nearest, "cloud": lay_cloud}
_SENSING = {"nearest": read_nearest, "bilinear": read_bilinear, "vicinity": read_vicinity}


class SignalField(Skill):
    """A signal s on patches (paper eq 3.4, its last line with the signs mended):

        ds/dt - Ds lap s = alpha u - beta s

    In each step the agents lay down what they produce where they stand, the signal spreads
    and evaporates for the length of the step, and each agent senses its value and its
    gradient: the columns ``signal`` and ``signal_gradient`` (by the field's name), which
    laws and agents read.  Borders are the domain's: nothing flows through a bounded side,
    and periodic sides are one.

    Args:
        patch: side of a patch, a length; it must divide the domain and be at most the
            core radius.
        production: alpha, signal that one unit of ``by`` produces in a unit of time.
        diffusivity: Ds, length^2/time.
        evaporation: beta, 1/time.
        name: of the field and its columns; several fields of one scene need several names.
        by: column that an agent's production is proportional to.
        start: s at the start, a number, an array of the patches' shape, or f(x, y).
        laying: "cloud" (cloud-in-cell), or "nearest" patch as in the paper.
        sensing: "bilinear", "nearest", or "vicinity": by a kernel as wide as the core
            radius, which makes perception matter.
        sight: column with how far each agent senses, up to the core radius, for "vicinity".
        view: column with the cosine of the half angle of an agent's view cone around its
            ``heading`` (-1 sees all round), for "vicinity".  The heading is (1, 0) unless
            `Life` or the agents turn it.
        method: "euler" (the paper's), "exact" in time, or "implicit".
        substeps: whether Euler may take several to a step.
        obstacles: patches that hold no signal and let none through: booleans of the
            patches' shape, f(x, y) of their centres, or the model's `Obstacles` as they
            stand at the start.  A wall thinner than a patch does not hold a signal back.

    Raises:
        ValueError: for a negative rate or an unknown choice; `attach` refuses what does
            not fit the model.

    Attributes:
        patches: the patches, see `Patches`.
    """

    def __init__(
        self,
        patch: float,
        *,
        production: float,
        diffusivity: float,
        evaporation: float,
        name: str = "signal",
        by: str = "mass",
        start: float | np.ndarray | Callable = 0.0,
        laying: str = "cloud",
        sensing: str = "bilinear",
        sight: str | None = None,
        view: str | None = None,
        method: str = "euler",
        substeps: bool = True,
        obstacles: Blocked = None,
    ):
        self.patch = finite_number("patch", patch, above=0.0)
        self.production = finite_number("production", production, least=0.0)
        self.diffusivity = finite_number("diffusivity", diffusivity, least=0.0)
        self.evaporation = finite_number("evaporation", evaporation, least=0.0)
        for argument, chosen, known in (
            ("laying", laying, _LAYING), ("sensing", sensing, _SENSING),
            ("method", method, METHODS),
        ):  # fmt: skip
            if chosen not in known:
                raise ValueError(f"{argument} is {chosen!r}; it must be one of {', '.join(known)}")
        for argument, column in (("sight", sight), ("view", view)):
            if column is not None and sensing != "vicinity":
                raise ValueError(
                    f"{argument} is {column!r} and sensing {sensing!r}; it needs 'vicinity'"
                )
        if not name.isidentifier():
            raise ValueError(f"name is {name!r}; it must be a name as of a variable")
        self.name, self.by, self.sight, self.view = name, by, sight, view
        self.laying, self.sensing, self.method = laying, sensing, method
        self._start, self._substeps, self._obstacles = start, substeps, obstacles

    def __repr__(self) -> str:
        return (
            f"signal {self.name!r} on patches of {self.patch:g} "
            f"(production={self.production:g}, diffusivity={self.diffusivity:g}, "
            f"evaporation={self.evaporation:g}; laid {self.laying}, sensed {self.sensing}, "
            f"{self.method})"
        )

    def attach(self, model: ParticleModel) -> None:
        """Lay the patches over the model's domain and declare the columns."""
        super().attach(model)
        self.patches = lay_patches(model.space.domain, self.patch, self._obstacles)
        if self.patch > model.space.core_radius:
            raise ValueError(
                f"patch is {self.patch:g} and the core radius is {model.space.core_radius:g}; a "
                "patch must not be wider than what its agents perceive"
            )
        self.require(self.by, self.sight, self.view)
        if self.view is not None:
            self.declare_heading()
        self.values = self._started()
        self._spread = METHODS[self.method](self.patches, self.diffusivity, self.evaporation)
        if isinstance(self._spread, Euler):
            self._spread.substeps = self._substeps
            if model.dt is not None:
                self._spread.check(model.dt)
        self.declare(self.name, unit="signal/area")
        self.declare(f"{self.name}_gradient", 2, unit="signal/volume")

    def _started(self) -> np.ndarray:
        start = self._start(*self.patches.centres()) if callable(self._start) else self._start
        start = np.array(start, float)
        if start.shape not in ((), self.patches.shape) or not np.isfinite(start).all():
            raise ValueError(
                f"start has shape {start.shape}; it must be a finite number or one for each "
                f"patch, {self.patches.shape}"
            )
        return np.ascontiguousarray(np.broadcast_to(start, self.patches.shape)) * self.patches.free

    # -- turns -------------------------------------------------------------------------

    def begin(self, dt: float) -> None:
        """Lay down what the agents produce, and let the signal spread and evaporate."""
        self.values = self._spread.advance(self.values, self.produced(), dt)

    def perceived(self) -> None:
        """Let all agents sense the signal where they stand."""
        position = self.column("position")
        into = self.column(self.name), self.column(f"{self.name}_gradient")
        run = _SENSING[self.sensing]
        if self.sensing == "vicinity":
            arguments = self._surroundings()
        else:
            arguments = (self.values, self.slope(), self.patches.grid, self.patches.home)
        if self.model.procedure.tier == "agents":
            plain(run)(0, len(position), position, *arguments, *into)
        else:
            in_blocks(run, len(position), position, *arguments, *into, least=5000)

    def _surroundings(self) -> tuple:
        """What `read_vicinity` takes: patches with a margin, and the agents' eyes."""
        radius = self._radius()
        margin = ceil(perceived_patches(radius.max(initial=0.0), self.patch)) + 1
        signal, free = self.values, self.patches.free
        for axis, wraps in enumerate(self.patches.periodic):
            wide = [(0, 0), (0, 0)]
            wide[axis] = (margin, margin)
            mode = "wrap" if wraps else "constant"
            signal, free = np.pad(signal, wide, mode), np.pad(free, wide, mode)
        eyes = (np.empty((0, 2)), np.empty(0))
        if self.view is not None:
            eyes = self.column("heading"), self.column(self.view)
        return signal, free, margin, self.patches.grid, radius, *eyes

    def _radius(self) -> np.ndarray:
        """How far each agent perceives."""
        radius = self.model.space.core_radius
        if self.sight is not None:
            return np.minimum(self.column(self.sight), radius)
        return np.full(len(self.model.particles), radius)

    def state(self) -> np.ndarray:
        """The values; `begin` makes new ones and leaves these."""
        return self.values

    def restore(self, state: np.ndarray) -> None:
        """Go back to earlier values."""
        self.values = state

    # -- in numbers --------------------------------------------------------------------

    @property
    def values(self) -> np.ndarray:
        """s, signal per area, of shape (wide, high), indexed [east, north]."""
        return self._values

    @values.setter
    def values(self, values: np.ndarray) -> None:
        self._values = values
        if "layer" in self.__dict__:
            self.layer.set_cells(values)

    @cached_property
    def layer(self) -> PropertyLayer:
        """The signal as a property layer of Mesa, which shows it from the first use on.

        A grid of ``patches.shape`` takes it, and Mesa's drawings and ``select_cells`` work.
        What is written to the layer, the signal does not learn.
        """
        from mesa.discrete_space import PropertyLayer

        return PropertyLayer.from_data(self.name, self.values)

    def produced(self) -> np.ndarray:
        """What all agents produce now, signal per area and time, of the patches' shape."""
        flat = np.zeros(self.values.size)
        run = _LAYING[self.laying]
        run = plain(run) if self.model.procedure.tier == "agents" else run
        run(self.column("position"), self.column(self.by), self.patches.grid, self.patches.home,
            flat)  # fmt: skip
        return flat.reshape(self.values.shape) * (self.production / self.patches.area)

    def slope(self) -> np.ndarray:
        """The signal's gradient at the patches' centres, of shape (wide, high, 2)."""
        slope = np.empty((*self.values.shape, 2))
        in_blocks(
            slopes, len(self.values), self.values, self.patches.east, self.patches.north,
            self.patch, slope, least=200,
        )  # fmt: skip
        return slope

    def steepest_turn(self) -> float:
        """Bound of how fast the gradient changes with the place, signal/length^4."""
        return steepest_turn(self.values, self.patches.east, self.patches.north, self.patch)

    @property
    def total(self) -> float:
        """Amount of signal on all patches."""
        return float(self.values.sum() * self.patches.area)

    def diagnostics(self) -> dict[str, float]:
        """The total and the largest value."""
        return {f"{self.name}_total": self.total, f"{self.name}_most": float(self.values.max())}
