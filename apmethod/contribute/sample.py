"""Laying a field on agents: the reverse of `apmethod.contribute.reconstruct`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from apmethod.checks import whole_number
from apmethod.perceive.domain import BOUNDED, MIRRORED, OPEN, Domain, Open

Field = Callable[[np.ndarray, np.ndarray], np.ndarray]


def sample(
    field: Field,
    count: int,
    lower: Sequence[float],
    upper: Sequence[float],
    *,
    least: float = 1e-5,
    offset: Sequence[float] = (0.0, 0.0),
    domain: Domain | None = None,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Agents on a square lattice, each with the mass of the field in its square.

    m_i = u(x_i) dx^2, for the ``count`` lattice points with the largest u.  Masses on a
    lattice represent a smooth field far better than equal masses at random places.

    Between the sides of a bounded or periodic domain the lattice is stretched a little, so
    that it goes on behind them: half a spacing from a wall, as in its mirror.  The number
    of agents is then the nearest that such a lattice has.

    Args:
        field: u(x, y) on arrays, mass per area, 0 or more.
        count: number of agents.
        lower, upper: corners of the rectangle in which the field is looked for.
        least: share of the largest u below which a place is left without an agent.
        offset: shift of the lattice, in spacings, where no wall determines it.
        domain: open if not given; the rectangle is cut to it.

    Returns:
        positions of shape (agents, 2), masses of shape (agents,), and the spacing dx.

    Raises:
        ValueError: for a count below 1, a field that is negative, not finite or zero.
    """
    count = whole_number("count", count, least=1)
    domain = domain or Open()
    lower = np.maximum(np.asarray(lower, float), domain.lower)
    upper = np.minimum(np.asarray(upper, float), domain.upper)
    area = _area_above(field, lower, upper, least)
    spacing = np.sqrt(area / count)

    def lattice(spacing: float) -> tuple[np.ndarray, np.ndarray, float]:
        axes = [
            lattice_axis(lower[k], upper[k], spacing, offset[k], domain.kinds[k])
            for k in range(2)
        ]  # fmt: skip
        x, y = (part.ravel() for part in np.meshgrid(axes[0][0], axes[1][0]))
        values = np.asarray(field(x, y), float)
        inside = values > least * values.max(initial=0.0)
        cell = axes[0][1] * axes[1][1]
        return np.column_stack([x, y])[inside], values[inside], cell

    if not domain.is_open:
        tried = [lattice(spacing * share) for share in np.linspace(0.97, 1.03, 25)]
        positions, values, cell = min(tried, key=lambda found: abs(len(found[1]) - count))
        return positions, values * cell, float(np.sqrt(cell))
    for _ in range(60):
        positions, values, cell = lattice(spacing)
        if len(values) >= count:
            break
        spacing *= 0.998 * np.sqrt(len(values) / count) if len(values) < 0.9 * count else 0.998
    kept = np.sort(np.argsort(-values, kind="stable")[:count])
    return positions[kept], values[kept] * cell, float(spacing)


def lattice_axis(
    lower: float, upper: float, spacing: float, offset: float, kind: int
) -> tuple[np.ndarray, float]:
    """Coordinates of a lattice along one axis of a domain, and their spacing.

    Along a closed axis the spacing is the nearest that fits.
    """
    if kind == OPEN:
        return np.arange(lower + (offset % 1.0) * spacing, upper, spacing), spacing
    count = max(1, round((upper - lower) / spacing))
    spacing = (upper - lower) / count
    shift = 0.5 if kind in (BOUNDED, MIRRORED) else offset % 1.0
    return lower + (np.arange(count) + shift) * spacing, spacing


def spacing_along(coordinates: np.ndarray, spacing: float) -> float:
    """The smallest difference of coordinates on a lattice: between walls it is stretched."""
    lines = np.unique(np.round(coordinates / spacing, 6))
    return float(np.diff(lines).min() * spacing) if len(lines) > 1 else spacing


def _area_above(field: Field, lower: np.ndarray, upper: np.ndarray, least: float) -> float:
    """Area in which the field is above its ``least`` share."""
    axes = [np.linspace(lower[k], upper[k], 401) for k in range(2)]
    values = np.asarray(field(*np.meshgrid(*axes)), float)
    if not np.isfinite(values).all() or (values < 0.0).any() or values.max() == 0.0:
        raise ValueError(
            "field must be finite and 0 or more everywhere and above 0 somewhere; it runs from "
            f"{values.min():g} to {values.max():g} between {lower.tolist()} and {upper.tolist()}"
        )
    return float((values > least * values.max()).mean() * np.prod(upper - lower))
