"""The agents a field begins with: a lattice of masses, and jumps smoothed out beforehand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from apmethod.contribute.sample import Field, sample, spacing_along
from apmethod.perceive.domain import OPEN, PERIODIC, Domain

if TYPE_CHECKING:
    from apmethod.move.obstacles.collection import Obstacles

#: Points along each side of the grid that jumps are looked for on.
_LOOK = 201
#: A difference that halving the distance leaves above this share of the largest u is a jump.
_JUMP = 0.02
#: Cells of the grid that a field is smoothed on, for each of the Gaussian's deviations, along
#: a side at the most, and points along the side of a cell that a jump goes through.
_FINE, _MOST, _POINTS = 20, 4000, 16


class Start(NamedTuple):
    """Where a field's agents begin.

    Attributes:
        positions: of shape (agents, 2).
        masses: of shape (agents,).
        spacing: of their lattice.
        time: how long the field has diffused to be as smooth as it is.
    """

    positions: np.ndarray
    masses: np.ndarray
    spacing: float
    time: float


def lay(
    field: Field,
    count: int,
    box: Sequence[float],
    *,
    least: float,
    offset: Sequence[float],
    domain: Domain,
    smooth: float = 0.0,
    diffusivity: float = 0.0,
    settled: float = 0.0,
    latest: float = np.inf,
    obstacles: Obstacles | None = None,
) -> Start:
    """Lay a field on a lattice of agents.

    A field with a jump has no gradient there to diffuse by.  It is convolved with a
    Gaussian of standard deviation s = ``smooth`` spacings, which is what diffusion alone
    makes of it in the time t = s^2 / (2 D): the clock begins there, and agents are laid as
    far out as the Gaussian reaches.  A smooth field is taken as it is.

    Agents laid in a narrow edge are drawn apart as it widens, so the more of them there are
    the wider the edge must be, in spacings: the clock begins at ``settled`` if that is later.

    Args:
        field: u(x, y) at time 0, on arrays.
        count: number of agents.
        box: (x_min, x_max, y_min, y_max).
        least: share of the largest u below which a place is left without an agent.
        offset: shift of the lattice, in spacings.
        domain: where agents may be; the field is mirrored at its walls.
        smooth: standard deviation in spacings, 0 for none.
        diffusivity: D.
        settled: time until which the flow may be left out while jumps diffuse away.
        latest: the latest time that the clock may begin at; it limits s.
        obstacles: where no agent can be.
    """
    x_min, x_max, y_min, y_max = box
    options = {"least": least, "offset": offset, "domain": domain}
    corners = (x_min, y_min), (x_max, y_max)
    if obstacles is not None:
        return _beside(obstacles, field, count, corners, options)
    found = Start(*sample(field, count, *corners, **options), 0.0)
    if smooth == 0.0 or diffusivity == 0.0 or not has_jump(field, box):
        return found
    for _ in range(3):  # the smoothed field reaches further, so its lattice is wider
        deviation = max(smooth * found.spacing, np.sqrt(2.0 * diffusivity * settled))
        deviation = min(deviation, np.sqrt(2.0 * diffusivity * latest))
        smoothed = convolved(field, box, deviation, domain)
        time = deviation**2 / (2.0 * diffusivity)
        found = Start(*sample(smoothed, count, *corners, **options), time)
    return found


def _beside(obstacles: Obstacles, field: Field, count: int, corners, options) -> Start:
    """Agents outside of obstacles; those beside walls may make them some more than asked for."""
    from apmethod.field.beside import fit_to_walls  # loaded where there are obstacles

    def outside(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        occupied = obstacles.occupied(np.column_stack([np.ravel(x), np.ravel(y)]))
        return np.where(occupied.reshape(np.shape(x)), 0.0, field(x, y))

    positions, masses, spacing = sample(outside, count, *corners, **options)
    spacings = tuple(spacing_along(positions[:, axis], spacing) for axis in range(2))
    least = options["least"] * float(outside(*positions.T).max())
    positions, masses = fit_to_walls(
        obstacles, field, positions, masses, spacings, least, options["domain"]
    )
    return Start(positions, masses, spacing, 0.0)


def has_jump(field: Field, box: Sequence[float]) -> bool:
    """Whether a field jumps somewhere: its steepest places are halved until they are points."""
    x_min, x_max, y_min, y_max = box
    x, y = np.meshgrid(np.linspace(x_min, x_max, _LOOK), np.linspace(y_min, y_max, _LOOK))
    values = np.asarray(field(x, y), float)
    points = np.stack([x, y], axis=-1)
    for axis in range(2):
        steepness = np.abs(np.diff(values, axis=axis))
        place = np.unravel_index(np.argmax(steepness), steepness.shape)
        after = tuple(index + (k == axis) for k, index in enumerate(place))
        ends = points[place], points[after]
        for _ in range(30):
            middle = 0.5 * (ends[0] + ends[1])
            three = np.array([ends[0], middle, ends[1]])
            u = np.asarray(field(*three.T), float)
            ends = three[:2] if abs(u[1] - u[0]) > abs(u[2] - u[1]) else three[1:]
        u = np.asarray(field(*np.array(ends).T), float)
        if abs(u[1] - u[0]) > _JUMP * np.abs(values).max():
            return True
    return False


def convolved(field: Field, box: Sequence[float], deviation: float, domain: Domain) -> Callable:
    """The field convolved with a Gaussian, mirrored at walls and wrapped at periodic sides."""
    from scipy.ndimage import gaussian_filter1d, map_coordinates

    axes, cells, modes = [], [], []
    for axis, kind in enumerate(domain.kinds):
        low, high = box[2 * axis : 2 * axis + 2]
        if kind != OPEN:
            low, high = domain.lower[axis], domain.upper[axis]
        count = int(min(np.ceil(_FINE * (high - low) / deviation), _MOST))
        cells.append((high - low) / count)
        axes.append(low + (np.arange(count) + 0.5) * cells[axis])
        modes.append({OPEN: "constant", PERIODIC: "wrap"}.get(kind, "reflect"))
    values = _cell_means(field, axes, cells)
    for axis in range(2):
        values = gaussian_filter1d(
            values, deviation / cells[axis], axis=1 - axis, mode=modes[axis], truncate=7.0
        )
    mode = "grid-wrap" if "wrap" in modes else "reflect"

    def smoothed(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        places = [(y - axes[1][0]) / cells[1], (x - axes[0][0]) / cells[0]]
        return np.maximum(map_coordinates(values, places, order=3, mode=mode), 0.0)

    return smoothed


def _cell_means(field: Field, axes: Sequence[np.ndarray], cells: Sequence[float]) -> np.ndarray:
    """The field's mean in each cell of a grid: at its centre, or at many points by a jump."""
    x, y = np.meshgrid(*axes)
    values = np.asarray(field(x, y), float)
    jump = np.zeros(values.shape, bool)
    for axis in range(2):
        steep = np.abs(np.diff(values, axis=axis)) > _JUMP * np.abs(values).max()
        along, across = np.moveaxis(jump, axis, 0), np.moveaxis(steep, axis, 0)
        along[1:] |= across
        along[:-1] |= across
    inside = (np.arange(_POINTS) + 0.5) / _POINTS - 0.5
    u, v = (part.ravel() for part in np.meshgrid(inside * cells[0], inside * cells[1]))
    values[jump] = np.asarray(field(x[jump][:, None] + u, y[jump][:, None] + v)).mean(axis=1)
    return values
