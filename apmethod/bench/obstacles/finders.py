"""Who finds the first walls: kd-tree-domains, every wall tried, shapely and Embree."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from apmethod import Obstacles
from apmethod.compile import in_blocks
from apmethod.move.obstacles.rays import BEFORE, RAYS_A_BLOCK, brute_force_hits, first_hits

#: First hits of rays: the wall of each, or -1.
Finder = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Ours:
    """kd-tree-domains; a ray starts in the domain that it started in before."""

    def __init__(self, obstacles: Obstacles, count: int):
        self.obstacles = obstacles
        self.domains = np.full(count, -1, np.int32)
        self.shares, self.tried = np.empty(count), np.empty(count, np.int32)

    def __call__(self, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """The first walls."""
        hits = np.empty(len(starts), np.int32)
        tree, walls = self.obstacles.tree, self.obstacles.walls
        in_blocks(
            first_hits, len(starts), tree, walls, BEFORE, starts, ends, self.domains, self.shares,
            hits, self.tried, least=RAYS_A_BLOCK,
        )  # fmt: skip
        return hits


def try_all(obstacles: Obstacles, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """The first walls, by trying all, on all threads."""
    shares, hits = np.empty(len(starts)), np.empty(len(starts), np.int32)
    in_blocks(
        brute_force_hits, len(starts), obstacles.walls, BEFORE, starts, ends, shares, hits,
        least=500,
    )  # fmt: skip
    return hits


def shapely_finder(walls: np.ndarray) -> Finder | None:
    """shapely's STRtree over the walls, (n, 4); None if it is not installed."""
    try:
        import shapely
    except ImportError:
        return None
    segments = shapely.linestrings(walls.reshape(-1, 2, 2))
    tree = shapely.STRtree(segments)

    def find(starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
        lines = shapely.linestrings(np.stack([starts, ends], axis=1))
        ray, wall = tree.query(lines, predicate="intersects")
        a, b = walls[wall, :2], walls[wall, 2:]
        p, q = starts[ray], ends[ray]
        along = b - a
        sides = [along[:, 0] * (end - a)[:, 1] - along[:, 1] * (end - a)[:, 0] for end in (p, q)]
        order = np.lexsort((wall, sides[0] / (sides[0] - sides[1]), ray))
        ray, wall = ray[order], wall[order]
        hits = np.full(len(starts), -1, np.int32)
        first = np.concatenate([[True], ray[1:] != ray[:-1]]) if len(ray) else []
        hits[ray[first]] = wall[first]
        return hits

    return find


def embree_finder(walls: np.ndarray) -> Finder | None:
    """Embree, the walls standing up in space; None if embreex is not installed."""
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError:
        return None
    a, b = walls[:, :2], walls[:, 2:]

    def at(points: np.ndarray, height: float) -> np.ndarray:
        return np.column_stack([points, np.full(len(points), height)])

    below, above = (at(a, -1.0), at(b, -1.0)), (at(a, 1.0), at(b, 1.0))
    triangles = np.stack([below[0], below[1], above[1], below[0], above[1], above[0]], axis=1)
    scene = EmbreeScene()
    TriangleMesh(scene, np.ascontiguousarray(triangles.reshape(-1, 3, 3), np.float32))

    def find(starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
        origins = at(starts, 0.0).astype(np.float32)
        ways = at(ends - starts, 0.0).astype(np.float32)
        limits = np.ones(len(starts), np.float32)
        return scene.run(origins, ways, dists=limits, query="INTERSECT") // 2

    return find
