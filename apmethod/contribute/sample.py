"""Laying a field on agents: the reverse of `apmethod.contribute.reconstruct`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from apmethod.checks import whole_number

Field = Callable[[np.ndarray, np.ndarray], np.ndarray]


def sample(
    field: Field,
    count: int,
    lower: Sequence[float],
    upper: Sequence[float],
    *,
    least: float = 1e-5,
    offset: Sequence[float] = (0.0, 0.0),
) -> tuple[np.ndarray, np.ndarray, float]:
    """Agents on a square lattice, each with the mass of the field in its square.

    m_i = u(x_i) dx^2, for the ``count`` lattice points with the largest u.  Masses on a
    lattice represent a smooth field far better than equal masses at random places.

    Args:
        field: u(x, y) on arrays, mass per area, 0 or more.
        count: number of agents.
        lower, upper: corners of the rectangle in which the field is looked for.
        least: share of the largest u below which a place is left without an agent.
        offset: shift of the lattice, in spacings.

    Returns:
        positions of shape (count, 2), masses of shape (count,), and the spacing dx.

    Raises:
        ValueError: for a count below 1, a field that is negative, not finite or zero.
    """
    count = whole_number("count", count, least=1)
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    area = _area_above(field, lower, upper, least)
    spacing = np.sqrt(area / count)
    for _ in range(60):
        positions, values = _lattice(field, lower, upper, spacing, offset, least)
        if len(values) >= count:
            break
        spacing *= 0.998 * np.sqrt(len(values) / count) if len(values) < 0.9 * count else 0.998
    kept = np.sort(np.argsort(-values, kind="stable")[:count])
    return positions[kept], values[kept] * spacing**2, float(spacing)


def _lattice(
    field: Field,
    lower: np.ndarray,
    upper: np.ndarray,
    spacing: float,
    offset: Sequence[float],
    least: float,
) -> tuple[np.ndarray, np.ndarray]:
    axes = [np.arange(lower[k] + (offset[k] % 1.0) * spacing, upper[k], spacing) for k in range(2)]
    x, y = (part.ravel() for part in np.meshgrid(*axes))
    values = np.asarray(field(x, y), float)
    inside = values > least * values.max(initial=0.0)
    return np.column_stack([x, y])[inside], values[inside]


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
