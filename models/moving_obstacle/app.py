"""A moving obstacle in the browser: ``solara run models/moving_obstacle/app.py``."""

from apmethod import BEHAVIOURS
from apmethod.view import browser

page = browser.page(
    __file__,
    "A moving obstacle",
    particles=browser.slider("Agents", 200, 5000, 200),
    behaviour=browser.choice("At a wall", BEHAVIOURS),
)
