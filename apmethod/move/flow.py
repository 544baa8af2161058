"""Given flows: agents that are carried along by V(x, y, t)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from apmethod.compile import compiled, in_blocks, inlined, plain
from apmethod.move.law import Law
from apmethod.perceive.sorting import corners

#: Rules that are extrapolated from, at the most: with 2, 4, 6, ... midpoint steps.
_RULES = 7
#: How often a part of a carry that does not converge is halved: a flow may be rough.
_HALVINGS = 10


class Flow(Law):
    """A given velocity field V(x, y, t), of which each agent takes the value where it is.

    Args:
        field: ``V(x, y, t)`` giving (x, y); plain Python that numba compiles.
        name: what ``explain`` calls it.
    """

    def __init__(self, field: Callable, name: str = "flow"):
        self.field = inlined(field, arrays=True)
        try:
            value = tuple(float(part) for part in field(0.5, 0.25, 0.0))
        except TypeError as error:
            raise ValueError(f"flow {field!r} is not V(x, y, t) giving (x, y): {error}") from None
        if len(value) != 2:
            raise ValueError(f"flow {field!r} gives {len(value)} numbers; it must give (x, y)")
        super().__init__(name, _at_position(self.field), reads=("position",))

    def turning(self, positions: np.ndarray, time: float) -> float:
        """The largest |grad V| at ``positions``, 1/time: the angular velocity of a rotation."""
        return self._rates(positions, time)[0]

    def deforming(self, positions: np.ndarray, time: float) -> float:
        """The largest rate of strain |grad V + grad V^T| / 2 at ``positions``, 1/time."""
        turning, deforming = self._rates(positions, time)
        return deforming if deforming > 1e-8 * turning else 0.0  # rounding of a rigid rotation

    def _rates(self, positions: np.ndarray, time: float) -> tuple[float, float]:
        lowest, highest = corners(positions)
        extent = max(highest[0] - lowest[0], highest[1] - lowest[1]) if len(positions) else 0.0
        return _compile_rates(self.field)(positions, 1e-4 * extent or 1e-4, time)

    def carry(
        self,
        arrived: np.ndarray,
        places: np.ndarray,
        rows: np.ndarray,
        time: float,
        span: float,
        turning: float,
        tolerance: float,
        *,
        in_python: bool = False,
    ) -> None:
        """Carry ``places[rows]``, of shape (n, 2), by the flow alone to ``arrived[rows]``.

        The midpoint rule extrapolated to steps of no length (Gragg, Bulirsch and Stoer), in
        parts of at most 0.8 of a radian; a part that has not converged is halved.

        Args:
            arrived, places: where to write and where to start, of shape (n, 2).
            rows: which.
            time, span: from when, and how long.
            turning: of the flow there, see `turning`.
            tolerance: error of a part, a length.
            in_python: without compiled code.
        """
        parts = max(1, int(np.ceil(abs(span) * turning / 0.8)))
        run = _compile_carry(self.field)
        if in_python:
            plain(run)(0, len(rows), rows, places, time, span, parts, tolerance, arrived)
        else:
            in_blocks(
                run, len(rows), rows, places, time, span, parts, tolerance, arrived, least=5000
            )


@cache
def _at_position(field: Callable) -> Callable:
    def formula(agent, p):
        return field(agent.position[0], agent.position[1], p.time)

    return formula


@cache
def _compile_rates(field: Callable) -> Callable:
    @compiled
    def rates(positions, step, time):
        turning = deforming = 0.0
        for k in range(positions.shape[0]):
            x, y = positions[k, 0], positions[k, 1]
            east, west = field(x + step, y, time), field(x - step, y, time)
            north, south = field(x, y + step, time), field(x, y - step, time)
            a, b = east[0] - west[0], north[0] - south[0]
            c, d = east[1] - west[1], north[1] - south[1]
            # Half the squared Frobenius norm: the squared angular velocity of a rotation.
            turning = max(turning, 0.5 * (a * a + b * b + c * c + d * d))
            deforming = max(deforming, a * a + d * d + 0.5 * (b + c) * (b + c))
        return np.sqrt(turning) / (2.0 * step), np.sqrt(deforming) / (2.0 * step)

    return rates


@cache
def _compile_carry(field: Callable) -> Callable:
    @inlined
    def extrapolated(x, y, time, span, tolerance, table):
        """The place after ``span``, and whether the error is below the tolerance."""
        best_x, best_y = x, y
        for rule in range(_RULES):
            steps = 2 * (rule + 1)
            h = span / steps
            last_x, last_y = x, y
            u, v = field(x, y, time)
            here_x, here_y = x + h * u, y + h * v
            for step in range(1, steps):
                u, v = field(here_x, here_y, time + step * h)
                last_x, here_x = here_x, last_x + 2.0 * h * u
                last_y, here_y = here_y, last_y + 2.0 * h * v
            # Aitken and Neville: the polynomial in h^2 through all rules so far, at h = 0.
            for order in range(1, rule + 1):
                ratio = (rule + 1.0) / (rule + 1.0 - order)
                weight = 1.0 / (ratio * ratio - 1.0)
                old_x, old_y = table[order - 1, 0], table[order - 1, 1]
                table[order - 1, 0], table[order - 1, 1] = here_x, here_y
                here_x += weight * (here_x - old_x)
                here_y += weight * (here_y - old_y)
            table[rule, 0], table[rule, 1] = here_x, here_y
            error = max(abs(here_x - best_x), abs(here_y - best_y))
            best_x, best_y = here_x, here_y
            if rule > 1 and error <= tolerance:
                return best_x, best_y, True
        return best_x, best_y, False

    @compiled
    def carry(first, last, rows, places, time, span, parts, tolerance, arrived):
        table = np.empty((_RULES, 2))
        for k in range(first, last):
            x, y = places[rows[k], 0], places[rows[k], 1]
            length, done = 1.0 / parts, 0.0
            while done < 1.0:
                length = min(length, 1.0 - done)
                far_x, far_y, converged = extrapolated(
                    x, y, time + done * span, length * span, tolerance, table
                )
                if converged or length * parts < 0.5**_HALVINGS or not np.isfinite(far_x + far_y):
                    x, y, done = far_x, far_y, done + length
                else:
                    length *= 0.5
                if 1.0 - done < 1e-12:
                    done = 1.0
            arrived[rows[k], 0], arrived[rows[k], 1] = x, y

    return carry
