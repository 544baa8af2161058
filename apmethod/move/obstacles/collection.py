"""The obstacles of a model: how they come and go, and what a step does with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from apmethod.checks import finite_number
from apmethod.compile import in_blocks, plain
from apmethod.errors import StepFailed
from apmethod.move.obstacles.carry import BEHAVE, FREE, STOP
from apmethod.move.obstacles.clear import GROUP, who_may_meet
from apmethod.move.obstacles.questions import Questions
from apmethod.move.obstacles.rays import RAYS_A_BLOCK
from apmethod.move.obstacles.shapes import Obstacle
from apmethod.move.obstacles.tree import RULES, Rules
from apmethod.particles import Column, Particles
from apmethod.perceive.domain import Domain

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle

#: What walls that absorb take.
ABSORBING = ("agents", "mass")
#: What agents feel of each other where walls are.
CONTRIBUTIONS = ("mirrored", "blocked", "through")
#: Groups of agents that a thread tests at the least: far from walls that takes 0.2 ms.
_GROUPS_A_BLOCK = 400


class Obstacles(Questions):
    """What a model's agents cannot pass.

    Args:
        obstacles: polygons and thin walls.
        contributions: what agents feel of each other where walls are.  "mirrored": nothing
            through them, and what they mirror besides, so that sums are complete beside them
            and diffusion has no flux into them; for walls that absorb see ``absorbing``.
            "blocked": nothing through them.  "through": walls stop displacements only.  A
            mirror image has its agent's columns as they are (a vector is not reflected).
        absorbing: what walls that absorb take.  "agents": those that run into them, and they
            mirror nothing; diffusion that way has u = 0 at the wall to some per cent.  "mass":
            besides that, the mass of agents beside them as diffusion has it, with contributions
            "mirrored" with the opposite sign, so that u = 0 at the wall to the accuracy of the
            scheme (see `apmethod.move.obstacles.absorption`); then few agents run into them.
            None is "mass" in a `FieldModel`, whose agents carry a field, else "agents".
        squeezed: what to do about an agent that moving obstacles leave no place: "stop"
            fails the step and names it, "remove" takes it out and lists it in ``squeezed``.
        rule: how planes are chosen, one of ``RULES``.
        threshold, favour: see `apmethod.move.obstacles.tree.Rules`.

    Raises:
        ValueError: for something that is no obstacle, or an unknown choice.

    Attributes:
        tree: the kd-tree-domains' arrays.
        clearance: how far in front of walls agents are kept, a length.
        rebuilds: how often planes have followed obstacles and a domain has disappeared, so that
            its part of the tree was built again, and how often an obstacle has come or gone.
        absorbed: how many agents have been absorbed in all.
        absorbed_mass: the mass that walls have taken, of these agents and of others.
        squeezed: (time, agent's id, place, obstacle) of each agent that was removed.
    """

    def __init__(
        self,
        obstacles: Sequence[Obstacle],
        *,
        contributions: str = "mirrored",
        absorbing: str | None = None,
        squeezed: str = "stop",
        rule: str = "surface_area",
        threshold: float = Rules().threshold,
        favour: float = Rules().favour,
    ):
        for name, chosen, known in (
            ("contributions", contributions, CONTRIBUTIONS),
            ("absorbing", absorbing or "agents", ABSORBING),
            ("squeezed", squeezed, ("stop", "remove")),
            ("rule", rule, RULES),
        ):
            if chosen not in known:
                raise ValueError(f"{name} is {chosen!r}; it must be one of {', '.join(known)}")
        self.contributions = contributions
        self.absorbing = absorbing
        self.on_squeezed = squeezed
        self.absorbed = 0
        self.absorbed_mass = 0.0
        #: Mass that walls have taken of agents beside them in this step.
        self.taken_mass = 0.0
        #: Whether agents have been carried in this step that may have met something.
        self._met = False
        #: Whether all agents have arrived where nothing is near.
        self._clear = False
        self.squeezed: list[tuple[float, int, tuple[float, float], Obstacle]] = []
        self._particles: Particles | None = None
        rules = Rules(
            rule=RULES[rule],
            favour=finite_number("favour", favour, least=0.0),
            threshold=finite_number("threshold", threshold, least=0.0),
        )
        super().__init__(obstacles, rules)

    # -- coming and going --------------------------------------------------------------

    def add(self, obstacle: Obstacle) -> None:
        """Let an obstacle appear, between two steps.

        Raises:
            ValueError: if an agent is where it would be, naming the agents.
        """
        before, rebuilds = list(self._obstacles), self.rebuilds
        self._include([*before, obstacle])
        try:
            if self._particles is not None:
                self.check_positions(self._particles.array("position"), "agent in row")
        except ValueError:
            self._include(before)
            self.rebuilds = rebuilds
            raise

    def remove(self, obstacle: Obstacle) -> None:
        """Let an obstacle disappear, between two steps; agents that stick to it are free.

        Raises:
            ValueError: if it is not here.
        """
        if obstacle not in self._obstacles:
            raise ValueError(f"{obstacle!r} is not among the obstacles")
        number = self._obstacles.index(obstacle)
        self._include([other for other in self._obstacles if other is not obstacle])
        if self._particles is not None:
            held = self._particles.array("_held")
            held[held == number] = -1
            held[held > number] -= 1

    # -- in a model --------------------------------------------------------------------

    def attach(self, particles: Particles, domain: Domain) -> None:
        """Take a model's agents in: adds what they remember, and checks where they are put.

        Raises:
            ValueError: for obstacles that a periodic domain cannot have.
        """
        if self._particles is not None and self._particles is not particles:
            raise ValueError("these obstacles are another model's; make new ones for each model")
        self._particles, self._domain = particles, domain
        self._check_domain(self._obstacles)
        self._build()  # with the domain's borders
        self.rebuilds = 0
        particles.declare("_held", Column(dtype=np.int32, start=-1))
        for name, start in (("_domain", -1), ("_fate", -1), ("_tried", 0)):
            particles.declare(name, Column(dtype=np.int32, start=start, kept=False))
        particles.checks["position"] = self.check_positions

    # -- a step ------------------------------------------------------------------------

    def begin(self, time: float, dt: float) -> None:
        """Find where moving obstacles will go in a step."""
        self.time = time
        if self._met:
            self._particles.array("_fate")[:] = FREE
            self._particles.array("_tried")[:] = 0
            self._met = False
        self._clear = False
        self._place_movers(time + dt, dt)

    def carry(self, rows: np.ndarray, velocity: str, *, trial: bool, in_python: bool) -> None:
        """Carry agents from where the step began to where they want to be, as walls allow.

        Args:
            rows: of the agents.
            velocity: column that a wall changes as it does the displacement.
            trial: stop in front of the first wall, as places to perceive from do.
            in_python: run the lines in Python.
        """
        start, position = self._particles.array("_start"), self._particles.array("position")
        columns = start, position, self._particles.array(velocity)
        everybody = len(rows) == len(position)
        rows = self._who_may_meet(rows, start, position, in_python)
        self._clear = everybody and not len(rows)
        self._run(self._carry_all, rows, in_python, STOP if trial else BEHAVE, *columns)

    def sweep(self, velocity: str, *, in_python: bool = False) -> None:
        """Move the obstacles, while all agents rest."""
        if not self._moving or self._clear:
            return
        position = self._particles.array("position")
        rows = np.arange(len(position))
        rows = self._who_may_meet(rows, position, position, in_python)
        columns = position, self._particles.array(velocity)
        self._run(self._sweep_all, rows, in_python, self._movers, *columns)

    def _who_may_meet(
        self, rows: np.ndarray, start: np.ndarray, position: np.ndarray, in_python: bool
    ) -> np.ndarray:
        """Those of the rows whose agents may meet something between two places."""
        groups = -(-len(rows) // GROUP)
        may, boxes = np.empty(len(rows), np.bool_), np.empty((groups, 4))
        own = [self._particles.array(n) for n in ("_domain", "_held", "_fate")]
        limits, tree = self._domain.limits, self._tree
        while True:
            arguments = (groups, rows, tree, *limits, start, position, *own, may, boxes)
            if in_python:
                plain(who_may_meet)(0, *arguments)
            else:
                in_blocks(who_may_meet, *arguments, least=_GROUPS_A_BLOCK)
            known, tree = tree, self.tree_for(boxes)
            if tree is known:
                return rows[may]

    def _run(self, run, rows: np.ndarray, in_python: bool, how, *columns: np.ndarray) -> None:
        if not len(rows):
            return
        self._met = True
        along_x, along_y = self._domain.limits
        own = [self._particles.array(n) for n in ("_domain", "_held", "_fate", "_tried")]
        arguments = (
            rows, self.tree, self.walls, self.bodies, how, along_x, along_y, *columns, *own,
        )  # fmt: skip
        if in_python:
            plain(run)(0, len(rows), *arguments)
        else:
            in_blocks(run, len(rows), *arguments, least=RAYS_A_BLOCK)

    def put(self, agent: AgentParticle, x: float, y: float) -> tuple[float, float]:
        """Where an agent ends that is assigned (x, y): see `apmethod.agent.Position`.

        Raises:
            ValueError: for a place in an obstacle, between steps.
        """
        motion = agent.model.motion
        if motion.stage is None:
            x, y = self._domain.place(x, y)
            self.check_positions(np.array([[x, y]]), f"agent {agent.unique_id},")
            return x, y
        rows = np.array([agent.model.particles.row(agent)])
        start, position = (self._particles.array(n) for n in ("_start", "position"))
        begun, here = start[rows], position[rows]
        start[rows], position[rows] = here, (x, y)
        self.carry(rows, motion.reflected, trial=not motion.arrives, in_python=True)
        end = position[rows[0]].tolist()
        start[rows], position[rows] = begun, here
        return tuple(end)

    def _taken(self, which: np.ndarray, number: Callable) -> list[tuple[AgentParticle, Obstacle]]:
        rows = np.flatnonzero(which)
        if not len(rows):
            return []
        agents, fates = self._particles.agents, self._particles.array("_fate")
        return [(agents[row], self[number(fates[row])]) for row in rows]

    def end(self, time: float, step: int = 0) -> None:
        """The step is done: obstacles are where they were to go, and agents taken leave.

        Args:
            time: at the end of the step.
            step: its number, for the error.

        Raises:
            StepFailed: if an agent has been left no place, and that is to stop the run.
        """
        if self._met:
            self._take_out(time, step)
        self.absorbed_mass += self.taken_mass
        self._stand()
        self.time = time

    def _take_out(self, time: float, step: int) -> None:
        """Let agents leave that walls have absorbed or left no place."""
        squeezed = self._taken(self._particles.array("_fate") < FREE, lambda fate: -2 - fate)
        if squeezed and self.on_squeezed == "stop":
            agent, obstacle = squeezed[0]
            others = f" and {len(squeezed) - 1} more" if len(squeezed) > 1 else ""
            raise StepFailed(
                f"agent {agent.unique_id} ({type(agent).__name__}) at {agent.position.tolist()}"
                f"{others} is squeezed: {obstacle.name} leaves it no place to go to",
                step,
                self.time,
            )
        absorbed = self._taken(self._particles.array("_fate") > FREE, lambda fate: fate)
        for agent, obstacle in squeezed:
            self.squeezed.append((time, agent.unique_id, tuple(agent.position.tolist()), obstacle))
        for agent, obstacle in absorbed:
            obstacle.absorbed += 1
            self.absorbed_mass += agent.mass
        self.absorbed += len(absorbed)
        for agent, _ in absorbed + squeezed:
            agent.remove()

    @property
    def takes_mass(self) -> bool:
        """Whether walls take mass of agents beside them."""
        walls = any(obstacle.behaviour == "absorb" for obstacle in self._obstacles)
        return walls and self.absorbing == "mass" and self.contributions == "mirrored"

    @property
    def skipped(self) -> float:
        """The share of agents that tried no wall in the last step."""
        tried = self._particles.array("_tried")
        return float((tried == 0).mean()) if len(tried) else 1.0

    def diagnostics(self) -> dict[str, float]:
        """Numbers for one row of a series."""
        return {"absorbed": self.absorbed, "absorbed_mass": self.absorbed_mass}


def collected(obstacles: Obstacles | Sequence[Obstacle]) -> Obstacles:
    """A list of obstacles as `Obstacles`, if it is not that already."""
    return obstacles if isinstance(obstacles, Obstacles) else Obstacles(obstacles)
