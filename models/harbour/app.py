"""The harbour in the browser: ``solara run models/harbour/app.py``."""

from apmethod import BEHAVIOURS
from apmethod.view import browser

page = browser.page(
    __file__,
    "Harbour",
    particles=browser.slider("Agents", 200, 5000, 100),
    behaviour=browser.choice("At a wall", BEHAVIOURS),
)
