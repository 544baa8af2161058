"""The rotating hill in the browser: ``solara run models/rotating_hill/app.py``."""

from math import pi

from apmethod import ACCURACIES
from apmethod.view import browser

page = browser.page(
    __file__,
    "Rotating hill",
    # These ranges keep the time step stable in every combination.
    particles=browser.slider("Agents", 500, 10_000, 500),
    diffusivity=browser.slider("Diffusivity", 0.0, 2e-3, 1e-4),
    accuracy=browser.choice("Accuracy", ACCURACIES),
    dt=pi / 80,  # 160 steps a turn, for the eye: the model's own choice is coarser
)
