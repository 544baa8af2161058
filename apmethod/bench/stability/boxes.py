"""Agents that diffuse in a periodic box: where they stand, what they weigh, and how fast."""

from __future__ import annotations

import numpy as np

from apmethod.agent import DiffusingParticle
from apmethod.contribute.smoothing import KERNELS
from apmethod.model import ParticleModel
from apmethod.move.diffusion import Diffusion
from apmethod.perceive.domain import Periodic

#: How agents may stand at the start.
STARTS = ("lattice", "jittered", "random", "clustered")


class Box(ParticleModel):
    """The unit square, periodic, with D = 1, and no word about steps that are too long.

    Args:
        form, kernel, integrator: the scheme.
        along: agents along a side.
        spacings: smoothing length over the spacing of the agents' lattice.
        start: one of `STARTS`.
        mass_ratio: of the heaviest to the lightest agent; 1 for equal ones.
        rng: seed.

    Attributes:
        limit: the largest stable step, by theory.
    """

    def __init__(
        self,
        form: str,
        kernel: str,
        integrator: str,
        *,
        along: int = 20,
        spacings: float = 2.0,
        start: str = "lattice",
        mass_ratio: float = 1.0,
        rng: int = 1,
    ):
        super().__init__(
            DiffusingParticle,
            core_radius=spacings / along * KERNELS[kernel].support,
            domain=Periodic((0, 0), (1, 1)),
            kernel=kernel,
            laws=[Diffusion(1.0, form)],
            integrator=integrator,
            rng=rng,
        )
        self.watch.told = True  # it is the very purpose
        self.limit = self.largest_dt()
        draw = np.random.default_rng(rng)
        self.places = places(start, along, draw)
        masses = mass_ratio ** -draw.random(len(self.places))
        DiffusingParticle.create_agents(
            self, len(masses), position=self.places, mass=masses / masses.sum()
        )

    def put(self, shaken: float = 0.0) -> None:
        """Put the agents back to where they started, off by ``shaken`` at random."""
        off = shaken * np.random.default_rng(2).normal(size=self.places.shape)
        self.particles.assign("position", (self.places + off) % 1.0)

    def speeds(self, dt: float, steps: int) -> np.ndarray:
        """Root mean square of |A| h/D by mass at the end of each step, of shape (steps,).

        A run that fails is infinitely fast from there on.
        """
        self.dt = dt
        mass, found = self.particles.mass, np.full(steps, np.inf)
        for step in range(steps):
            with np.errstate(all="ignore"):
                try:
                    self.step()
                except RuntimeError:
                    break
                square = (self.particles.array("_rate") ** 2).sum(axis=1)
                found[step] = np.sqrt(mass @ square / mass.sum()) * self.bus.smoothing_length
        return found


def places(start: str, along: int, draw: np.random.Generator) -> np.ndarray:
    """Places of along^2 agents in the unit square, of shape (agents, 2).

    Jittered agents are off their lattice by a third of a spacing to each side at the most;
    clustered ones stand around a tenth as many random centres, about a spacing off.
    """
    count, spacing = along**2, 1.0 / along
    if start == "random":
        return draw.random((count, 2))
    if start == "clustered":
        centres = draw.random((max(1, count // 10), 2))
        chosen = centres[draw.integers(len(centres), size=count)]
        return (chosen + spacing * draw.normal(size=(count, 2))) % 1.0
    side = (np.arange(along) + 0.5) * spacing
    lattice = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    jitter = {"lattice": 0.0, "jittered": spacing / 3.0}[start]
    return lattice + jitter * draw.uniform(-1.0, 1.0, lattice.shape)
