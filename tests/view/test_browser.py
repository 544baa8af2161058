"""The browser page: rendered without a browser, and clicked through in a real one."""

import os
import re
import runpy
import shutil
import socket
import subprocess
import sys
from contextlib import contextmanager, suppress
from itertools import product
from pathlib import Path
from time import sleep

import ipyvuetify
import ipywidgets
import pytest
import solara
from matplotlib.figure import Figure
from mesa.visualization import Slider
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

from apmethod import AgentParticle, FieldModel, ParticleModel, load_scene
from apmethod.view import browser
from apmethod.view.views import diagnostics_view, figure_view, stacked

ROOT = Path(__file__).parents[2]
ANIMALS = ("aggregation", "aggregation_perception", "group_strategies")
CHOICES = ("rotating_hill", "diffusion", "obstacles", "moving_obstacle", "harbour")


def app_of(scene):
    return runpy.run_path(str(ROOT / "models" / scene / "app.py"))


# -- without a browser -----------------------------------------------------------------


class Rendered:
    """A page, rendered into widgets."""

    def __init__(self, page):
        layout = solara.AppLayout(children=[page])  # gives the sidebar its place
        _, self.context = solara.render(layout, handle_error=False)

    def button(self, label):
        buttons = [found.widget for found in self.context.find(ipyvuetify.Btn)]
        return next(button for button in buttons if button.children == [label])

    def click(self, label):
        self.button(label).click()

    def texts(self):
        spans = self.context.find(ipyvuetify.Html, tag="span")
        return [span.widget.children[0] for span in spans]

    def number(self, name):
        """The number shown below a name."""
        texts = self.texts()
        return float(texts[texts.index(name) + 1])

    def images(self):
        return [bytes(image.widget.value) for image in self.context.find(ipywidgets.Image)]


@pytest.fixture
def render():
    """Renders pages, and closes them when the test is over."""
    rendered = []

    def render(page):
        rendered.append(Rendered(page))
        return rendered[-1]

    yield render
    for page in rendered:
        page.context.close()


@pytest.mark.parametrize("scene", CHOICES + ANIMALS)
def test_step_moves_the_model_on_and_reset_brings_the_same_one_back(render, scene):
    page = render(app_of(scene)["page"])
    start = page.images()
    assert len(start) == 2
    assert all(image.startswith(b"\x89PNG") for image in start)
    page.click("Step")
    page.click("Step")
    assert page.number("step") == 2
    assert page.number("time") > 0.0
    assert page.images() != start
    page.click("Reset")
    assert page.number("step") == page.number("time") == 0
    assert page.images() == start


@pytest.mark.parametrize("scene", CHOICES)
def test_every_choice_on_the_page_makes_a_sound_model(scene):
    model_params = app_of(scene)["page"].kwargs["model_params"]
    largest = {name: p.max for name, p in model_params.items() if isinstance(p, Slider)}
    fixed = {"dt": model_params["dt"]} if "dt" in model_params else {}
    selects = {name: p["values"] for name, p in model_params.items() if isinstance(p, dict)}
    for chosen in product(*selects.values()):
        choice = dict(zip(selects, chosen, strict=True))
        model = load_scene(scene)(**choice, **largest, **fixed)
        assert model.next_dt() <= model.largest_dt()


@pytest.mark.parametrize("scene", ANIMALS)
@pytest.mark.parametrize("end", ["min", "max"])
def test_animals_step_at_both_ends_of_every_slider(scene, end):
    model_params = app_of(scene)["page"].kwargs["model_params"]
    sliders = {name: p for name, p in model_params.items() if isinstance(p, Slider)}
    model = load_scene(scene)(**{name: getattr(p, end) for name, p in sliders.items()})
    model.step()
    assert model.elapsed > 0.0


def test_an_app_finds_the_scene_of_its_own_folder(tmp_path):
    copied = shutil.copytree(ROOT / "models/diffusion", tmp_path / "diffusion_copied")
    scene = runpy.run_path(str(copied / "app.py"))["page"].kwargs["model_class"]
    assert Path(sys.modules[scene.__module__].__file__).parent == copied


def test_everyone_gets_a_model_of_their_own(render):
    page = browser.page(load_scene("diffusion"), rng=1, particles=100)
    mine, yours = render(page), render(page)
    mine.click("Step")
    assert mine.number("step") == 1
    assert yours.number("step") == 0


def test_the_page_opens_as_its_inputs_stand(render):
    agents = Slider("Agents", value=300, min=100, max=500, step=100)
    page = render(browser.page("diffusion", rng=1, particles=agents))
    assert page.number("agents") == 300
    page.click("Reset")
    assert page.number("agents") == 300


def test_inputs_open_with_the_defaults_of_the_scene():
    page = browser.page(
        "diffusion",
        particles=browser.slider("Agents", 100, 5000, 100),
        accuracy=browser.choice("Accuracy", ["paper", "conservative"]),
    )
    inputs = page.kwargs["model_params"]
    assert inputs["particles"].value == 4000
    assert inputs["accuracy"]["value"] == "conservative"
    assert inputs["rng"].value == 1


class Plain(ParticleModel):
    """A model that carries no field."""

    def __init__(self, rng=None):
        super().__init__(AgentParticle, core_radius=1.0, dt=0.5, rng=rng)
        AgentParticle.create_agents(self, 3, position=[[0, 0], [1, 0], [0, 1]])


def test_a_model_without_a_field_shows_its_agents(render):
    page = render(browser.page(Plain, rng=1))
    assert len(page.images()) == 1
    page.click("Step")
    assert page.number("time") == 0.5


class Short(Plain):
    """A model that has ended after one step."""

    until = 0.5


def test_a_finished_model_can_only_be_reset(render):
    page = render(browser.page(Short, rng=1))
    page.click("Step")
    assert page.button("▶").disabled
    assert page.button("Step").disabled
    page.click("Reset")
    assert not page.button("▶").disabled
    assert not page.button("Step").disabled


class Unsolved(FieldModel):
    """A field whose solution is not known."""

    def __init__(self, rng=None):
        super().__init__(lambda x, y: 1.0 - x * x, (-1, 1, -1, 1), particles=100, rng=rng)


def test_a_field_without_a_known_solution_is_shown_alone(render):
    page = render(browser.page(Unsolved, rng=1))
    assert len(page.images()) == 2
    assert "mass" in page.texts()
    assert "l2 error" not in page.texts()


def test_a_figure_is_drawn_once_a_step(render):
    drawn = []

    def draw(model):
        drawn.append(model.steps)
        return Figure()

    view = stacked(figure_view(draw), diagnostics_view())
    page = render(browser.page(Plain, rng=1, views=[view]))
    page.click("Step")
    page.click("Step")
    assert drawn == [0, 1, 2]


# -- in a browser ----------------------------------------------------------------------

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
CHROMEDRIVER = shutil.which("chromedriver")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1500,1000",
)
PATIENCE = 180  # seconds: a first step may have to wait for the compiler


@contextmanager
def served(app, log):
    """The address of a server that runs ``app``; it is killed at the end."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "solara", "run", app, "--production", "--no-open"]
    command += ["--host", "127.0.0.1", "--port", str(port)]
    quiet = os.environ | {"SOLARA_TELEMETRY_MIXPANEL_ENABLE": "False"}
    with log.open("w") as out:
        server = subprocess.Popen(command, cwd=ROOT, env=quiet, stdout=out, stderr=out)
        try:
            _wait_until_it_answers(server, port, log)
            yield f"http://127.0.0.1:{port}"
        finally:
            server.kill()
            server.wait()


def _wait_until_it_answers(server, port, log):
    for _ in range(10 * PATIENCE):
        with suppress(OSError), socket.create_connection(("127.0.0.1", port)):
            return
        assert server.poll() is None, log.read_text()
        sleep(0.1)
    raise AssertionError(f"the server does not answer: {log.read_text()}")


@contextmanager
def chromium(profile):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    driver = webdriver.Chrome(options, webdriver.ChromeService(CHROMEDRIVER))
    try:
        yield driver
    finally:
        driver.quit()


class Shown:
    """A page in a browser."""

    def __init__(self, driver):
        self.driver = driver

    def wait(self, condition):
        return WebDriverWait(self.driver, PATIENCE).until(lambda _: condition())

    def button(self, label):
        place = f"//button[normalize-space() = '{label}' and not(@disabled)]"
        return next(iter(self.driver.find_elements(By.XPATH, place)), None)

    def click(self, label):
        self.wait(lambda: self.button(label)).click()

    def number(self, name):
        """The number shown below a name; None while there is no such name."""
        text = self.driver.find_element(By.TAG_NAME, "body").text
        found = re.search(rf"^{name}\n(\S+)$", text, re.MULTILINE)
        return found and float(found[1])

    def wait_for(self, name, condition):
        self.wait(lambda: (shown := self.number(name)) is not None and condition(shown))


@pytest.mark.skipif(
    not (CHROMIUM and CHROMEDRIVER), reason="there is no chromium with a chromedriver here"
)
def test_the_page_steps_resets_and_plays_in_a_browser(tmp_path):
    log = tmp_path / "server.log"
    with served("models/rotating_hill/app.py", log) as address, chromium(tmp_path) as driver:
        driver.get(address)
        page = Shown(driver)
        page.wait_for("step", lambda step: step == 0)
        page.wait(lambda: len(driver.find_elements(By.CSS_SELECTOR, "img[src^=blob]")) == 2)

        page.click("Step")
        page.wait_for("step", lambda step: step == 1)
        assert page.number("time") > 0.0

        page.click("Reset")
        page.wait_for("step", lambda step: step == 0)
        assert page.number("time") == 0.0

        page.click("▶")
        page.wait_for("step", lambda step: step > 2)
    assert "Traceback" not in log.read_text()
