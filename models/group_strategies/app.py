"""Strategies in the browser: ``solara run models/group_strategies/app.py``."""

from pathlib import Path

from mesa.visualization import Slider

from apmethod import load_scene
from apmethod.view import browser

views = [
    browser.animals_view(column="strategy"),
    browser.stacked(browser.signal_view(), browser.diagnostics_view()),
]

model_params = {
    "rng": Slider("Seed", value=1, min=0, max=100, step=1),
    "particles": Slider("Animals", value=2500, min=500, max=5000, step=500),
    "strategy": {
        "type": "Select",
        "label": "Strategy",
        "value": "mixed",
        "values": ["mixed", "gradient", "closest", "farthest", "oldest", "youngest", "largest"],
    },
    "leaders": Slider("Leaders (in Python)", value=0, min=0, max=50, step=5),
    "diffusivity": Slider("Diffusivity D", value=0.03, min=0.01, max=0.1, step=0.01),
    "speed": Slider("Speed to a group", value=0.3, min=0.0, max=1.0, step=0.1),
}

GroupStrategies = load_scene(Path(__file__).parent)

page = browser.page(GroupStrategies, model_params, views=views, name="Strategies of joining groups")
