"""The browser page of a scene: Mesa's SolaraViz with views drawn from the agents' columns.

It needs the packages of ``apmethod[browser]``.  A page is one call in the scene's ``app.py``:

    page = browser.page(__file__, "Harbour", particles=browser.slider("Agents", 200, 5000, 200))
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import solara
from mesa.visualization import Slider, SolaraViz
from mesa.visualization.solara_viz import split_model_params

from apmethod.run.scenes import load_scene
from apmethod.view.views import default_views

if TYPE_CHECKING:
    from apmethod.model import ParticleModel
    from apmethod.view.views import View


class Input(NamedTuple):
    """An input of the page for a setting of the scene, whose default it opens with."""

    opened_at: Callable[[Any], Any]  #: Mesa's input that opens with a value


def slider(label: str, least: float, most: float, step: float) -> Input:
    """A slider for a number; it is whole if the scene's default and all three are."""
    return Input(lambda value: Slider(label, value, least, most, step))


def choice(label: str, values: Iterable[str]) -> Input:
    """A choice of one of a few values."""
    return Input(
        lambda value: {"type": "Select", "label": label, "value": value, "values": list(values)}
    )


def page(
    scene: type[ParticleModel] | str | Path,
    name: str | None = None,
    /,
    *,
    views: Sequence[View] | None = None,
    colour: str | None = None,
    play_interval: int = 50,
    **settings: Any,
) -> solara.Element:
    """The page of a scene, for an app to assign to ``page``.

    Everyone who opens the page gets a model of their own.  It is built when the page opens and
    on Reset.

    Args:
        scene: class of the scene's model, or what `load_scene` takes: an app's ``__file__``.
        name: title, by default the name of the class.
        views: what to show; by default what `default_views` gives.
        colour: column to colour agents by in those.
        play_interval: pause between two steps while playing, in milliseconds.
        settings: arguments of the model: values, `slider`, `choice`, or inputs of Mesa's.
            Without "rng" there is a slider for the seed, from 0 to 100.
    """
    model_class = scene if isinstance(scene, type) else load_scene(scene)
    inputs = {"rng": Slider("Seed", 1, 0, 100, 1)} | {
        setting: value.opened_at(signature(model_class).parameters[setting].default)
        if isinstance(value, Input)
        else value
        for setting, value in settings.items()
    }
    return ScenePage(
        model_class=model_class,
        model_params=inputs,
        views=views,
        colour=colour,
        name=name or model_class.__name__,
        play_interval=play_interval,
    )


@solara.component
def ScenePage(model_class, model_params, views, colour, name, play_interval):
    """Mesa's page with a model of its own."""

    def begin():
        model = model_class(**_as_opened(model_params))
        return model, list(views or default_views(model, colour))

    model, shown = solara.use_memo(begin, [])
    SolaraViz(
        model,
        components=shown,
        model_params=dict(model_params),
        name=name,
        play_interval=play_interval,
    )


def _as_opened(model_params: Mapping[str, Any]) -> dict[str, Any]:
    """The model's arguments as the inputs stand when the page opens."""
    inputs, fixed = split_model_params(model_params)
    return fixed | {name: options.get("value") for name, options in inputs.items()}
