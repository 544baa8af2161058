"""Reading a field out of agents: u(x) = sum_j m_j W(x - x_j, h) (paper eq 2.2)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from apmethod.checks import finite_number
from apmethod.compile import compiled, in_blocks, inlined
from apmethod.contribute.smoothing import GAUSSIAN_6, Kernel
from apmethod.perceive.cells import sort_into_cells
from apmethod.perceive.domain import Domain, Open, distance_2

if TYPE_CHECKING:
    from apmethod.move.obstacles.collection import Obstacles


def reconstruct(
    points: np.ndarray,
    positions: np.ndarray,
    masses: np.ndarray,
    smoothing_length: float,
    kernel: Kernel = GAUSSIAN_6,
    domain: Domain | None = None,
    obstacles: Obstacles | None = None,
) -> np.ndarray:
    """The field that agents carry, at any points.

    The default kernel is of sixth order: with a smoothing length of about two spacings its
    own error is small beside that of the agents' motion.  It can dip slightly below zero
    beside a steep edge; `GAUSSIAN` cannot, and smooths more.

    Args:
        points: where to evaluate, of shape (n, 2).
        positions: of the agents, of shape (agents, 2).
        masses: of the agents, of shape (agents,).
        smoothing_length: h of the kernel, about twice the agents' spacing.
        kernel: smoothing kernel.
        domain: periodic sides are seen across, and mirrored ones mirror the field.
        obstacles: walls that the field is not seen through, and that mirror it, those that
            absorb with opposite sign, so that it is 0 at them; in obstacles it is 0.

    Returns:
        u, mass per area, of shape (n,).

    Raises:
        ValueError: for a wrong shape or a smoothing length that is not above 0.
    """
    points = np.ascontiguousarray(points, float)
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"points has shape {points.shape}; it must be (n, 2)")
    smoothing_length = finite_number("smoothing_length", smoothing_length, above=0.0)
    values = np.zeros(len(points))
    if len(positions) == 0:
        return values
    domain = domain or Open()
    cells = sort_into_cells(
        np.asarray(positions, float), kernel.support * smoothing_length, 1, domain
    )
    low, high = cells.around(points)
    masses = np.asarray(masses, float)[cells.row]
    in_blocks(
        _compile_sum(kernel), len(points), points, low, high, *cells.places(), masses,
        smoothing_length, values, least=1000,
    )  # fmt: skip
    if obstacles is not None and obstacles.contributions != "through":
        from apmethod.move.obstacles.sight import sights_from  # loaded where there are some

        sights = sights_from(obstacles, points, cells, domain)
        if sights is not None:
            in_blocks(
                _compile_sum_in_sight(kernel), len(sights.place), sights.place, sights.begin,
                sights.end, sights.other, sights.dx, sights.dy, sights.sign, masses,
                smoothing_length, values, least=1000,
            )  # fmt: skip
        values[obstacles.occupied(points)] = 0.0
    return values


@cache
def _compile_sum(kernel: Kernel) -> Callable:
    shape = inlined(kernel.shape)
    support_2 = kernel.support**2

    @compiled
    def sum_at_points(first, last, points, low, high, x, y, mass, smoothing_length, values):
        h_2 = smoothing_length * smoothing_length
        for k in range(first, last):
            total = 0.0
            for run in range(low.shape[1]):
                for j in range(low[k, run], high[k, run]):
                    dx, dy = points[k, 0] - x[j], points[k, 1] - y[j]
                    q_2 = (dx * dx + dy * dy) / h_2
                    if q_2 < support_2:
                        total += mass[j] * shape(q_2)
            values[k] = total / h_2

    return sum_at_points


@cache
def _compile_sum_in_sight(kernel: Kernel) -> Callable:
    shape = inlined(kernel.shape)

    @compiled
    def sum_in_sight(
        first, last, place, begin, end, other, dx, dy, sign, mass, smoothing_length, values
    ):
        h_2 = smoothing_length * smoothing_length
        for k in range(first, last):
            total = 0.0
            for n in range(begin[k], end[k]):
                part = mass[other[n]] * shape(distance_2(dx[n], dy[n]) / h_2)
                total += -part if sign[n] < 0 else part
            values[place[k]] = total / h_2

    return sum_in_sight
