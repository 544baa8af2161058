"""Watching a run: signs that it has become unstable, told once.

Every tenth step the agents are looked at.  The signs, and where they begin:

* the step is longer than the largest stable one, which falls with the core radius, and where
  neighbours are uneven (see `apmethod.unevenness`);
* the diffusion velocity is at its limit (see `apmethod.move.diffusion`) for agents with
  more than `LIMITED` of the mass;
* its root mean square has grown by `GROWTH` since the last look and is above `NOISE` of
  that limit, in a step of more than `SHORT` of the largest: diffusion alone calms down, and an
  unstable one ends in noise;
* neighbours are more uneven than the form of the diffusion velocity bears at any step;
* the core radius has fallen below `COLLAPSED` of the one at first;
* agents that had enough neighbours at first have fewer than `LONELY` on average, so that
  their sums are no integrals any more.

Too many neighbours make a run slow and not unstable; the lattice warns of them.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from apmethod.errors import Unstable
from apmethod.unevenness import areas, share_for, unevenness

if TYPE_CHECKING:
    from apmethod.model import ParticleModel
    from apmethod.move.law import Law

#: Steps from one look to the next.
EVERY = 10
#: Share of the mass.  Healthy runs of all schemes have less than 0.01.
LIMITED = 0.05
#: Healthy runs grow by less than 1.1 between two looks, unstable ones by 2 and more.
GROWTH, NOISE = 1.5, 0.01
#: Shorter steps are stable even between agents of very unequal mass, by ``apmethod bench
#: stability``: what grows then is driven by something else, such as animals that gather.
SHORT = 0.3
#: Share of the first core radius.
COLLAPSED = 0.05
#: Neighbours on average, and how many there must have been when the last agent came or went.
LONELY, ENOUGH = 4.0, 10.0
#: Agents that a warning names.
_NAMED = 5


class Watch:
    """Looks for signs of instability in a model's steps.

    Args:
        model: the model.

    Attributes:
        told: whether a sign has been told of; then no more are looked for.
        unevenness: of the agents' neighbours when they were last looked at; None before.
    """

    def __init__(self, model: ParticleModel):
        self.model = model
        self.told = False
        self.unevenness: float | None = None
        self._first_radius = 0.0
        self._first_around = np.inf
        self._speeds: dict[Law, float] = {}
        self._changes = -1

    def look(self) -> None:
        """Look at the agents at the end of a step, if it is time to.

        Warns:
            Unstable: once in a run, with the step, agents and the likely cause.
        """
        model = self.model
        if model.steps % EVERY != 1 or not len(model.particles):
            return
        limited = self._limited
        if any(law.uneven_power for law in limited):
            self.unevenness = unevenness(model, areas(model))
        if self.told:
            return
        sign = self._too_long() or self._collapsed()
        if limited:
            sign = sign or self._lonely()
        for law in limited:
            sign = sign or self._too_uneven(law) or self._too_fast(law)
        self._changes = model.particles.changes
        if sign:
            self.told = True
            warnings.warn(
                f"step {model.steps} (from time {model.elapsed:g}): {sign}", Unstable, stacklevel=4
            )

    def share_left(self) -> float:
        """The share of a chosen step that the agents' unevenness leaves."""
        laws, uneven = [law for law in self._limited if law.uneven_power], self.unevenness
        if laws and uneven is None:  # nobody has received a density: compare the masses
            uneven = unevenness(self.model, self.model.particles.array("mass"))
        shares = (share_for(uneven, law.uneven_power, law.uneven_end) for law in laws)
        return min(shares, default=1.0)

    def _share_by(self, law: Law) -> float:
        return share_for(self.unevenness or 1.0, law.uneven_power, law.uneven_end)

    def _limit(self, law: Law) -> float:
        """The largest step by a law; the model sees to unevenness where it chooses steps."""
        model = self.model
        reach, h = model.motion.integrator.reach, model.bus.shortest_length
        share = 1.0 if model.dt is None else self._share_by(law)
        return share * law.largest_step(model.kernel, h, reach)

    def likely_cause(self) -> str:
        """The end of a sentence on what has gone wrong; empty where there is nothing to say."""
        cause = self._too_long()
        return f"; {cause}" if cause else ""

    # -- the signs ---------------------------------------------------------------------

    def _too_long(self) -> str:
        model, dt = self.model, self.model.motion.dt
        limits = {law: self._limit(law) for law in model.motion.laws}
        law = min(limits, key=limits.get, default=None)
        if law is None or dt <= limits[law] * (1.0 + 1e-9):
            return ""
        return (
            f"the time step {dt:.6g} is unstable: law {law.name!r} allows at most "
            f"{limits[law]:.6g} with the core radius {model.space.smallest_radius:.4g} of now"
            f"{'' if self._share_by(law) == 1.0 else self._so_uneven}; give a smaller dt, or None"
        )

    def _too_uneven(self, law: Law) -> str:
        if self.unevenness is None or self.unevenness <= law.uneven_end:
            return ""
        return (
            f"agents come to no rest by law {law.name!r} at any time step{self._so_uneven}; by the "
            "form 'blob' they do"
        )

    @property
    def _so_uneven(self) -> str:
        return (
            f", as one of two neighbours typically stands for {self.unevenness:.2g} times the area "
            "(mass over density) of the other"
        )

    def _collapsed(self) -> str:
        model, radius = self.model, self.model.space.smallest_radius
        self._first_radius = self._first_radius or radius
        if model.radius_rule is None or radius >= COLLAPSED * self._first_radius:
            return ""
        if model.space.own_radii:
            densest = np.argsort(model.particles.array("core_radius"))[:_NAMED]
        else:
            densest = np.argsort(-model.particles.array("density"))[:_NAMED]
        return (
            f"the core radius has collapsed to {radius:.4g}, at first it was "
            f"{self._first_radius:.4g}; {self._named(densest)} have crowded in one place, a "
            "radius rule with a floor keeps them apart"
        )

    def _lonely(self) -> str:
        space, count = self.model.space, len(self.model.particles)
        if space.own_radii:
            return ""  # each agent sees to its own number
        # Candidates are looked for in a square; the circle's share of it are neighbours.
        cells = space.cells
        share = np.pi * 4.0**cells.level / (2 * 2**cells.level + 1) ** 2
        around = max(share * cells.candidates() / count - 1.0, 0.0)
        if not self._unchanged:
            self._first_around = around
        if around >= LONELY or self._first_around < ENOUGH:
            return ""
        return (
            f"the agents have some {around:.1f} neighbours on average, at first they had "
            f"{self._first_around:.0f}; the cloud has spread or run apart, and a core radius that "
            "follows the density, or a larger one, would find them"
        )

    def _too_fast(self, law: Law) -> str:
        model, rows = self.model, self._rows()
        h = model.motion.now().smoothing_length
        if model.space.own_radii:
            h = h[rows]
        mass = model.particles.array("mass")[rows]
        total = mass.sum()
        if total == 0.0:
            return ""
        top = law.largest_speed(h)
        speed = np.hypot(*self._of(law, rows).T) / top
        at_limit = speed >= 1.0 - 1e-9
        if mass[at_limit].sum() > LIMITED * total:
            return (
                f"law {law.name!r} is at its limit {np.min(top):.4g} for "
                f"{self._named(rows[at_limit])} ({mass[at_limit].sum() / total:.0%} of the mass); "
                "neighbours of very unequal mass or too few of them do that: a larger core radius "
                "would help"
            )
        mean = float(np.sqrt(mass @ speed**2 / total))
        before = self._speeds.get(law, np.inf) if self._unchanged else np.inf
        self._speeds[law] = mean
        reach = model.motion.integrator.reach
        longest = law.largest_step(model.kernel, model.bus.shortest_length, reach)
        if mean > max(GROWTH * before, NOISE) and model.motion.dt > SHORT * longest:
            fastest = rows[np.argsort(-speed)[:_NAMED]]
            return (
                f"the velocity by law {law.name!r} has grown by {mean / before:.2g} in {EVERY} "
                f"steps, most of all for {self._named(fastest)}; the time step "
                f"{model.motion.dt:.4g} is too long for how they stand, give a smaller one"
            )
        return ""

    # -- the agents and laws -----------------------------------------------------------

    @property
    def _limited(self) -> list[Law]:
        """The laws that limit their speed, as diffusion velocities do."""
        h = self.model.bus.smoothing_length
        return [law for law in self.model.motion.evaluated if 0.0 < law.largest_speed(h) < np.inf]

    @property
    def _unchanged(self) -> bool:
        """Whether the same agents were there at the last look."""
        return self._changes == self.model.particles.changes

    def _rows(self) -> np.ndarray:
        """The rows of the agents that go by the model's laws and not by their own."""
        particles, procedure = self.model.particles, self.model.procedure
        own = [cls for cls in particles.classes if procedure.overrides(cls, "move")]
        rows = np.arange(len(particles))
        return np.setdiff1d(rows, particles.rows_of(*own), assume_unique=True) if own else rows

    def _of(self, law: Law, rows: np.ndarray) -> np.ndarray:
        """The law's value for the agents in ``rows``, of shape (rows, 2)."""
        particles, motion = self.model.particles, self.model.motion
        if self.model.procedure.tier == "agents":
            return np.array(
                [law.of(particles._agents[row], motion.now(row)) for row in rows]
            ).reshape(-1, 2)
        total = np.zeros((len(particles), 2))
        law.add_to(total, particles, rows, motion.now())
        return total[rows]

    def _named(self, rows: np.ndarray) -> str:
        """Some agents by name, and how many more there are."""
        agents = [self.model.particles._agents[row] for row in rows[:_NAMED]]
        names = ", ".join(str(agent.unique_id) for agent in agents)
        kinds = "/".join(dict.fromkeys(type(agent).__name__ for agent in agents))
        more = f" and {len(rows) - _NAMED} more" if len(rows) > _NAMED else ""
        return f"agents {names}{more} ({kinds})"
