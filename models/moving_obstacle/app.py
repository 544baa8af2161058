"""A moving obstacle in the browser: ``solara run models/moving_obstacle/app.py``."""

from pathlib import Path

from mesa.visualization import Slider

from apmethod import load_scene
from apmethod.view import browser

views = [
    browser.agents_view(),
    browser.stacked(browser.domains_view(), browser.diagnostics_view()),
]

model_params = {
    "rng": Slider("Seed", value=1, min=0, max=100, step=1),
    "particles": Slider("Agents", value=2000, min=200, max=5000, step=200),
    "behaviour": {
        "type": "Select",
        "label": "At a wall",
        "value": "bounce",
        "values": ["repulse", "bounce", "slide", "stick", "absorb"],
    },
}

Scene = load_scene(Path(__file__).parent)

page = browser.page(Scene, model_params, views=views, name="A moving obstacle")
