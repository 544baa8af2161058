"""Pictures of a run, drawn by matplotlib without a screen."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from apmethod.model import ParticleModel
    from apmethod.run.runner import Run
    from apmethod.skills.signal import SignalField


def draw_run(run: Run, title: str, path: Path) -> None:
    """Draw start, end and, where it is known, the exact solution and the error."""
    figure = Figure()  # placed by hand: a layout engine draws everything twice
    FigureCanvasAgg(figure)
    signals = [skill for skill in run.model.skills if hasattr(skill, "patches")]
    if hasattr(run.model, "field"):
        _draw_field(figure, run)
    elif signals:
        _draw_signals(figure, run.model, signals)
    else:
        _draw_agents(figure, run)
    model = run.model
    figure.suptitle(f"{title}: {len(model.particles)} agents, {model.steps} steps")
    figure.savefig(path, dpi=110)


def _draw_field(figure: Figure, run: Run) -> None:
    model = run.model
    x, y = model.grid()
    start, exact = model.exact(x, y, 0.0), model.exact(x, y, model.elapsed)
    end = model.field(x, y)
    top = max(values.max() for values in (end, exact) if values is not None)
    panels = [(f"end, t = {model.elapsed:.4g}", end, (0.0, top), "viridis")]
    if exact is not None:
        off = end - exact
        most = np.abs(off).max() or 1.0
        panels = [
            ("start", start, (0.0, start.max()), "viridis"),
            *panels,
            ("exact", exact, (0.0, top), "viridis"),
            ("end - exact", off, (-most, most), "RdBu_r"),
        ]
    figure.set_size_inches(4.2 * len(panels), 4.0)
    figure.subplots_adjust(left=0.03, right=0.98, bottom=0.08, top=0.84, wspace=0.12)
    axes = figure.subplots(1, len(panels), squeeze=False)[0]
    for ax, (name, values, (low, high), colours) in zip(axes, panels, strict=True):
        image = ax.imshow(
            values, origin="lower", extent=model.box, cmap=colours, vmin=low, vmax=high
        )
        if values is end:
            draw_agents(ax, model.particles.position)
            ax.axis(model.box)
        ax.set_title(name)
        figure.colorbar(image, ax=ax, shrink=0.8)


def _draw_signals(figure: Figure, model: ParticleModel, signals: list[SignalField]) -> None:
    """Agents and signals side by side, as in the paper's Figure 9."""
    from apmethod.view.animals import draw_animals, draw_signal

    figure.set_size_inches(4.7 * (1 + len(signals)), 4.6)
    figure.subplots_adjust(left=0.05, right=0.93, bottom=0.08, top=0.86)
    axes = figure.subplots(1, 1 + len(signals))
    draw_animals(axes[0], model)
    axes[0].set_title(f"t = {model.elapsed:.4g}")
    for ax, signal in zip(axes[1:], signals, strict=True):
        image = draw_signal(ax, signal)
        figure.colorbar(image, cax=ax.inset_axes((1.04, 0.0, 0.04, 1.0)))
        ax.set_title(signal.name)


def _draw_agents(figure: Figure, run: Run) -> None:
    figure.set_size_inches(9, 4.8)
    figure.subplots_adjust(left=0.07, right=0.98, bottom=0.08, top=0.86)
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    position = run.model.particles.position
    for ax, name, places in zip(axes, ("start", "end"), (run.start, position), strict=True):
        if run.model.obstacles is not None:
            _draw_surroundings(ax, run.model, at_end=name == "end")
        draw_agents(ax, places)
        ax.set_aspect("equal")
        ax.set_title(name)


def _draw_surroundings(ax: Axes, model: ParticleModel, at_end: bool) -> None:
    """Obstacles, and at the end the moving ones and the kd-tree-domains too."""
    from apmethod.view.obstacles import draw_domains, draw_obstacles

    box = getattr(model, "box", None) or model.space.bounds
    if at_end:
        draw_domains(ax, model.obstacles, box)
    draw_obstacles(ax, model.obstacles, moving=at_end)
    ax.set(xlim=box[:2], ylim=box[2:])


def draw_agents(ax: Axes, positions: np.ndarray) -> None:
    """Draw agents as dots that thin out as they become many."""
    size = float(np.clip(4000.0 / max(len(positions), 1), 0.05, 8.0))
    ax.scatter(*positions.T, s=size, c="black", alpha=0.35, linewidths=0)
