"""Perception with a floor in the browser: ``solara run models/aggregation_perception/app.py``."""

from apmethod.view import browser

page = browser.page(
    __file__,
    "Aggregation with a floor to perception",
    particles=browser.slider("Animals", 500, 5000, 500),
    diffusivity=browser.slider("Diffusivity D", 0.01, 0.3, 0.01),
    sensitivity=browser.slider("Sensitivity", 0.0, 0.3, 0.02),
    floor=browser.slider("Floor of perception, sides", 0.0, 0.12, 0.01),
)
