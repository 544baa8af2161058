"""Diffusion of a density in the browser: ``solara run models/diffusion/app.py``."""

from pathlib import Path

from mesa.visualization import Slider

from apmethod import ACCURACIES, load_scene
from apmethod.view import browser

views = [
    browser.agents_view(),
    browser.stacked(browser.field_view(), browser.diagnostics_view()),
]

# Their ranges keep the scene's time step stable in every combination.
model_params = {
    "rng": Slider("Seed", value=1, min=0, max=100, step=1),
    "particles": Slider("Agents", value=4000, min=500, max=10_000, step=500),
    "diffusivity": Slider("Diffusivity", value=5e-3, min=0.0, max=1e-2, step=1e-3),
    "accuracy": {
        "type": "Select",
        "label": "Accuracy",
        "value": "conservative",
        "values": list(ACCURACIES),
    },
}

DensityDiffusion = load_scene(Path(__file__).parent)

page = browser.page(DensityDiffusion, model_params, views=views, name="Diffusion of a density")
