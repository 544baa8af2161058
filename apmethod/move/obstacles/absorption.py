"""Walls that take mass: u = 0 at walls that absorb, for agents that carry a field.

Towards such a wall the diffusion velocity A = -D grad u / u grows as D over the distance.
Agents that followed it would be drawn apart beside the wall, there where u bends the most,
and no smoothing length would fit both there and elsewhere.  So they are held off, and hand
their mass to the wall instead.  For any vector field g

    du/dt + div((A + D g) u) = D lap u + (div g + g . grad u / u) D u,

that is: an agent that moves with A' = A + D g instead of A has a mass that changes as

    dm/dt = m (D (div g + |g|^2) - g . A').

With g = grad log f(d), d the distance from the wall, f(d) odd and 1 from a reach on, A' and
the rate are smooth up to the wall.  Several walls' g add up.  A itself takes the images of
opposite sign that such walls have (see `apmethod.move.obstacles.beams`).

Beside straight walls and in their right-angled corners, also with walls that let nothing
through, this is as accurate as diffusion is anywhere.  Around the outer corners of obstacles g
goes round the corner, and is smoothed within a smoothing length of it: there u itself is not
smooth.  Where a reflecting wall meets an absorbing one at another angle, g has a part through
the reflecting one, and the field within the reach of that corner is off by some per cent.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.compile import compiled, in_blocks, plain
from apmethod.move.diffusion import Diffusion
from apmethod.move.law import Law, Now
from apmethod.move.obstacles.beams import CUTS, NEGATES, in_sight, side_of
from apmethod.move.obstacles.borrowing import exact
from apmethod.move.obstacles.look import walls_near
from apmethod.move.obstacles.rays import to_wall
from apmethod.move.obstacles.sight import kinds_of, shifts_of
from apmethod.particles import Column

if TYPE_CHECKING:
    from apmethod.move.integrate import Stage
    from apmethod.move.obstacles.collection import Obstacles
    from apmethod.perceive.lattice import QuadLattice

#: How far from walls agents are held off, in core radii.  Agents gather where the layer that
#: diffusion has emptied gets wider than this: as exp(2 D t / reach^2).
REACH = 4.0
#: How far from corners g is smoothed, as a share of the reach: about a smoothing length.
_ROUND = 1.0 / 16.0


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
        for name, components in (
            ("held_off", 2), ("_emptied", None), ("_begun_mass", None), ("_diffused", 2),
            ("_loss", None),
        ):  # fmt: skip
            self.particles.declare(name, Column(components, kept=False))

    def begin(self) -> None:
        """Take down what the agents start with."""
        self.particles.array("_begun_mass")[:] = self.particles.array("mass")
        self.particles.array("_loss")[:] = 0.0

    def look(self, rows: np.ndarray, *, in_python: bool) -> None:
        """Find g and div g + |g|^2 where the agents in ``rows`` are."""
        obstacles, domain = self.obstacles, self.space.domain
        reach = REACH * self.space.core_radius
        self._run(
            _look, rows, in_python, self._array("position"), reach, obstacles.tree,
            obstacles.walls, kinds_of(obstacles), shifts_of(domain), obstacles.clearance,
            self._array("held_off"), self._array("_emptied"),
        )  # fmt: skip

    def take(
        self, rows: np.ndarray, now: Now, stage: Stage, dt: float, *, in_python: bool
    ) -> None:
        """Let masses follow their rate for a stage of the integrator."""
        diffused = self._array("_diffused")
        for number, law in enumerate(self._diffusion):
            diffused[rows] = 0.0
            if in_python:
                agent = self.particles._agents[rows[0]]
                diffused[rows[0]] = law.of(agent, now)
            else:
                law.add_to(diffused, self.particles, rows, now)
            self._run(
                _take, rows, in_python, law.diffusivity, dt, stage.ahead, stage.weight,
                stage.moves, number == 0, self._array("held_off"), self._array("_emptied"),
                diffused, self._array("_begun_mass"), self._array("_loss"), self._array("mass"),
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
    waiting, tried = np.empty(len(tree.axis), np.int32), np.full(len(walls.turn), -1, np.int64)
    most = len(shifts) * len(walls.turn)
    near, kind = np.empty((most, 8)), np.empty(most, np.int8)
    for k in range(first, last):
        x, y = position[rows[k], 0], position[rows[k], 1]
        count = 0
        for shift in range(len(shifts)):
            count = walls_near(
                x, y, shifts[shift, 0], shifts[shift, 1], reach, tree, walls, kinds, waiting,
                tried, k * len(shifts) + shift, near, kind, count,
            )  # fmt: skip
        along_x, along_y, rate = off_all(x, y, near, kind, count, reach, clearance)
        held_off[rows[k], 0], held_off[rows[k], 1] = along_x, along_y
        emptied[rows[k]] = rate


@exact
def off_all(x, y, walls, kind, count, reach, clearance):
    """g of all walls near (x, y) that absorb, and div g + |g|^2."""
    along_x, along_y, rate = 0.0, 0.0, 0.0
    for wall in range(count):
        if kind[wall] != NEGATES or side_of(walls, wall, x, y) * walls[wall, 7] < -clearance:
            continue
        off_x, off_y, share = to_wall(
            x, y, walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
        )
        distance = np.hypot(off_x, off_y)
        at_end = share == 0.0 or share == 1.0
        if at_end and goes_round(x, y, walls, kind, count, wall, share):
            continue
        back = 2.0 * clearance / distance
        if back < 1.0 and not in_sight(
            walls, kind, count, x, y, x - (1.0 - back) * off_x, y - (1.0 - back) * off_y, clearance
        ):
            continue
        size = np.hypot(distance, _ROUND * reach) if at_end else distance
        if size >= reach:
            continue
        # f(z) = (35 z - 35 z^3 + 21 z^5 - 5 z^7) / 16, whose derivatives vanish at z = 1.
        z, z_2 = size / reach, (size / reach) ** 2
        per_z = (35.0 - 35.0 * z_2 + 21.0 * z_2 * z_2 - 5.0 * z_2 * z_2 * z_2) / 16.0
        slope = 2.1875 * (1.0 - z_2) ** 3 / (per_z * z * reach)
        bend = -13.125 * (1.0 - z_2) ** 2 / (per_z * reach * reach)
        strength = slope / size
        g_x, g_y = strength * off_x, strength * off_y
        rate += 2.0 * (along_x * g_x + along_y * g_y)
        if at_end:  # the divergence of a radial field
            steep = (bend - slope * slope - strength) * (distance / size) ** 2
            rate += 2.0 * strength + steep + g_x * g_x + g_y * g_y
        else:
            rate += bend
        along_x, along_y = along_x + g_x, along_y + g_y
    return along_x, along_y, rate


@exact
def goes_round(x, y, walls, kind, count, wall, share):
    """Whether the end of a wall that is nearest to (x, y) is another wall's to count.

    At the outer corner of an obstacle two walls are one way round: there the corner counts
    once, and beside either wall only that one.  In the corner of a room both count.
    """
    end, far = (0, 2) if share == 0.0 else (2, 0)
    end_x, end_y = walls[wall, end], walls[wall, end + 1]
    for other in range(count):
        if other == wall or kind[other] != NEGATES:
            continue
        first = walls[other, 0] == end_x and walls[other, 1] == end_y
        second = walls[other, 2] == end_x and walls[other, 3] == end_y
        if not (first or second):
            continue
        _, _, place = to_wall(
            x, y, walls[other, 0], walls[other, 1], walls[other, 2], walls[other, 3]
        )
        if (first and place == 0.0) or (second and place == 1.0):
            if other < wall:
                return True
        elif (
            side_of(walls, other, walls[wall, far], walls[wall, far + 1])
            * side_of(walls, other, x, y)
            <= 0.0
        ):
            return True
    return False


@compiled
def _take(
    first, last, rows, diffusivity, dt, ahead, weight, moves, begins, held_off, emptied, diffused,
    begun_mass, loss, mass,
):  # fmt: skip
    """Masses at the stage's trial place, or at the end of the step."""
    for k in range(first, last):
        row = rows[k]
        along = held_off[row, 0] * diffused[row, 0] + held_off[row, 1] * diffused[row, 1]
        rate = diffusivity * emptied[row] - along
        loss[row] += dt * weight * rate
        trial = dt * ahead * rate
        if moves:
            trial = loss[row]
        mass[row] = begun_mass[row] * np.exp(trial)
