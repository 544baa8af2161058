"""Drawing a signal, groups and trajectories on axes of matplotlib (paper Figures 9 and 10)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

    from apmethod.model import ParticleModel
    from apmethod.skills.groups import Groups
    from apmethod.skills.life import Trajectories
    from apmethod.skills.signal import SignalField


def draw_signal(ax: Axes, signal: SignalField) -> AxesImage:
    """Draw a signal, a square for each patch."""
    return ax.imshow(
        signal.values.T, origin="lower", extent=signal.patches.extent, cmap="magma_r", vmin=0.0
    )


def draw_groups(ax: Axes, groups: Groups) -> None:
    """Draw the groups' outlines: the convex hulls of their members."""
    from scipy.spatial import ConvexHull, QhullError

    position, member = groups.column("position"), groups.column("group")
    for group in groups.current:
        centre = np.array([group.x, group.y])
        apart = position[member == group.identity] - centre
        for axis, period in enumerate(groups.model.space.domain.periods):
            if period:
                apart[:, axis] -= period * np.round(apart[:, axis] / period)
        try:
            corners = apart[ConvexHull(apart).vertices]
        except QhullError:  # members on one line or point have no outline
            continue
        ax.fill(*(centre + corners).T, fill=False, edgecolor="tab:red", linewidth=1.0)


def draw_paths(ax: Axes, trajectories: Trajectories) -> None:
    """Draw trajectories; a line ends where its agent crosses a periodic side."""
    periods = np.array(trajectories.model.space.domain.periods)
    for path in trajectories.paths.values():
        places = np.array(path)
        steps = np.abs(np.diff(places, axis=0))
        jumps = ((periods > 0.0) & (steps > 0.5 * periods)).any(axis=1)
        for part in np.split(places, np.flatnonzero(jumps) + 1):
            ax.plot(*part.T, linewidth=0.5, color="tab:blue", alpha=0.7)


def draw_animals(ax: Axes, model: ParticleModel) -> None:
    """Draw the agents, with the outlines of their groups and the trajectories on record."""
    from apmethod.skills.groups import Groups
    from apmethod.skills.life import Trajectories
    from apmethod.view.picture import draw_agents

    draw_agents(ax, model.particles.position)
    for skill in model.skills:
        if isinstance(skill, Groups):
            draw_groups(ax, skill)
        elif isinstance(skill, Trajectories):
            draw_paths(ax, skill)
    x_min, x_max, y_min, y_max = model.space.bounds
    ax.set(xlim=(x_min, x_max), ylim=(y_min, y_max), aspect="equal")
