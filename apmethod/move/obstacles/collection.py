"""The obstacles of a model: what agents meet, the tree over it, and what has happened."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from apmethod.checks import finite_number
from apmethod.compile import in_blocks, plain
from apmethod.move.obstacles.behaviour import BEHAVIOURS, OWN_FUNCTION
from apmethod.move.obstacles.carry import BEHAVE, FREE, STOP, Bodies, carry_all_with
from apmethod.move.obstacles.moving import (
    Movers,
    homes_of,
    movers_of,
    placed,
    poses_of,
    sweep_all_with,
    swept_bounds,
)
from apmethod.move.obstacles.planes import follow
from apmethod.move.obstacles.rays import (
    BEFORE,
    STILL,
    Walls,
    first_hits,
    near_walls,
    pairs_blocked,
)
from apmethod.move.obstacles.shapes import Obstacle, inside
from apmethod.move.obstacles.tree import LEAF, RULES, Rules, Tree, build_tree
from apmethod.particles import Column, Particles
from apmethod.perceive.domain import PERIODIC, Domain

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle

#: How far in front of walls agents are kept, as a share of the largest coordinate of one.
CLEARANCE = 1e-9
#: How far around a domain walls are listed in it, in clearances.
_MARGIN = 4.0


class KdDomain(NamedTuple):
    """A kd-tree-domain, as people look at it (paper 2.5.3).

    Attributes:
        number: by which agents remember it.
        limits: x_min, y_min, x_max, y_max of its plane limits; infinite at the outside.
        obstacles: those that have a wall in it.
        father: number of the domain that it was cut from, -1 for the whole plane.
        brother: number of the other part.
        beyond: number of the largest domain next to it west, south, east and north.
    """

    number: int
    limits: tuple[float, float, float, float]
    obstacles: tuple[Obstacle, ...]
    father: int
    brother: int
    beyond: tuple[int, int, int, int]


class Obstacles:
    """What a model's agents cannot pass.

    Args:
        obstacles: polygons and thin walls.
        squeezed: what to do about an agent that moving obstacles leave no place: "stop"
            fails the step and names it, "remove" takes it out and lists it in ``squeezed``.
        rule: how planes are chosen, one of ``RULES``.
        threshold, favour: see `apmethod.move.obstacles.tree.Rules`.

    Raises:
        ValueError: for something that is no obstacle, or an unknown rule.

    Attributes:
        tree: the kd-tree-domains' arrays.
        clearance: how far in front of walls agents are kept, a length.
        rebuilds: how often the tree has been built again: a domain has disappeared, or an
            obstacle has come or gone.
        absorbed: how many agents have been absorbed in all.
        squeezed: (time, agent's id, place, obstacle) of each agent that was removed.
    """

    def __init__(
        self,
        obstacles: Sequence[Obstacle],
        *,
        squeezed: str = "stop",
        rule: str = "surface_area",
        threshold: float = Rules().threshold,
        favour: float = Rules().favour,
    ):
        if squeezed not in ("stop", "remove"):
            raise ValueError(f"squeezed is {squeezed!r}; it must be 'stop' or 'remove'")
        if rule not in RULES:
            raise ValueError(f"rule is {rule!r}; it must be one of {', '.join(RULES)}")
        self.on_squeezed = squeezed
        self.rules = Rules(
            rule=RULES[rule],
            favour=finite_number("favour", favour, least=0.0),
            threshold=finite_number("threshold", threshold, least=0.0),
        )
        self.rebuilds = -1  # the first tree does not count
        self.absorbed = 0
        self.squeezed: list[tuple[float, int, tuple[float, float], Obstacle]] = []
        self.time = 0.0
        self._particles: Particles | None = None
        self._domain = Domain()
        self._obstacles: list[Obstacle] = []
        self._include(list(obstacles))

    def __len__(self) -> int:
        return len(self._obstacles)

    def __iter__(self) -> Iterator[Obstacle]:
        return iter(self._obstacles)

    def __getitem__(self, number: int) -> Obstacle:
        return self._obstacles[number]

    def __repr__(self) -> str:
        moving = len(self._moving)
        return f"{len(self)} obstacles, {moving} moving, {len(self._whole)} walls"

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

    def _include(self, obstacles: list[Obstacle]) -> None:
        """Number everything anew and build the tree."""
        for number, obstacle in enumerate(obstacles):
            if not isinstance(obstacle, Obstacle):
                raise ValueError(f"obstacle {number} is {obstacle!r}; it must be an Obstacle")
            if obstacle.name.startswith("a "):
                obstacle.name = f"{type(obstacle).__name__.lower()} {number}"
        self._check_domain(obstacles)
        self._obstacles = obstacles
        functions = tuple(dict.fromkeys(o.behaviour for o in obstacles if callable(o.behaviour)))
        codes = BEHAVIOURS | {f: OWN_FUNCTION + k for k, f in enumerate(functions)}
        self._carry_all, self._sweep_all = carry_all_with(functions), sweep_all_with(functions)
        counts = [len(obstacle.walls) for obstacle in obstacles]
        edges = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).astype(np.int32)
        self._slices = [slice(*edges[k : k + 2]) for k in range(len(obstacles))]
        self._moving = [number for number, obstacle in enumerate(obstacles) if obstacle.moves]
        total = int(edges[-1])
        self.walls = Walls(
            np.zeros((3, total, 4)),
            np.full(total, STILL, np.int32),
            np.repeat(np.arange(len(obstacles), dtype=np.int32), counts),
        )
        self._whole = np.zeros(total, np.bool_)
        for obstacle, numbers in zip(obstacles, self._slices, strict=True):
            self.walls.ends[:, numbers] = obstacle.walls
        for turn, number in enumerate(self._moving):
            numbers = self._slices[number]
            self.walls.turn[numbers] = turn
            self._whole[numbers] = True
            self.walls.ends[2, numbers] -= np.tile(obstacles[number].pivot, 2)
        scale = float(np.abs(self.walls.ends[0]).max(initial=0.0)) or 1.0
        self.clearance = CLEARANCE * scale
        self.bodies = Bodies(
            np.array([codes[o.behaviour] for o in obstacles], np.int8),
            np.zeros((len(obstacles), 5)),
            self.clearance,
        )
        margin = _MARGIN * self.clearance
        first, second = self.walls.ends[0, :, :2], self.walls.ends[0, :, 2:]
        self._bounds = np.concatenate(
            [np.minimum(first, second) - margin, np.maximum(first, second) + margin], axis=1
        )
        self._movers: Movers | None = None
        self._homes = homes_of([np.arange(total)[self._slices[k]] for k in self._moving])
        # Where moving obstacles stand, and where they go to in this step.
        self._poses: dict[Obstacle, np.ndarray] = {}
        self._next_poses: dict[Obstacle, np.ndarray] = {}
        self._place_movers(self.time, 0.0)
        self._stand()
        self._build()

    def _stand(self) -> None:
        """Moving obstacles are where they were to go."""
        if self._moving:
            self.walls.ends[0] = self.walls.ends[1]
            self._poses = dict(self._next_poses)

    def _build(self) -> None:
        self.tree = self.new_tree()
        self.rebuilds += 1

    def new_tree(self) -> Tree:
        """A tree built for the walls as they stand and move in this step."""
        root = np.array([0.0, 0.0, 1.0, 1.0])
        if len(self._bounds):
            low, high = self._bounds[:, :2].min(axis=0), self._bounds[:, 2:].max(axis=0)
            # As much room again on each side, so that the outside is cut off, and is empty.
            around, least = (high - low).max(), self.clearance
            borders = np.concatenate([self._domain.lower, self._domain.upper])
            root = np.concatenate([low - around, high + around])
            root = np.where(np.isfinite(borders), borders, root)
            root[:2], root[2:] = (
                np.minimum(root[:2], low - least),
                np.maximum(root[2:], high + least),
            )
        return build_tree(self.walls.ends[0], self._bounds, self._whole, root, self.rules)

    def moved_tree(self) -> Tree | None:
        """The tree with planes that have followed moving walls; None if a domain disappears."""
        least = 2.0 * self.clearance
        walls, moving = self.walls.ends[0], self._whole
        return follow(self.tree, walls, self._bounds, self._whole, moving, least)

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

    def _check_domain(self, obstacles: Sequence[Obstacle]) -> None:
        """Refuse what a domain with periodic sides cannot have."""
        for axis, kind in enumerate(self._domain.kinds):
            if kind != PERIODIC:
                continue
            low, high = self._domain.lower[axis], self._domain.upper[axis]
            for obstacle in obstacles:
                ends = obstacle.walls[:, axis::2]
                if obstacle.moves:
                    raise ValueError(
                        f"{obstacle.name} moves, and the domain is periodic along {'xy'[axis]}; "
                        "obstacles can move in open and bounded domains only"
                    )
                if not (ends.min() > low and ends.max() < high):
                    raise ValueError(
                        f"{obstacle.name} reaches the periodic sides of the domain, along "
                        f"{'xy'[axis]}; it must be between {low:g} and {high:g}"
                    )

    def check_positions(self, positions: np.ndarray, who: str = "agent") -> None:
        """Refuse positions, of shape (n, 2), outside the domain, in an obstacle or at its edge."""
        self._domain.check_positions(positions)
        result = self.near(positions, 0.5 * self.clearance)
        place = f"at the edge of an obstacle, less than {0.5 * self.clearance:.3g} away"
        for obstacle in self._obstacles:
            if not obstacle.solid or result.any():
                continue
            inner = self._inside(obstacle, positions)
            if inner.any():
                result, place = inner, f"inside {obstacle.name}"
        bad = np.flatnonzero(result)
        if len(bad):
            named = ", ".join(map(str, bad[:5].tolist())) + (", ..." if len(bad) > 5 else "")
            raise ValueError(
                f"position is {positions[bad[0]].tolist()} ({who} {named} of {len(positions)} "
                f"given), {place}; agents must be outside of obstacles"
            )

    def _inside(self, obstacle: Obstacle, positions: np.ndarray) -> np.ndarray:
        """Which positions are in a solid obstacle."""
        rings = self.outline(obstacle)
        low, high = rings[0].min(axis=0), rings[0].max(axis=0)
        result = ((positions >= low) & (positions <= high)).all(axis=1)
        near = np.flatnonzero(result)
        odd = np.zeros(len(near), np.bool_)
        for ring in rings:
            odd ^= inside(positions[near], ring)
        result[near] = odd
        return result

    # -- a step ------------------------------------------------------------------------

    def begin(self, time: float, dt: float) -> None:
        """Find where moving obstacles will go in a step, and let planes follow them."""
        self._particles.array("_fate")[:] = FREE
        self._particles.array("_tried")[:] = 0
        if not self._moving:
            return
        self._place_movers(time + dt, dt)
        moved = self.moved_tree()
        if moved is None:
            self._build()
        else:
            self.tree = moved

    def _place_movers(self, time: float, dt: float) -> None:
        """Ends, bounds and drift of the moving obstacles for a step of dt up to a time."""
        margin = _MARGIN * self.clearance
        poses = []
        for number in self._moving:
            obstacle, numbers = self._obstacles[number], self._slices[number]
            end = np.array(obstacle.pose(time))
            begin = self._poses.get(obstacle, end)
            self._next_poses[obstacle] = end
            pose = poses_of(obstacle.pivot, begin, end)
            own = self.walls.ends[2, numbers]
            ends = placed(own, pose)
            self.walls.ends[:2, numbers] = ends[[0, -1]]
            low_x, low_y, high_x, high_y = swept_bounds(ends, pose)
            self._bounds[numbers] = (
                low_x - margin, low_y - margin, high_x + margin, high_y + margin,
            )  # fmt: skip
            if dt > 0.0:
                self.bodies.drift[number, :3] = (end - begin) / dt
                self.bodies.drift[number, 3:] = pose[0, :2]
            poses.append(pose)
        if poses:
            self._movers = movers_of(poses, self._moving, self._homes, self.bodies)

    def carry(self, rows: np.ndarray, velocity: str, *, trial: bool, in_python: bool) -> None:
        """Carry agents from where the step began to where they want to be, as walls allow.

        Args:
            rows: of the agents.
            velocity: column that a wall changes as it does the displacement.
            trial: stop in front of the first wall, as places to perceive from do.
            in_python: run the lines in Python.
        """
        columns = [self._particles.array(n) for n in ("_start", "position", velocity)]
        self._run(self._carry_all, rows, in_python, STOP if trial else BEHAVE, *columns)

    def sweep(self, velocity: str, *, in_python: bool = False) -> None:
        """Move the obstacles, while all agents rest."""
        if not self._moving:
            return
        rows = np.arange(len(self._particles))
        columns = [self._particles.array(n) for n in ("position", velocity)]
        self._run(self._sweep_all, rows, in_python, self._movers, *columns)

    def _run(self, run, rows: np.ndarray, in_python: bool, how, *columns: np.ndarray) -> None:
        along_x, along_y = self._domain.limits
        own = [self._particles.array(n) for n in ("_domain", "_held", "_fate", "_tried")]
        arguments = (
            rows, self.tree, self.walls, self.bodies, how, along_x, along_y, *columns, *own,
        )  # fmt: skip
        if in_python:
            plain(run)(0, len(rows), *arguments)
        else:
            in_blocks(run, len(rows), *arguments)

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

    def squeezed_agents(self) -> list[tuple[AgentParticle, Obstacle]]:
        """Agents that the step has left no place, each with the obstacle that did it."""
        return self._taken(self._particles.array("_fate") < FREE, lambda fate: -2 - fate)

    def _taken(self, which: np.ndarray, number: Callable) -> list[tuple[AgentParticle, Obstacle]]:
        rows = np.flatnonzero(which)
        if not len(rows):
            return []
        agents, fates = self._particles.agents, self._particles.array("_fate")
        return [(agents[row], self[number(fates[row])]) for row in rows]

    def end(self, time: float) -> None:
        """The step is done: obstacles are where they were to go, and agents taken leave."""
        squeezed = self.squeezed_agents()
        absorbed = self._taken(self._particles.array("_fate") > FREE, lambda fate: fate)
        for agent, obstacle in squeezed:
            self.squeezed.append((time, agent.unique_id, tuple(agent.position.tolist()), obstacle))
        for _, obstacle in absorbed:
            obstacle.absorbed += 1
        self.absorbed += len(absorbed)
        for agent, _ in absorbed + squeezed:
            agent.remove()
        self._stand()
        self.time = time

    # -- questions ---------------------------------------------------------------------

    @property
    def skipped(self) -> float:
        """The share of agents that tried no wall in the last step."""
        tried = self._particles.array("_tried")
        return float((tried == 0).mean()) if len(tried) else 1.0

    def outline(self, obstacle: Obstacle) -> list[np.ndarray]:
        """An obstacle's chains of corners, each (n, 2), where they are now."""
        ends = self.walls.ends[0, self._slices[self._obstacles.index(obstacle)]]
        chains, first = [], 0
        for chain in obstacle.chains:
            last = first + len(chain) - 1
            chains.append(np.concatenate([ends[first:last, :2], ends[last - 1 : last, 2:]]))
            first = last
        return chains

    def first_hits(self, starts: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The first wall on each of many ways, ends included, as obstacles stand now.

        Args:
            starts: (n, 2).
            ends: (n, 2).

        Returns:
            (share of the way, above 1 where nothing is met; number of the wall, or -1).
        """
        starts, ends = np.ascontiguousarray(starts, float), np.ascontiguousarray(ends, float)
        shares, hits = np.empty(len(starts)), np.empty(len(starts), np.int32)
        domains, tried = np.full(len(starts), -1, np.int32), np.empty(len(starts), np.int32)
        in_blocks(
            first_hits, len(starts), self.tree, self.walls, BEFORE, starts, ends, domains, shares,
            hits, tried,
        )  # fmt: skip
        return shares, hits

    def occupied(self, positions: np.ndarray) -> np.ndarray:
        """Which positions, (n, 2), no agent can have: in an obstacle or at its edge."""
        result = self.near(positions, 0.5 * self.clearance)
        for obstacle in self._obstacles:
            if obstacle.solid:
                result |= self._inside(obstacle, positions)
        return result

    def blocked(self, positions: np.ndarray, pairs: np.ndarray) -> np.ndarray:
        """Which pairs, (m, 2) rows of positions (n, 2), have a wall in their line of sight."""
        result = np.empty(len(pairs), np.bool_)
        i, j = np.ascontiguousarray(pairs.T)
        in_blocks(pairs_blocked, len(pairs), self.tree, self.walls, positions, i, j, result)
        return result

    def near(self, points: np.ndarray, distance: float) -> np.ndarray:
        """Which points, (n, 2), have a wall at most ``distance`` away.

        For cells: their middles, with half their diagonal added to the distance.
        """
        result = np.empty(len(points), np.bool_)
        points = np.ascontiguousarray(points, float)
        in_blocks(near_walls, len(points), self.tree, self.walls, points, distance, result)
        return result

    def domains(self) -> list[KdDomain]:
        """The kd-tree-domains that have not been cut further, with family and neighbours."""
        tree = self.tree
        found = []
        for number in np.flatnonzero(tree.axis == LEAF).tolist():
            father = int(tree.father[number])
            sons = tree.sons[father].tolist() if father >= 0 else [-1, number]
            listed = tree.listed[tree.first[number] : tree.last[number]]
            owners = np.unique(self.walls.obstacle[listed]).tolist()
            found.append(
                KdDomain(
                    number,
                    tuple(tree.limits[number].tolist()),
                    tuple(self[owner] for owner in owners),
                    father,
                    sons[0] if sons[1] == number else sons[1],
                    tuple(tree.beyond[number].tolist()),
                )
            )
        return found
