"""Diffusion among obstacles in the browser: ``solara run models/obstacles/app.py``."""

from apmethod import BEHAVIOURS
from apmethod.view import browser

page = browser.page(
    __file__,
    "Diffusion among obstacles",
    particles=browser.slider("Agents", 200, 5000, 200),
    behaviour=browser.choice("At a wall", BEHAVIOURS),
)
