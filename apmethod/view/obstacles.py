"""Obstacles and kd-tree-domains, drawn by matplotlib (the paper's Figures 5, 6 and 8)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from apmethod.move.obstacles.collection import Obstacles


def draw_obstacles(ax: Axes, obstacles: Obstacles, *, moving: bool = True) -> None:
    """Draw solid obstacles filled, with their holes free, and thin walls as lines.

    Args:
        ax: where to draw.
        obstacles: as they stand now.
        moving: whether to draw those that move, too.
    """
    for obstacle in obstacles:
        if obstacle.moves and not moving:
            continue
        chains = obstacles.outline(obstacle)
        path = Path.make_compound_path(*(Path(chain) for chain in chains))
        face = "#b9a78c" if obstacle.solid else "none"
        ax.add_patch(PathPatch(path, facecolor=face, edgecolor="#5d4f3a", linewidth=1.0))


def draw_domains(ax: Axes, obstacles: Obstacles, box: Sequence[float]) -> None:
    """Draw the kd-tree-domains in a box (x_min, x_max, y_min, y_max), empty ones tinted."""
    x_min, x_max, y_min, y_max = box
    for domain in obstacles.domains():
        low = np.maximum(domain.limits[:2], (x_min, y_min))
        width, height = np.minimum(domain.limits[2:], (x_max, y_max)) - low
        if width > 0.0 and height > 0.0:
            face = "none" if domain.obstacles else "#eaf2e3"
            ax.add_patch(
                Rectangle(low, width, height, facecolor=face, edgecolor="#7a9a68", linewidth=0.5)
            )
