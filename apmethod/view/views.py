"""Views of a scene for its browser page, drawn from the agents' columns.

A view is a Solara component that takes the model and is drawn anew after each step.  The
views here read whole columns: an agent costs a dot, and no call of Python.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import solara
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mesa.visualization.utils import update_counter

from apmethod.field.model import FieldModel
from apmethod.skills.signal import SignalField
from apmethod.view.animals import draw_animals, draw_signal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from apmethod.model import ParticleModel

    View = Callable[[ParticleModel], solara.Element]

#: Equal columns, so that numbers stay in their places when they change.
_GRID = {
    "display": "grid",
    "gap": "8px",
    "grid-template-columns": "repeat(auto-fill, minmax(90px, 1fr))",
}


def default_views(model: ParticleModel, column: str | None = None) -> list[View]:
    """The agents, and beside them what else there is to see, above the diagnostics.

    That is the field of a `FieldModel`, a signal, or the kd-tree-domains of obstacles.

    Args:
        model: a model of the scene.
        column: what the agents are coloured by: a column with one number an agent.  By
            default their mass; animals, which have all the same, have one colour.
    """
    if any(isinstance(skill, SignalField) for skill in model.skills):
        return [animals_view(column), stacked(signal_view(), diagnostics_view())]
    agents = agents_view(column or "mass")
    if isinstance(model, FieldModel):
        return [agents, stacked(field_view(), diagnostics_view())]
    if model.obstacles is not None:
        return [agents, stacked(domains_view(), diagnostics_view())]
    return [agents, diagnostics_view()]


def agents_view(column: str = "mass") -> View:
    """A view of the agents where they are, coloured by a column.

    Args:
        column: name of a column with one number an agent.
    """

    def draw(model: ParticleModel) -> Figure:
        figure, (ax,), bar = _panels(f"agents, by {column}")
        if model.obstacles is not None:
            from apmethod.view.obstacles import draw_obstacles

            draw_obstacles(ax, model.obstacles)
        area = 20_000.0 / max(len(model.particles), 1)
        dots = ax.scatter(
            *model.particles.position.T,
            c=getattr(model.particles, column),
            s=np.clip(area, 0.5, 30.0),
            linewidths=0,
        )
        x_min, x_max, y_min, y_max = _frame(model)
        ax.set(xlim=(x_min, x_max), ylim=(y_min, y_max), aspect="equal")
        figure.colorbar(dots, cax=bar, ticks=_few_ticks())
        return figure

    return figure_view(draw)


def domains_view() -> View:
    """A view of the obstacles and their kd-tree-domains (the paper's Figures 5 and 6)."""
    from apmethod.view.obstacles import draw_domains, draw_obstacles

    def draw(model: ParticleModel) -> Figure:
        figure, (ax,), bar = _panels("kd-tree-domains; empty ones tinted")
        bar.remove()
        box = _frame(model)
        draw_domains(ax, model.obstacles, box)
        draw_obstacles(ax, model.obstacles)
        ax.set(xlim=box[:2], ylim=box[2:], aspect="equal")
        return figure

    return figure_view(draw)


def field_view() -> View:
    """A view of a `FieldModel`'s field, beside the exact solution where it is known."""

    def draw(model: FieldModel) -> Figure:
        x, y = model.grid()
        field = model.field(x, y)
        exact = model.exact(x, y, model.elapsed)
        fields = {"field": field} if exact is None else {"field": field, "exact": exact}
        top = max(values.max() for values in fields.values())
        figure, axes, bar = _panels(*fields)
        for ax, values in zip(axes, fields.values(), strict=True):
            image = ax.imshow(values, origin="lower", extent=model.box, vmin=0.0, vmax=top)
        figure.colorbar(image, cax=bar, ticks=_few_ticks())
        return figure

    return figure_view(draw)


def animals_view(column: str | None = None) -> View:
    """A view of the agents with the outlines of their groups.

    Args:
        column: name of a column with one number an agent, to colour them by.
    """

    def draw(model: ParticleModel) -> Figure:
        figure, (ax,), bar = _panels("agents" if column is None else f"agents, by {column}")
        draw_animals(ax, model)
        if column is None:
            bar.set_axis_off()
        else:
            dots = ax.collections[0]
            dots.set(array=getattr(model.particles, column), alpha=1.0)
            figure.colorbar(dots, cax=bar, ticks=_few_ticks())
        return figure

    return figure_view(draw)


def signal_view(number: int = 0) -> View:
    """A view of a signal.

    Args:
        number: which of the scene's signals.
    """

    def draw(model: ParticleModel) -> Figure:
        signal = [skill for skill in model.skills if isinstance(skill, SignalField)][number]
        figure, (ax,), bar = _panels(signal.name)
        figure.colorbar(draw_signal(ax, signal), cax=bar, ticks=_few_ticks())
        return figure

    return figure_view(draw)


def figure_view(draw: Callable[[Any], Figure]) -> View:
    """A view that shows a matplotlib figure.

    Args:
        draw: makes the figure of a model as it stands.  It must not use pyplot, which
            keeps every figure and is not made for the threads that a page runs in.
    """

    @solara.component
    def FigureView(model):
        update_counter.get()  # draws again after each step
        solara.FigureMatplotlib(draw(model), format="png")

    return FigureView


def diagnostics_view() -> View:
    """A view of the model's diagnostics, and of its errors where the solution is known."""

    @solara.component
    def DiagnosticsView(model):
        update_counter.get()
        numbers = model.diagnostics() | getattr(model, "errors", dict)()
        with solara.Div(style=_GRID):
            for name, value in numbers.items():
                with solara.Column(gap="0px"):
                    solara.Text(name.replace("_", " "), style={"opacity": "0.6"})
                    solara.Text(str(value) if isinstance(value, int) else f"{value:.4g}")

    return DiagnosticsView


def stacked(*views: View) -> View:
    """Several views in one place of the page, one below the other."""

    @solara.component
    def Stacked(model):
        solara.Column(children=[view(model) for view in views])

    return Stacked


# -- drawing ---------------------------------------------------------------------------


def _panels(*titles: str) -> tuple[Figure, list[Axes], Axes]:
    """A figure of square panels side by side, and a place for a colour bar beside them.

    They are placed by hand, in inches: a layout engine draws everything twice.
    """
    side, left, bottom, top, gap, right = 3.6, 0.6, 0.4, 0.4, 0.2, 0.9
    width = left + len(titles) * (side + gap) + right
    height = bottom + side + top
    figure = Figure(figsize=(width, height))

    def place(x: float, wide: float) -> Axes:
        return figure.add_axes((x / width, bottom / height, wide / width, side / height))

    axes = [place(left + k * (side + gap), side) for k in range(len(titles))]
    for ax, title in zip(axes, titles, strict=True):
        ax.set_title(title)
        ax.set(xticks=[], yticks=[])
    axes[0].xaxis.set_major_locator(_few_ticks())
    axes[0].yaxis.set_major_locator(_few_ticks())
    return figure, axes, place(width - right, 0.15)


def _few_ticks() -> MaxNLocator:
    """Round numbers, and few of them: ticks take most of the time of a frame."""
    return MaxNLocator(3, steps=[1, 2, 5, 10])


def _frame(model: ParticleModel) -> tuple[float, float, float, float]:
    """x_min, x_max, y_min, y_max to show: a field's box, or the domain."""
    return getattr(model, "box", None) or model.space.bounds
