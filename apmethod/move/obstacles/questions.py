"""What can be asked of obstacles: first hits, lines of sight, and what is near or inside."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from apmethod.compile import in_blocks
from apmethod.move.obstacles.layout import Layout
from apmethod.move.obstacles.outline import inside
from apmethod.move.obstacles.rays import BEFORE, RAYS_A_BLOCK, first_hits, near_walls, pairs_blocked
from apmethod.move.obstacles.shapes import Obstacle
from apmethod.move.obstacles.tree import LEAF


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


class Questions(Layout):
    """A layout that answers questions, as its obstacles stand now."""

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
            hits, tried, least=RAYS_A_BLOCK,
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
        in_blocks(
            pairs_blocked,
            len(pairs),
            self.tree,
            self.walls,
            positions,
            i,
            j,
            result,
            least=RAYS_A_BLOCK,
        )
        return result

    def near(self, points: np.ndarray, distance: float) -> np.ndarray:
        """Which points, (n, 2), have a wall at most ``distance`` away.

        For cells: their middles, with half their diagonal added to the distance.
        """
        result = np.empty(len(points), np.bool_)
        points = np.ascontiguousarray(points, float)
        in_blocks(near_walls, len(points), self.tree, self.walls, points, distance, result)
        return result

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
