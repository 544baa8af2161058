"""The rotating hill in the browser: ``solara run models/rotating_hill/app.py``."""

from math import pi
from pathlib import Path

from mesa.visualization import Slider

from apmethod import ACCURACIES, load_scene
from apmethod.view import browser

views = [
    browser.agents_view(),
    browser.stacked(browser.field_view(), browser.diagnostics_view()),
]

# Their ranges keep the time step stable in every combination.
model_params = {
    "rng": Slider("Seed", value=1, min=0, max=100, step=1),
    "particles": Slider("Agents", value=4000, min=500, max=10_000, step=500),
    "diffusivity": Slider("Diffusivity", value=1e-3, min=0.0, max=2e-3, step=1e-4),
    "accuracy": {
        "type": "Select",
        "label": "Accuracy",
        "value": "conservative",
        "values": list(ACCURACIES),
    },
    "dt": pi / 80,  # 160 steps a turn, for the eye: the model's own choice is coarser
}

RotatingHill = load_scene(Path(__file__).parent)

page = browser.page(RotatingHill, model_params, views=views, name="Rotating hill")
