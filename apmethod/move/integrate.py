"""Time integration: where an agent tries to be, and where it ends a step.

Every step of an integrator is a few *stages*.  In each, the agents perceive, contribute
and message where they stand; then they either `predict` (go to a trial place, only to
perceive from there) or, in the last stage, `move` from where the step began.

First-order laws (a velocity is given): Euler, midpoint, predictor-corrector (Heun), Heun's
third-order rule, the classical Runge-Kutta, and Strang's split of the flow from the
interactions, which then go by midpoint or by the third-order rule.  Second-order
laws (an acceleration is given): leap-frog and velocity Verlet.

A stage without interaction comes before the agents perceive: the flow's first half in
Strang's split, the drift in velocity Verlet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from apmethod.compile import compiled


@dataclass(frozen=True)
class Stage:
    """One evaluation of the laws and what is done with it.

    Attributes:
        at: when the laws are evaluated, as a share of the step.
        ahead: share of the step that `predict` goes on with the stage's velocity.
        weight: the velocity's share in the step's final displacement.
        moves: whether this stage ends the step.
        interacts: whether the agents perceive and message in this stage.
    """

    at: float
    ahead: float
    weight: float
    moves: bool = False
    interacts: bool = True


@dataclass(frozen=True)
class Integrator:
    """The stages of a step, and what they are good for.

    Attributes:
        name: what a scene calls it.
        order: order of the error in the time step.
        stages: the stages of a step.
        reach: how far along the negative real axis it is stable.
        turn: largest turn of the flow in a step that the model chooses, in radians: some
            1e-2 of the distance gone in one turn with Euler, 1e-3 or less with the others.
            One that splits off the flow carries it apart, in steps of its own, and errs
            only where flow and diffusion do not commute: there it is the largest
            deformation, and a rigid rotation has none.
        of: what the laws give, "velocity" or "acceleration".
        splits: whether the flow is carried apart from the interactions.
    """

    name: str
    order: int
    stages: tuple[Stage, ...]
    reach: float
    turn: float = 0.2
    of: str = "velocity"
    splits: bool = False


def _runge_kutta(
    name: str,
    order: int,
    ahead: Sequence[float],
    weights: Sequence[float],
    reach: float,
    turn: float,
) -> Integrator:
    at = (0.0, *ahead)
    stages = tuple(
        Stage(at[k], ahead[k] if k < len(ahead) else 0.0, weights[k], moves=k == len(ahead))
        for k in range(len(weights))
    )
    return Integrator(name, order, stages, reach, turn)


EULER = _runge_kutta("euler", 1, (), (1.0,), 2.0, turn=0.005)
MIDPOINT = _runge_kutta("midpoint", 2, (0.5,), (0.0, 1.0), 2.0, turn=0.05)
HEUN = _runge_kutta("predictor_corrector", 2, (1.0,), (0.5, 0.5), 2.0, turn=0.05)
RK4 = _runge_kutta("rk4", 4, (0.5, 0.5, 1.0), (1 / 6, 1 / 3, 1 / 3, 1 / 6), 2.785, turn=0.2)
HEUN_3 = _runge_kutta("heun_3", 3, (1 / 3, 2 / 3), (0.25, 0.0, 0.75), 2.5127, turn=0.1)
#: Half of the flow, the interactions by the midpoint rule, the other half of the flow.
STRANG = Integrator(
    "strang", 2, (Stage(0.0, 0.5, 0.0, interacts=False), *MIDPOINT.stages), 2.0, splits=True
)
#: The same with the third-order rule.  At the same share of its stability limit it costs a
#: fifth more than the midpoint rule and has a tenth of its error or less.
STRANG_3 = Integrator(
    "strang_3", 2, (STRANG.stages[0], *HEUN_3.stages), HEUN_3.reach, turn=0.1, splits=True
)
#: Velocities live half a step before the positions.
LEAP_FROG = Integrator("leap_frog", 2, (Stage(0.0, 0.0, 1.0, moves=True),), 0.0, of="acceleration")
#: The agents go to the new place first and feel the force there.
VERLET = Integrator(
    "velocity_verlet",
    2,
    (Stage(0.0, 1.0, 0.0, interacts=False), Stage(1.0, 0.0, 1.0, moves=True)),
    0.0,
    of="acceleration",
)

INTEGRATORS = {
    each.name: each
    for each in (EULER, MIDPOINT, HEUN, HEUN_3, RK4, STRANG, STRANG_3, LEAP_FROG, VERLET)
}


def integrator_named(name: str | Integrator) -> Integrator:
    """The integrator of that name; an `Integrator` is handed through.

    Raises:
        ValueError: for a name that is not in ``INTEGRATORS``.
    """
    if isinstance(name, Integrator):
        return name
    if name not in INTEGRATORS:
        raise ValueError(f"integrator is {name!r}; it must be one of {', '.join(INTEGRATORS)}")
    return INTEGRATORS[name]


# -- the stages' formulas, on the rows first to last of the table ----------------------


@compiled
def runge_kutta(first, last, rows, start, rate, displacement, dt, ahead, weight, moves, position):
    """Predict a trial place from this stage's rate, or move by the weighted sum of all."""
    for k in range(first, last):
        row = rows[k]
        for axis in range(2):
            displacement[row, axis] += dt * weight * rate[row, axis]
            if moves:
                position[row, axis] = start[row, axis] + displacement[row, axis]
            else:
                position[row, axis] = start[row, axis] + dt * ahead * rate[row, axis]


@compiled
def leap_frog(first, last, rows, start, rate, velocity, pushed, dt, position):
    """v(t + dt/2) = v(t - dt/2) + dt a(t), then x(t + dt) = x(t) + dt v(t + dt/2)."""
    for k in range(first, last):
        row = rows[k]
        push = dt if pushed[row] else 0.5 * dt  # the first push is half a step
        pushed[row] = 1.0
        for axis in range(2):
            velocity[row, axis] += push * rate[row, axis]
            position[row, axis] = start[row, axis] + dt * velocity[row, axis]


@compiled
def verlet_drift(first, last, rows, start, velocity, acceleration, dt, position):
    """x(t + dt) = x(t) + dt v(t) + dt^2/2 a(t)."""
    for k in range(first, last):
        row = rows[k]
        for axis in range(2):
            mean = velocity[row, axis] + 0.5 * dt * acceleration[row, axis]
            position[row, axis] = start[row, axis] + dt * mean


@compiled
def verlet_kick(first, last, rows, rate, velocity, acceleration, dt):
    """v(t + dt) = v(t) + dt/2 (a(t) + a(t + dt))."""
    for k in range(first, last):
        row = rows[k]
        for axis in range(2):
            velocity[row, axis] += 0.5 * dt * (acceleration[row, axis] + rate[row, axis])
            acceleration[row, axis] = rate[row, axis]
