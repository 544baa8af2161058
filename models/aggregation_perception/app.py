"""Perception with a floor in the browser: ``solara run models/aggregation_perception/app.py``."""

from pathlib import Path

from mesa.visualization import Slider

from apmethod import load_scene
from apmethod.view import browser

views = [
    browser.animals_view(),
    browser.stacked(browser.signal_view(), browser.diagnostics_view()),
]

model_params = {
    "rng": Slider("Seed", value=1, min=0, max=100, step=1),
    "particles": Slider("Animals", value=2500, min=500, max=5000, step=500),
    "diffusivity": Slider("Diffusivity D", value=0.1, min=0.01, max=0.3, step=0.01),
    "sensitivity": Slider("Sensitivity", value=0.1, min=0.0, max=0.3, step=0.02),
    "floor": Slider("Floor of perception, sides", value=0.06, min=0.0, max=0.12, step=0.01),
}

AggregationPerception = load_scene(Path(__file__).parent)

page = browser.page(
    AggregationPerception, model_params, views=views, name="Aggregation with a floor to perception"
)
