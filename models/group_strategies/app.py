"""Strategies in the browser: ``solara run models/group_strategies/app.py``."""

from apmethod.view import browser

page = browser.page(
    __file__,
    "Strategies of joining groups",
    colour="strategy",
    particles=browser.slider("Animals", 500, 5000, 500),
    strategy=browser.choice(
        "Strategy", ["mixed", "gradient", "closest", "farthest", "oldest", "youngest", "largest"]
    ),
    leaders=browser.slider("Leaders (in Python)", 0, 50, 5),
    diffusivity=browser.slider("Diffusivity D", 0.01, 0.1, 0.01),
    speed=browser.slider("Speed to a group", 0.0, 1.0, 0.1),
)
