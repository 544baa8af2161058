"""Named accuracies: parts of a scheme that go together.

=============  =============================================================================
paper          eq 2.3 with the cubic B-spline at 1.3 spacings, predictor-corrector: what the
               paper writes.  First to second order; its error stalls at some 1e-3.
conservative   the blob form with a Gaussian.  Fourth order, positive densities, and
               sum m A = 0 to round-off: momentum and the centre of mass are kept.
accurate       the plain form with a sixth-order Gaussian, laid anew on a lattice where the
               flow has strained it.  The least error for a given time; the centre of mass
               is kept to the error of the scheme.  Up to 2000 agents the Gaussian is cut
               nearer, which they do not notice.
=============  =============================================================================

Both of our own split off the flow (Strang) and carry it apart.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from apmethod.checks import finite_number
from apmethod.contribute.smoothing import Kernel, kernel_named
from apmethod.move.diffusion import FORMS
from apmethod.move.integrate import Integrator, integrator_named

#: Smoothing length in spacings that a kernel is good for.  Less, and sums over a deformed
#: lattice are no longer integrals; more, and the smoothing itself errs.  Larger for a kernel
#: of higher order, which smooths less and resolves finer.  With the Gaussian's 1.4 errors level
#: off at about 2e-5, at walls as in the open and at any time step: in a wedge without flux 3.1e-5
#: with 4000 agents and 2.0e-5 with 16 000; at 1.6 spacings 5.0e-5 and 0.9e-5.
_SPACINGS = {
    "cubic": 1.3,
    "quintic": 1.3,
    "wendland_c2": 1.6,
    "wendland_c4": 2.0,
    "gaussian": 1.4,
    "gaussian_4": 1.6,
    "gaussian_6": 1.9,
    "gaussian_6_short": 1.9,
}
#: Agents up to which a scheme takes its kernel for few: so many err by more than its cut does.
FEW = 2000


@dataclass(frozen=True)
class Accuracy:
    """A scheme for a diffusing field.

    Attributes:
        name: "paper", "conservative" or "accurate"; with changed parts, that and "changed".
        form: diffusion form; see `Diffusion`.
        kernel: smoothing kernel.
        few: smoothing kernel for up to `FEW` agents.
        spacings: smoothing length over the agents' spacing at the start.
        integrator: how it is carried through time.
        remesh: strain since the agents were last on a lattice at which they are laid on a
            new one; 0 for never.
        smooth: standard deviation, in spacings, of the Gaussian that takes the jumps out of
            a start that has any; 0 leaves them in.
        sharp: whether agents are kept down to a share of the largest u that shrinks with
            their number, as this scheme's error does.
    """

    name: str
    form: str
    kernel: Kernel
    few: Kernel
    spacings: float
    integrator: Integrator
    remesh: float
    smooth: float
    sharp: bool

    def __str__(self) -> str:
        remesh = f"laid anew at strain {self.remesh:g}" if self.remesh else "never laid anew"
        return (
            f"{self.name}: {self.form} form, {self.kernel.name} kernel at {self.spacings:g} "
            f"spacings, {self.integrator.name}, {remesh}"
        )

    def for_agents(self, particles: int) -> Accuracy:
        """The scheme with the kernel for that many agents."""
        return replace(self, kernel=self.few) if particles <= FEW else self

    def least(self, particles: int) -> float:
        """Share of the largest u below which no agent is laid, for a number of agents.

        Agents in a thin tail cost what others do.  What is cut off errs by about this share,
        so it follows the error of a fourth-order scheme, which goes with 1/particles^2.
        """
        return min(1e-3, 3e-6 * (16_000 / particles) ** 2) if self.sharp else 1e-5


def _accuracy(name: str, form: str, kernel: str, few: str, integrator: str, remesh: float,
              smooth: float, sharp: bool) -> Accuracy:  # fmt: skip
    return Accuracy(name, form, kernel_named(kernel), kernel_named(few), _SPACINGS[kernel],
                    integrator_named(integrator), remesh, smooth, sharp)  # fmt: skip


# Laid anew at a strain of 0.45: a shear flow errs more at 0.3, oftener, and at 0.6, later.
ACCURACIES = {
    each.name: each
    for each in (
        _accuracy("paper", "paper", "cubic", "cubic", "predictor_corrector", 0.0, 0.0, sharp=False),
        _accuracy("conservative", "blob", "gaussian", "gaussian", "strang_3", 0.0, 3.0, sharp=True),
        _accuracy("accurate", "plain", "gaussian_6", "gaussian_6_short", "strang_3", 0.45, 3.0,
                  sharp=True),
    )
}  # fmt: skip


def accuracy_with(
    name: str,
    *,
    form: str | None = None,
    kernel: str | Kernel | None = None,
    spacings: float | None = None,
    integrator: str | Integrator | None = None,
    remesh: float | None = None,
    smooth: float | None = None,
) -> Accuracy:
    """The accuracy of that name with some parts changed; None leaves a part as it is.

    A kernel set by hand brings the spacings that suit it, unless they are set too.

    Raises:
        ValueError: for an unknown name, form, kernel or integrator, or a bad number.
    """
    if name not in ACCURACIES:
        raise ValueError(f"accuracy is {name!r}; it must be one of {', '.join(ACCURACIES)}")
    if form is not None and form not in FORMS:
        raise ValueError(f"form is {form!r}; it must be one of {', '.join(FORMS)}")
    changes = {"form": form}
    if kernel is not None:
        changes["kernel"] = changes["few"] = kernel_named(kernel)
        changes["spacings"] = _SPACINGS.get(changes["kernel"].name, ACCURACIES[name].spacings)
    if spacings is not None:
        changes["spacings"] = finite_number("spacings", spacings, above=0.0)
    if integrator is not None:
        changes["integrator"] = integrator_named(integrator)
    if remesh is not None:
        changes["remesh"] = finite_number("remesh", remesh, least=0.0)
    if smooth is not None:
        changes["smooth"] = finite_number("smooth", smooth, least=0.0)
    changed = replace(ACCURACIES[name], **{k: v for k, v in changes.items() if v is not None})
    return changed if changed == ACCURACIES[name] else replace(changed, name=f"{name}, changed")
