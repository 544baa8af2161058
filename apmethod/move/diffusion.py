"""Diffusion as a velocity, A = -D grad u / u (paper eq 3.2, Degond and Mustieles 1990).

The forms differ in how the gradient is taken from the neighbours:

* ``paper``: eq 2.3 with phi = rho, the difference form.  It is exact for a constant field
  and does not see the edge of a cloud.
* ``plain``: the gradient of the smoothed density over the smoothed density.  Smoothing
  adds a bias of O(h^2); with a fourth-order kernel it is O(h^4).
* ``blob``: the gradient flow of the smoothed entropy (Carrillo, Craig and Patacchini
  2019).  The O(h^2) bias cancels and sum m A = 0 to round-off.

In each, |A| is limited to ``limit`` D/h: nothing diffuses through more than a few
smoothing lengths in the time h^2/D.

What holds at the edges, in every form:

* An isolated agent has no neighbours and no velocity.
* Coincident agents give each other nothing and move alike: together they are one agent of
  their joint mass, for ever.  Whoever wants them apart places them apart, and a scene that
  makes coincident ones can let them aggregate.
* A massless agent changes nobody's velocity.  Its own is that of the field where it is, so
  it is a tracer; where the field is zero, too, it has none.
* A light agent at a small distance d of a heavy one is driven off at about 2 D d/h^2
  (blob: twice that), at the edge of its support at the limit.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from functools import cache
from math import sqrt

import numpy as np

from apmethod.checks import finite_number
from apmethod.compile import inlined
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import (
    NOTHING,
    Term,
    blob_gradient,
    density,
    density_difference,
    density_gradient,
)
from apmethod.move.law import Law


@inlined
def _limited(x, y, largest):
    size = sqrt(x * x + y * y)
    if size > largest:
        return x * (largest / size), y * (largest / size)
    return x, y


def _paper(agent, p):
    """-D grad u / u, unlimited, as the two below."""
    rho = max(abs(agent.density), NOTHING)
    scale = -p.diffusivity / rho
    return scale * (agent.density_difference[0] / rho), scale * (agent.density_difference[1] / rho)


def _plain(agent, p):
    # Only a kernel with a negative tail lets the sum fall below a share of the own part.
    scale = -p.diffusivity / max(agent.density, 0.05 * agent.mass * p.own_w, NOTHING)
    return scale * agent.density_gradient[0], scale * agent.density_gradient[1]


def _blob(agent, p):
    return -p.diffusivity * agent.blob_gradient[0], -p.diffusivity * agent.blob_gradient[1]


@cache
def _velocity(unlimited: Callable) -> Callable:
    inlined(unlimited)

    def velocity(agent, p):
        x, y = unlimited(agent, p)
        return _limited(x, y, p.limit * p.diffusivity / p.smoothing_length)

    return velocity


@cache
def _held_off(unlimited: Callable) -> Callable:
    inlined(unlimited)

    def velocity(agent, p):
        x, y = unlimited(agent, p)
        x, y = x + p.diffusivity * agent.held_off[0], y + p.diffusivity * agent.held_off[1]
        return _limited(x, y, p.limit * p.diffusivity / p.smoothing_length)

    return velocity


@dataclass(frozen=True)
class Form:
    """A way to take the diffusion velocity from the neighbours.

    Attributes:
        formula: the velocity, not limited.
        reads: columns that it uses.
        terms: what it has exchanged.
        decay: damping of a small wave over D k^2, from the kernel's transform at k.
        uneven_power, uneven_end: see `Law`; by ``apmethod bench stability``.
    """

    formula: Callable
    reads: tuple[str, ...]
    terms: tuple[Term, ...]
    decay: Callable[[np.ndarray], np.ndarray]
    uneven_power: float = 0.4
    uneven_end: float = np.inf


FORMS = {
    "paper": Form(
        _paper,
        ("density", "density_difference"),
        (density, density_difference),
        decay=lambda w: w * w,
        uneven_power=1.7,
        uneven_end=6.0,
    ),
    "plain": Form(
        _plain,
        ("mass", "density", "density_gradient"),
        (density, density_gradient),
        decay=lambda w: w,
        uneven_end=200.0,
    ),
    "blob": Form(
        _blob, ("blob_gradient",), (density, blob_gradient), decay=lambda w: w * (2.0 - w)
    ),
}


class Diffusion(Law):
    """The diffusion velocity of an agent.

    Args:
        diffusivity: D, length^2/time, 0 or more.
        form: "paper", "plain" or "blob".
        limit: largest |A| h/D.

    Raises:
        ValueError: for an unknown form, or a negative or non-finite diffusivity or limit.
    """

    def __init__(self, diffusivity: float, form: str = "blob", limit: float = 6.0):
        if form not in FORMS:
            raise ValueError(f"form is {form!r}; it must be one of {', '.join(FORMS)}")
        self.form = FORMS[form]
        self.uneven_power, self.uneven_end = self.form.uneven_power, self.form.uneven_end
        self.diffusivity = finite_number("diffusivity", diffusivity, least=0.0)
        limit = finite_number("limit", limit, least=0.0)
        super().__init__(
            f"diffusion velocity, {form} form",
            _velocity(self.form.formula),
            reads=self.form.reads,
            parameters={"diffusivity": self.diffusivity, "limit": limit},
            terms=self.form.terms,
        )

    def held_off(self) -> Diffusion:
        """The same with agents held off walls that take mass.

        See `apmethod.move.obstacles.absorption`.
        """
        held = copy(self)
        held.formula, held.reads = _held_off(self.form.formula), (*self.reads, "held_off")
        return held

    def check(self, kernel: Kernel) -> None:
        """Refuse the blob form with a kernel that is negative somewhere."""
        if self.form is FORMS["blob"] and kernel.order > 2:
            raise ValueError(
                f"kernel is {kernel.name!r}, which makes densities negative in thin places, and "
                "the blob form divides by them; use a positive kernel such as 'gaussian'"
            )

    def largest_step(self, kernel: Kernel, smoothing_length: float, reach: float) -> float:
        """The largest stable time step.

        A wave of number k decays at the rate D k^2 g(k), g the form's damping; an
        integrator that is stable down to -reach on the negative axis needs
        dt max(D k^2 g) <= reach.
        """
        if self.diffusivity == 0.0:
            return np.inf
        return reach / _quickest(kernel, self.form) * smoothing_length**2 / self.diffusivity

    def largest_speed(self, smoothing_length: float) -> float:
        """``limit`` D/h."""
        return self.parameters["limit"] * self.diffusivity / smoothing_length


@cache
def _quickest(kernel: Kernel, form: Form) -> float:
    """The largest k^2 g(k), for h = 1."""
    k, transform = kernel.transform
    return float((k * k * form.decay(transform)).max())
