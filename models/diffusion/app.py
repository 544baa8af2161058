"""Diffusion of a density in the browser: ``solara run models/diffusion/app.py``."""

from apmethod import ACCURACIES
from apmethod.view import browser

page = browser.page(
    __file__,
    "Diffusion of a density",
    # These ranges keep the time step stable in every combination.
    particles=browser.slider("Agents", 500, 10_000, 500),
    diffusivity=browser.slider("Diffusivity", 0.0, 1e-2, 1e-3),
    accuracy=browser.choice("Accuracy", ACCURACIES),
)
