"""The aggregation in the browser: ``solara run models/aggregation/app.py``."""

from apmethod.view import browser

page = browser.page(
    __file__,
    "Animal aggregation",
    particles=browser.slider("Animals", 500, 5000, 500),
    diffusivity=browser.slider("Diffusivity D", 0.01, 0.3, 0.01),
    sensitivity=browser.slider("Sensitivity", 0.0, 0.3, 0.02),
    signal_diffusivity=browser.slider("Signal's diffusivity", 0.05, 1.0, 0.05),
    evaporation=browser.slider("Evaporation", 0.02, 0.5, 0.02),
    core_radius=browser.slider("Perception, patches", 1.0, 6.0, 0.5),
)
