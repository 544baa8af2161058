"""The aggregation in the browser: ``solara run models/aggregation/app.py``."""

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
    "signal_diffusivity": Slider("Signal's diffusivity", value=0.2, min=0.05, max=1.0, step=0.05),
    "evaporation": Slider("Evaporation", value=0.1, min=0.02, max=0.5, step=0.02),
    "core_radius": Slider("Perception, patches", value=3.0, min=1.0, max=6.0, step=0.5),
}

Aggregation = load_scene(Path(__file__).parent)

page = browser.page(Aggregation, model_params, views=views, name="Animal aggregation")
