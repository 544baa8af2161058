"""The rotating hill in the browser: ``solara run models/rotating_hill/app.py``."""

from math import pi
from pathlib import Path

from mesa.visualization import Slider

from apmethod import FORMS, KERNELS, load_scene
from apmethod.view import browser

views = [
    browser.agents_view(),
    browser.stacked(browser.field_view(), browser.diagnostics_view()),
]

# The ranges keep every choice stable with the time step below.
model_params = {
    "rng": Slider("Seed", value=1, min=0, max=100, step=1),
    "particles": Slider("Agents", value=4000, min=500, max=10_000, step=500),
    "diffusivity": Slider("Diffusivity", value=1e-3, min=0.0, max=2e-3, step=1e-4),
    "form": {"type": "Select", "label": "Diffusion form", "value": "blob", "values": list(FORMS)},
    "kernel": {
        "type": "Select",
        "label": "Kernel",
        "value": "gaussian",
        # The blob form refuses a kernel that is negative somewhere.
        "values": [kernel.name for kernel in KERNELS.values() if kernel.order == 2],
    },
    "dt": pi / 80,  # for the eye: the model would choose larger steps
}

RotatingHill = load_scene(Path(__file__).parent)

page = browser.page(RotatingHill, model_params, views=views, name="Rotating hill")
