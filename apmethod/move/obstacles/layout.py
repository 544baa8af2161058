"""Where obstacles stand and go: their walls by number, and the tree over them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from apmethod.move.obstacles.behaviour import BEHAVIOURS, OWN_FUNCTION
from apmethod.move.obstacles.carry import Bodies, carry_all_with
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
from apmethod.move.obstacles.rays import STILL, Walls
from apmethod.move.obstacles.shapes import Obstacle
from apmethod.move.obstacles.tree import Rules, Tree, build_tree
from apmethod.perceive.domain import PERIODIC, Domain

#: How far in front of walls agents are kept, as a share of the largest coordinate of one.
CLEARANCE = 1e-9
#: How far around a domain walls are listed in it, in clearances.
_MARGIN = 4.0


class Layout:
    """The walls of a list of obstacles, and the kd-tree-domains over them.

    Args:
        obstacles: polygons and thin walls.
        rules: what the tree is built by.

    Attributes:
        walls: of all obstacles, by number.
        bodies: what the obstacles do.
        tree: the kd-tree-domains' arrays.
        clearance: how far in front of walls agents are kept, a length.
        rebuilds: how often the tree has been built again: a domain has disappeared, or an
            obstacle has come or gone.
        time: at which the obstacles stand where they do.
    """

    def __init__(self, obstacles: Sequence[Obstacle], rules: Rules):
        self.rules = rules
        self.rebuilds = -1  # the first tree does not count
        self.time = 0.0
        self._domain = Domain()
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
            np.concatenate([np.zeros(0, np.int8), *(obstacle.free for obstacle in obstacles)]),
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
