"""Walls that take mass: u = 0 at walls that absorb, for agents that carry a field.

Towards such a wall the diffusion velocity A = -D grad u / u grows as D over the distance.
Agents that followed it would be drawn apart beside the wall, there where u bends the most,
and no smoothing length would fit both there and elsewhere.  So they are held off, and hand
their mass to the wall instead.  For any vector field g

    du/dt + div((A + D g) u) = D u (div g + g . grad u / u),

that is: an agent that moves with A' = A + D g instead of A has a mass that changes as

    dm/dt = m (D (div g + |g|^2) - g . A').

With g about n/d, d the distance from the wall and n its normal, A' and the rate are smooth up
to the wall; see `apmethod.move.obstacles.holding`.  A itself takes the images of opposite sign
that such walls have (see `apmethod.move.obstacles.beams`).

Beside straight walls and in the corners of rooms this is as accurate as diffusion is anywhere
(relative L2 error 2e-5 to 4e-5 with 4000 agents, and 2e-2 to 6e-2 where walls take only the
agents that run into them).  Around outer corners and the ends of thin walls u is not smooth, and
sums within a core radius of them are not complete: some 1e-3 to 4e-3 in the plain form.  The
blob form divides by those sums at both ends of a pair, and errs there by 1e-2 and more: among
such corners take accuracy "accurate".

Where the wall comes nearer at a speed w, u bends beside it by w/D times its slope, which images
of opposite sign do not show: with a core radius R of 0.8, 1.5, 3 and 8 times D/w the error grows
to 2e-4, 8e-4, 3e-3 and 3e-2 (4000 agents, "accurate").  What agents have lost walls have, always.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.compile import compiled, in_blocks, plain
from apmethod.move.diffusion import Diffusion
from apmethod.move.law import Law, Now
from apmethod.move.obstacles.holding import hold_off
from apmethod.move.obstacles.look import walls_near
from apmethod.move.obstacles.sight import kinds_of, shifts_of
from apmethod.particles import Column

if TYPE_CHECKING:
    from apmethod.move.integrate import Stage
    from apmethod.move.obstacles.collection import Obstacles
    from apmethod.perceive.lattice import QuadLattice

#: How far from walls agents are held off, in core radii.  Agents gather where the layer that
#: diffusion has emptied gets wider than this: as exp(2 D t / reach^2).
REACH = 4.0

#: Largest area that an agent stands for, in squared smoothing lengths: beyond that of the
#: kernels' own, 1 / W(0).
WIDEST = 4.0


class Absorption:
    """Holds agents off walls that absorb, and takes their mass.

    Args:
        obstacles: those walls, among others.
        space: the agents' lattice; the reach follows its core radius.
        laws: of the scene; diffusion is among them.

    Attributes:
        laws: the same ones, with the velocity A' for diffusion.
    """

    def __init__(self, obstacles: Obstacles, space: QuadLattice, laws: Sequence[Law]):
        self.obstacles, self.space, self.particles = obstacles, space, space.particles
        self.laws = tuple(law.held_off() if isinstance(law, Diffusion) else law for law in laws)
        self._diffusion = [law for law in self.laws if isinstance(law, Diffusion)]
        # Written within a step before they are read, so not part of an agent's state.
        declare = self.particles.declare
        for name in ("held_off", "_diffused"):
            declare(name, Column(2, kept=False))
        for name in ("_emptied", "_gain"):
            declare(name, Column(kept=False))
        declare("_begun_mass", Column(kept=False, like="mass"))

    def begin(self) -> None:
        """Take down what the agents start with."""
        self.particles.array("_begun_mass")[:] = self.particles.array("mass")
        self.particles.array("_gain")[:] = 0.0

    def received(self, smoothing_length: float) -> None:
        """Keep densities above that of an agent alone in an area of `WIDEST` h^2.

        Only images of opposite sign bring a density below it, where an agent is thrown at a
        wall, and only the blob form has others divide by it.
        """
        if "blob_gradient" in self.particles:
            density, mass = self._array("density"), self._array("mass")
            np.maximum(density, mass / (WIDEST * smoothing_length**2), out=density)

    def look(self, rows: np.ndarray, *, in_python: bool) -> None:
        """Find g and div g + |g|^2 where the agents in ``rows`` are."""
        obstacles, domain = self.obstacles, self.space.domain
        reach = REACH * self.space.core_radius
        self._run(
            _look, rows, in_python, self._array("position"), reach, obstacles.tree,
            obstacles.walls, kinds_of(obstacles), np.array(shifts_of(domain)), obstacles.clearance,
            self._array("held_off"), self._array("_emptied"),
        )  # fmt: skip

    def take(self, rows: np.ndarray, now: Now, stage: Stage, dt: float, *, in_python: bool) -> None:
        """Let masses follow their rate for a stage of the integrator."""
        diffused = self._array("_diffused")
        for law in self._diffusion:
            diffused[rows] = 0.0
            if in_python:
                agent = self.particles._agents[rows[0]]
                diffused[rows[0]] = law.of(agent, now)
            else:
                law.add_to(diffused, self.particles, rows, now)
            fastest = law.diffusivity / now.smoothing_length**2
            self._run(
                _take, rows, in_python, law.diffusivity, fastest, dt, stage.ahead, stage.weight,
                stage.moves, self._array("held_off"), self._array("_emptied"),
                diffused, self._array("_begun_mass"), self._array("_gain"), self._array("mass"),
            )  # fmt: skip

    def arrived(self) -> None:
        """Tell the obstacles what has been taken in the step."""
        gone = self._array("_begun_mass") - self._array("mass")
        self.obstacles.taken_mass = float(gone.sum())

    def _array(self, name: str) -> np.ndarray:
        return self.particles.array(name)

    @staticmethod
    def _run(formula, rows: np.ndarray, in_python: bool, *arguments) -> None:
        if in_python:
            plain(formula)(0, len(rows), rows, *arguments)
        else:
            in_blocks(formula, len(rows), rows, *arguments)


@compiled
def _look(
    first, last, rows, position, reach, tree, walls, kinds, shifts, clearance, held_off, emptied
):
    """g and div g + |g|^2 of each agent."""
    waiting, leaves = np.empty(len(tree.axis), np.int32), np.empty(len(tree.axis), np.int32)
    tried = np.full(len(walls.turn), -1, np.int64)
    most = len(shifts) * len(walls.turn)
    near, kind = np.empty((most, 8)), np.empty(most, np.int8)
    for k in range(first, last):
        x, y = position[rows[k], 0], position[rows[k], 1]
        count = 0
        for shift in range(len(shifts)):
            count = walls_near(
                x, y, shifts[shift, 0], shifts[shift, 1], reach, tree, walls, kinds, waiting,
                leaves, tried, k * len(shifts) + shift, near, kind, count,
            )  # fmt: skip
        along_x, along_y, rate = hold_off(x, y, near, kind, count, reach, clearance)
        held_off[rows[k], 0], held_off[rows[k], 1] = along_x, along_y
        emptied[rows[k]] = rate


@compiled
def _take(
    first, last, rows, diffusivity, fastest, dt, ahead, weight, moves, held_off, emptied,
    diffused, begun_mass, gain, mass,
):  # fmt: skip
    """Masses at the stage's trial place, or at the end of the step."""
    for k in range(first, last):
        row = rows[k]
        along = held_off[row, 0] * diffused[row, 0] + held_off[row, 1] * diffused[row, 1]
        # Where u is resolved it grows no faster; around corners it may not be.
        rate = min(diffusivity * emptied[row] - along, fastest)
        gain[row] += dt * weight * rate
        mass[row] = begun_mass[row] * np.exp(gain[row] if moves else dt * ahead * rate)
