"""The browser page of a scene: Mesa's SolaraViz with views drawn from the agents' columns.

A view is a Solara component that takes the model and is drawn anew after each step.  None
of them calls an agent, so that a frame costs about the same for a hundred agents and for
a hundred thousand.  This module needs the packages of ``apmethod[browser]``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import solara
from matplotlib.figure import Figure
from mesa.visualization import SolaraViz
from mesa.visualization.solara_viz import split_model_params
from mesa.visualization.utils import update_counter

from apmethod.field import FieldModel

if TYPE_CHECKING:
    from apmethod.model import ParticleModel

    View = Callable[[ParticleModel], solara.Element]


def agents_view(column: str = "mass") -> View:
    """A view of the agents where they are, coloured by a column.

    Args:
        column: name of a column with one number an agent.
    """

    def draw(model: ParticleModel) -> Figure:
        figure, (ax,) = _panels(1)
        dots = ax.scatter(
            *model.particles.position.T,
            c=getattr(model.particles, column),
            s=np.clip(20_000.0 / max(len(model.particles), 1), 0.5, 30.0),
            linewidths=0,
        )
        x_min, x_max, y_min, y_max = _frame(model)
        ax.set(xlim=(x_min, x_max), ylim=(y_min, y_max), aspect="equal")
        ax.set_title("agents")
        figure.colorbar(dots, ax=ax, label=column)
        return figure

    return figure_view(draw)


def field_view() -> View:
    """A view of a `FieldModel`'s field, beside the exact solution where it is known."""

    def draw(model: FieldModel) -> Figure:
        x, y = model.grid()
        field = model.field(np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)
        exact = model.exact(x, y, model.elapsed)
        fields = {"field": field} if exact is None else {"field": field, "exact": exact}
        top = max(values.max() for values in fields.values())
        figure, axes = _panels(len(fields))
        for ax, (title, values) in zip(axes, fields.items(), strict=True):
            image = ax.imshow(values, origin="lower", extent=model.box, vmin=0.0, vmax=top)
            ax.set_title(title)
        figure.colorbar(image, ax=axes)
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
        update_counter.get()
        solara.FigureMatplotlib(draw(model), format="png")

    return FigureView


def diagnostics_view() -> View:
    """A view of the model's diagnostics, and of its errors where the solution is known."""

    @solara.component
    def DiagnosticsView(model):
        update_counter.get()
        numbers = model.diagnostics() | getattr(model, "errors", dict)()
        with solara.Card("Diagnostics"), solara.Column(gap="4px"):
            for name, value in numbers.items():
                solara.Text(f"{name.replace('_', ' ')}: {value:.6g}")

    return DiagnosticsView


def page(
    model_class: type[ParticleModel],
    model_params: Mapping[str, Any],
    *,
    views: Sequence[View] | None = None,
    name: str | None = None,
    play_interval: int = 50,
) -> solara.Element:
    """The page of a scene; an app assigns it to ``page``.

    Everyone who opens the page gets a model of their own.

    Args:
        model_class: class of the scene's model.
        model_params: its arguments, fixed values or Mesa's user inputs, with "rng": the
            model starts with them, and is built anew from them on Reset.
        views: what to show; by default the agents, the field of a `FieldModel`, and the
            diagnostics.
        name: title, by default the name of the class.
        play_interval: pause between two steps while playing, in milliseconds.
    """
    if views is None:
        field = [field_view()] if issubclass(model_class, FieldModel) else []
        views = [agents_view(), *field, diagnostics_view()]

    @solara.component
    def ScenePage():
        model = solara.use_memo(lambda: model_class(**_starting_values(model_params)), [])
        SolaraViz(
            model,
            components=list(views),
            model_params=dict(model_params),
            name=name or model_class.__name__,
            play_interval=play_interval,
        )

    return ScenePage()


def _starting_values(model_params: Mapping[str, Any]) -> dict[str, Any]:
    """The model's arguments as the inputs stand when the page opens."""
    inputs, fixed = split_model_params(model_params)
    return fixed | {name: options.get("value") for name, options in inputs.items()}


def _panels(count: int) -> tuple[Figure, np.ndarray]:
    """A figure with square panels side by side."""
    figure = Figure(figsize=(4.4 * count + 0.8, 4.2), layout="compressed")
    return figure, figure.subplots(1, count, sharex=True, sharey=True, squeeze=False)[0]


def _frame(model: ParticleModel) -> tuple[float, float, float, float]:
    """x_min, x_max, y_min, y_max to show: a field's box, or the domain."""
    return getattr(model, "box", model.space.bounds)
