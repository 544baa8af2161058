"""Where obstacles stand and go: their walls by number, and the tree over them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from apmethod.move.obstacles.behaviour import BEHAVIOURS, OWN_FUNCTION
from apmethod.move.obstacles.carry import Bodies, carry_all_with
from apmethod.move.obstacles.clear import apart, box_clear
from apmethod.move.obstacles.cutting import build_tree
from apmethod.move.obstacles.moving import Movers, movers_of, place_all, sweep_all_with
from apmethod.move.obstacles.planes import follow
from apmethod.move.obstacles.rays import STILL, Walls
from apmethod.move.obstacles.shapes import Obstacle
from apmethod.move.obstacles.tree import Rules, Tree, leaves_of
from apmethod.perceive.domain import PERIODIC, Domain

#: How far in front of walls agents are kept, as a share of the largest coordinate of one.
CLEARANCE = 1e-9
#: How far around a domain walls are listed in it, in clearances.
_MARGIN = 4.0
#: How wide a domain is at least, in clearances.
_LEAST = 2.0


class Layout:
    """The walls of a list of obstacles, and the kd-tree-domains over them.

    Args:
        obstacles: polygons and thin walls.
        rules: what the tree is built by.

    Attributes:
        walls: of all obstacles, by number.
        bodies: what the obstacles do.
        clearance: how far in front of walls agents are kept, a length.
        rebuilds: how often planes have followed obstacles and a domain has disappeared, so that
            its part of the tree was built again, and how often an obstacle has come or gone.
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
        self._firsts = edges[self._moving]
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
        #: Whether obstacles have moved and planes have not followed them yet.
        self._behind = False
        self._homes = leaves_of([np.arange(total)[self._slices[k]] for k in self._moving])
        movers = [obstacles[k] for k in self._moving]
        self._pivots = np.array([each.pivot for each in movers])
        self._rates = np.array([(*each.velocity, each.spin) for each in movers])
        self._on_paths = [k for k, each in enumerate(movers) if each.path is not None]
        # The poses in which they stand, and those to which they go in this step.
        self._stand_at = self._go_to = np.empty((0, 3))
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
        if not self._moving:
            return
        end = self._rates * time
        for mover in self._on_paths:
            end[mover] = self._obstacles[self._moving[mover]].pose(time)
        begin = self._stand_at if dt > 0.0 else end
        self._movers = movers_of(begin, end, self._moving, self._homes, self.bodies)
        margin = _MARGIN * self.clearance
        place_all(self._movers, begin, end, self._pivots, self.walls.ends, self._bounds, margin)
        self._go_to = end
        self._behind = True
        if dt > 0.0:
            self.bodies.drift[self._moving, :3] = (end - begin) / dt
            self.bodies.drift[self._moving, 3:] = self._movers.poses[:, 0, :2]

    def _stand(self) -> None:
        """Moving obstacles are where they were to go."""
        if self._moving:
            self.walls.ends[0] = self.walls.ends[1]
            self._stand_at = self._go_to

    def _build(self) -> None:
        self._tree = self.new_tree()
        self._behind = False
        self.rebuilds += 1

    @property
    def tree(self) -> Tree:
        """The kd-tree-domains' arrays, for walls as they stand and move in this step."""
        if self._behind:
            self._tree, parts = self.moved_tree()
            self._behind = False
            self.rebuilds += parts > 0
        return self._tree

    def tree_for(self, boxes: np.ndarray) -> Tree:
        """One that is as good as ``tree`` inside the box around some boxes, (n, 4).

        Planes follow obstacles when somebody is near one of them: until then walls that move
        are listed where they were, and all others where they are.
        """
        if self._behind and apart(boxes, self._bounds[self._firsts]):
            return self._tree
        return self.tree

    def clear_of(self, west: float, south: float, east: float, north: float) -> bool:
        """Whether no wall is in any domain that a box touches."""
        box = west, south, east, north
        return box_clear(self.tree_for(np.array([box])) if self._behind else self._tree, *box)

    def new_tree(self) -> Tree:
        """A tree built for the walls as they stand and move in this step."""
        walls, whole = self.walls.ends[0], self._whole
        return build_tree(walls, self._bounds, whole, self._root(), self._rules())

    def moved_tree(self) -> tuple[Tree, int]:
        """The tree with planes that have followed moving walls, and how many parts are new."""
        walls, moving = self.walls.ends[0], self._whole
        return follow(
            self._tree, walls, self._bounds, self._whole, moving, self._root, self._rules()
        )

    def _rules(self) -> Rules:
        return self.rules._replace(least=_LEAST * self.clearance)

    def _root(self) -> np.ndarray:
        """The box, (4,), in which areas count."""
        if not len(self._bounds):
            return np.array([0.0, 0.0, 1.0, 1.0])
        low, high = self._bounds[:, :2].min(axis=0), self._bounds[:, 2:].max(axis=0)
        # As much room again on each side, so that the outside is cut off, and is empty.
        around, least = (high - low).max(), self.clearance
        borders = np.concatenate([self._domain.lower, self._domain.upper])
        root = np.concatenate([low - around, high + around])
        root = np.where(np.isfinite(borders), borders, root)
        root[:2], root[2:] = np.minimum(root[:2], low - least), np.maximum(root[2:], high + least)
        return root
