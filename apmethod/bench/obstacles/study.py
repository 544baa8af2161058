"""First walls on agents' displacements: kd-tree-domains against peers (paper 2.5).

Octagons all over the unit square cover some 18 % of it, whatever their number.  Short rays
are as long as an agent's step, a quarter of an octagon's radius; long ones go from anywhere
to anywhere.  Every contender is given coordinates and must tell the first wall on each ray.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from apmethod import AgentParticle, Obstacles, ParticleModel, disc
from apmethod.bench.results import Disagreement, machine
from apmethod.bench.timing import Progress, Report, Times, alternate, stopwatch
from apmethod.compile import in_blocks
from apmethod.move.obstacles.rays import BEFORE, brute_force_hits, first_hits

#: Numbers of walls, eight to an octagon.
SIZES = (104, 1000, 8000, 100_000)
RAYS = 100_000
_CORNERS = 8
#: Every wall is tried for so many rays, to check all others and to be timed.
_TRIED = 2000

#: First hits of rays: the wall of each, or -1.
Finder = Callable[[np.ndarray, np.ndarray], np.ndarray]


def octagons(walls: int, seed: int, speed: float = 0.0) -> list:
    """So many walls of octagons; the one with most room around it may move.

    Args:
        walls: eight to an octagon.
        seed: of places.
        speed: of the one that moves, in radii.
    """
    count = max(1, walls // _CORNERS)
    places = np.random.default_rng(seed).random((count, 2))
    radius = 0.25 / np.sqrt(count)
    nearest, _ = cKDTree(places).query(places, k=2)
    freest = int(nearest[:, 1].argmax())
    return [
        disc(place, radius, corners=_CORNERS, velocity=(speed * radius * (number == freest), 0.0))
        for number, place in enumerate(places)
    ]


def rays(walls: int, count: int, length: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Starts and ends of "short" or "long" rays, each (count, 2)."""
    draw = np.random.default_rng(seed + 1)
    starts = draw.random((count, 2))
    if length == "long":
        return starts, draw.random((count, 2))
    step = 0.25 * 0.25 / np.sqrt(max(1, walls // _CORNERS))
    angles = draw.uniform(0.0, 2.0 * np.pi, count)
    return starts, starts + step * np.column_stack([np.cos(angles), np.sin(angles)])


def study(
    sizes: Sequence[int] = SIZES,
    rounds: int = 7,
    count: int = RAYS,
    seed: int = 0,
    report: Report | None = None,
) -> dict[str, Any]:
    """Check and time all contenders that are installed.

    Args:
        sizes: numbers of walls.
        rounds: runs of each contender.
        count: rays a run.
        seed: of places.
        report: called with the share done and the rounds made.

    Raises:
        Disagreement: if ours finds another first wall than trying all of them, on any ray,
            or a peer does on more than one ray in a thousand (Embree rounds to single).
    """
    progress = Progress(report, [count for _ in sizes for _ in range(2 * rounds)])
    rows, moving = [], []
    for size in sizes:
        for length in ("short", "long"):
            rows += _at_size(size, length, rounds, count, seed, progress)
        moving.append(_moving(size, rounds, seed))
    return {
        "benchmark": "obstacles",
        "machine": machine(),
        "settings": {"sizes": list(sizes), "rounds": rounds, "rays": count, "seed": seed},
        "checked": f"the first walls on {_TRIED} rays at each size are those found by trying "
        "all walls, and of all rays the same by every tree",
        "rows": rows,
        "moving": moving,
    }


# -- contenders ------------------------------------------------------------------------


class Ours:
    """kd-tree-domains; a ray starts in the domain that it started in before."""

    def __init__(self, walls: int, seed: int, rule: str, count: int):
        self.obstacles = Obstacles(octagons(walls, seed), rule=rule)
        self.domains = np.full(count, -1, np.int32)
        self.shares, self.tried = np.empty(count), np.empty(count, np.int32)

    def __call__(self, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """The first walls."""
        hits = np.empty(len(starts), np.int32)
        tree, walls = self.obstacles.tree, self.obstacles.walls
        in_blocks(
            first_hits, len(starts), tree, walls, BEFORE, starts, ends, self.domains, self.shares,
            hits, self.tried,
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


# -- measuring -------------------------------------------------------------------------


def _at_size(
    size: int, length: str, rounds: int, count: int, seed: int, progress: Progress
) -> list[dict[str, Any]]:
    starts, ends = rays(size, count, length, seed)
    ours = {
        "surface area": Ours(size, seed, "surface_area", count),
        "median split": Ours(size, seed, "median", count),
    }
    obstacles = ours["surface area"].obstacles
    walls = obstacles.walls.ends[0]
    finders: dict[str, Finder | None] = {
        **ours,
        "shapely STRtree": shapely_finder(walls),
        "Embree": embree_finder(walls),
    }
    expected = ours["surface area"](starts, ends)
    if (expected[:_TRIED] != try_all(obstacles, starts[:_TRIED], ends[:_TRIED])).any():
        raise Disagreement(f"{size} walls, {length} rays: not the walls found by trying all")
    differing = {}
    for name, finder in finders.items():
        if finder is not None:
            differing[name] = int((finder(starts, ends) != expected).sum())
            if differing[name] > (0 if name in ours else 1e-3 * count):
                raise Disagreement(f"{name}: {differing[name]} other first walls than ours")
    contenders = {
        name: partial(stopwatch, partial(finder, starts, ends))
        for name, finder in finders.items()
        if finder is not None
    }
    part = min(count, _TRIED)
    brute = partial(try_all, obstacles, starts[:part], ends[:part])
    contenders["no tree"] = lambda: stopwatch(brute) * count / part
    times = alternate(contenders, rounds, after=lambda: progress.made(count))
    least = times["surface area"].median
    return [
        _row(size, length, name, found, count, least)
        | {
            "other_hits": differing.get(name, 0),
            "skipped": float((ours[name].tried == 0).mean()) if name in ours else None,
            "walls_tried": float(ours[name].tried.mean()) if name in ours else None,
        }
        for name, found in times.items()
    ]


def _row(
    size: int, length: str, name: str, times: Times, count: int, least: float
) -> dict[str, Any]:
    return {
        "walls": size,
        "rays": length,
        "contender": name,
        "median_seconds": times.median,
        "minimum_seconds": times.minimum,
        "rays_per_second": count / times.median,
        "times_ours": times.median / least,
    }


def _moving(size: int, rounds: int, seed: int) -> dict[str, Any]:
    """One octagon moves a tenth of its radius a step: planes that follow, or a new tree."""
    obstacles = Obstacles(octagons(size, seed, speed=0.1))
    ParticleModel(AgentParticle, core_radius=0.1, dt=1.0, obstacles=obstacles)
    seconds: dict[str, list[float]] = {"follow": [], "build": []}
    steps = 4 * rounds
    for step in range(steps):
        before = obstacles.tree
        obstacles.begin(float(step), 1.0)
        after, obstacles.tree = obstacles.tree, before
        seconds["follow"].append(stopwatch(obstacles.moved_tree))
        seconds["build"].append(stopwatch(obstacles.new_tree))
        obstacles.tree = after
        obstacles.end(step + 1.0)
    follow, build = (Times(tuple(values)) for values in seconds.values())
    return {
        "walls": size,
        "follow_seconds": follow.median,
        "build_seconds": build.median,
        "follow_over_build": follow.median / build.median,
        "steps": steps,
        "rebuilds": obstacles.rebuilds,
    }
