"""Where agents may be: open, bounded, mirrored or periodic, along each axis."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from apmethod.compile import compiled, inlined

OPEN, BOUNDED, PERIODIC, MIRRORED = 0, 1, 2, 3
_BORDERS = {"open": OPEN, "bounded": BOUNDED, "periodic": PERIODIC, "mirrored": MIRRORED}


class Domain:
    """A rectangle whose pairs of sides are each open, bounded, mirrored or periodic.

    Open: agents go where they like, and the lattice follows them.  Bounded: a
    displacement that crosses the side is reflected at it.  Mirrored: bounded, and agents
    near a side also get what their mirror images beyond it contribute, so that sums are
    complete there and a diffusing field has no flux through the side; an image has its
    agent's columns as they are (a vector is not reflected).  Periodic: an agent that leaves
    by one side enters by the other, and agents perceive each other across.

    Args:
        lower: smallest x and y, of length 2.
        upper: largest x and y.
        borders: "open", "bounded", "mirrored" or "periodic" for x and for y, or one for both.

    Raises:
        ValueError: for an unknown border, or limits that are not finite and in order.
    """

    def __init__(
        self,
        lower: Sequence[float] = (-np.inf, -np.inf),
        upper: Sequence[float] = (np.inf, np.inf),
        borders: str | tuple[str, str] = "open",
    ):
        names = (borders, borders) if isinstance(borders, str) else tuple(borders)
        unknown = [name for name in names if name not in _BORDERS]
        if unknown or len(names) != 2:
            raise ValueError(f"borders is {borders!r}; each must be one of {', '.join(_BORDERS)}")
        self.lower = np.array(lower, float)
        self.upper = np.array(upper, float)
        if self.lower.shape != (2,) or self.upper.shape != (2,):
            raise ValueError(f"lower is {lower!r} and upper {upper!r}; each must be two numbers")
        self.kinds = tuple(_BORDERS[name] for name in names)
        for axis in range(2):
            low, high = self.lower[axis], self.upper[axis]
            closed = self.kinds[axis] != OPEN
            if closed and not (np.isfinite([low, high]).all() and low < high):
                raise ValueError(
                    f"the {names[axis]} domain runs from {low} to {high} along {'xy'[axis]}; "
                    "it must be from a finite number to a larger one"
                )
            if not closed:
                self.lower[axis], self.upper[axis] = -np.inf, np.inf
        self.borders = names
        #: Length of each periodic axis, 0 for the others.
        self.periods = tuple(
            float(high - low) if kind == PERIODIC else 0.0
            for low, high, kind in zip(self.lower, self.upper, self.kinds, strict=True)
        )

    def __repr__(self) -> str:
        if self.is_open:
            return "open domain"
        borders = " x ".join(dict.fromkeys(self.borders))
        return f"{borders} domain from {self.lower.tolist()} to {self.upper.tolist()}"

    @property
    def is_open(self) -> bool:
        """Whether no side stops or wraps an agent."""
        return self.kinds == (OPEN, OPEN)

    @property
    def makes_images(self) -> bool:
        """Whether agents are seen a second time beyond a side, periodic or mirrored."""
        return self.mirrors or any(self.periods)

    @property
    def mirrors(self) -> bool:
        """Whether agents have mirror images beyond a side."""
        return MIRRORED in self.kinds

    @cached_property
    def limits(self) -> tuple[tuple[float, float, int], tuple[float, float, int]]:
        """(lower, upper, kind) along x and y, as compiled passes take them."""
        return tuple(
            (float(self.lower[axis]), float(self.upper[axis]), self.kinds[axis])
            for axis in range(2)
        )

    def check_radius(self, core_radius: float) -> None:
        """Refuse a core radius with which an agent would perceive another one twice."""
        for axis, kind in enumerate(self.kinds):
            length = self.upper[axis] - self.lower[axis]
            if kind == MIRRORED and length < core_radius:
                raise ValueError(
                    f"the domain is {length:g} long along {'xy'[axis]} and the core radius is "
                    f"{core_radius:g}; a mirrored domain must be at least one core radius long"
                )
        for axis, period in enumerate(self.periods):
            if 0.0 < period < 2.0 * core_radius:
                raise ValueError(
                    f"the domain is {period:g} long along {'xy'[axis]} and the core radius is "
                    f"{core_radius:g}; a periodic domain must be at least two core radii long "
                    f"({2 * core_radius:g})"
                )

    def check_positions(self, positions: np.ndarray) -> None:
        """Refuse positions, of shape (n, 2), outside a bounded or periodic side."""
        outside = ((positions < self.lower) | (positions > self.upper)).any(axis=1)
        if outside.any():
            first = int(np.flatnonzero(outside)[0])
            raise ValueError(
                f"position is {positions[first].tolist()} (agent {first} of {len(positions)} "
                f"given); it must be inside the {self!r}"
            )

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Where a displacement to (x, y) ends: reflected or wrapped into the domain."""
        along_x, along_y = self.limits
        return place_along(x, *along_x), place_along(y, *along_y)

    def displacement(self, here: Sequence[float], there: Sequence[float]) -> tuple[float, float]:
        """here - there, the shortest way where the domain is periodic."""
        period_x, period_y = self.periods
        return (
            shortest(here[0] - there[0], period_x),
            shortest(here[1] - there[1], period_y),
        )


def Open() -> Domain:
    """The whole plane."""
    return Domain()


def Bounded(lower: Sequence[float], upper: Sequence[float]) -> Domain:
    """A rectangle with sides that reflect."""
    return Domain(lower, upper, "bounded")


def Mirrored(lower: Sequence[float], upper: Sequence[float]) -> Domain:
    """A rectangle with sides that reflect, without flux (numerical mirror particles)."""
    return Domain(lower, upper, "mirrored")


def Periodic(lower: Sequence[float], upper: Sequence[float]) -> Domain:
    """A rectangle whose opposite sides are one."""
    return Domain(lower, upper, "periodic")


@inlined
def place_along(x, lower, upper, kind):
    """One coordinate, reflected or (periodic) wrapped into [lower, upper]."""
    if kind == 0 or (lower <= x and x <= upper):
        return x
    length = upper - lower
    if kind == 2:
        inside = (x - lower) % length
        return lower + inside if inside < length else lower
    inside = (x - lower) % (2.0 * length)
    return lower + min(inside, 2.0 * length - inside)


@compiled
def place(first, last, rows, position, along_x, along_y):
    """`place_along` for both coordinates of the given rows."""
    for k in range(first, last):
        row = rows[k]
        x, y = position[row, 0], position[row, 1]
        position[row, 0] = place_along(x, along_x[0], along_x[1], along_x[2])
        position[row, 1] = place_along(y, along_y[0], along_y[1], along_y[2])


@compiled
def bounce(first, last, rows, position, velocity, along_x, along_y):
    """Turn velocities round that lead out through a side that reflects, before `place`."""
    for k in range(first, last):
        row = rows[k]
        for axis in range(2):
            lower, upper, kind = along_x if axis == 0 else along_y
            if kind in (BOUNDED, MIRRORED):
                crossings = np.floor((position[row, axis] - lower) / (upper - lower))
                if crossings % 2.0 == 1.0:
                    velocity[row, axis] = -velocity[row, axis]


@inlined(exact=True)
def distance_2(dx, dy):
    """dx^2 + dy^2, rounded alike in both tiers: it decides who is a neighbour of whom."""
    return dx * dx + dy * dy


@inlined
def shortest(difference, period):
    """A difference of two coordinates, the shorter way round a periodic axis."""
    if period > 0.0:
        if difference > 0.5 * period:
            return difference - period
        if difference < -0.5 * period:
            return difference + period
    return difference
