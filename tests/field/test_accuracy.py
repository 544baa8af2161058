"""Named accuracies and parts set by hand."""

import pytest

from apmethod import ACCURACIES, FieldModel, explain
from apmethod.field.accuracy import FEW, accuracy_with


def hump(x, y):
    return (1.0 + x**2 + y**2) ** -8


def model(**options):
    return FieldModel(hump, (-2, 2, -2, 2), particles=60, rng=1, **options)


@pytest.mark.parametrize("name", list(ACCURACIES))
def test_each_name_runs(name):
    scene = model(accuracy=name)
    scene.step()
    assert dict(explain(scene))["accuracy"] == str(ACCURACIES[name].for_agents(60))
    assert scene.spacing > 0.0


def test_a_part_set_by_hand_keeps_the_others():
    scheme = accuracy_with("accurate", integrator="midpoint", remesh=0.0)
    assert (scheme.integrator.name, scheme.remesh) == ("midpoint", 0.0)
    assert (scheme.form, scheme.kernel.name) == ("plain", "gaussian_6")
    assert scheme.name == "accurate, changed"


def test_a_kernel_brings_the_spacings_that_suit_it():
    assert accuracy_with("accurate", kernel="gaussian_4").spacings == 1.6
    assert accuracy_with("accurate", kernel="gaussian_4", spacings=2.0).spacings == 2.0


def test_few_agents_have_a_kernel_that_is_cut_nearer_unless_one_is_set():
    assert accuracy_with("accurate").for_agents(FEW).kernel.name == "gaussian_6_short"
    assert accuracy_with("accurate").for_agents(FEW + 1).kernel.name == "gaussian_6"
    assert accuracy_with("accurate", kernel="gaussian_6").for_agents(100).kernel.support == 4.2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"accuracy": "best"}, "accuracy is 'best'; it must be one of paper, conservative"),
        ({"form": "laplace"}, "form is 'laplace'; it must be one of paper, plain, blob"),
        ({"kernel": "hat"}, "kernel is 'hat'"),
        ({"remesh": -1.0}, "remesh is -1.0; it must be a finite number, 0 or more"),
        ({"smooth": "much"}, "smooth is 'much'"),
        ({"growth": float("nan")}, "growth is nan"),
        ({"accuracy": "accurate", "form": "blob"}, "kernel is 'gaussian_6_short', which makes"),
    ],
)
def test_bad_parts_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        model(**options)


def test_what_a_scene_does_not_use_is_not_there():
    assert model().remesh is None
    assert "_node" not in model().particles
    assert "_node" in model(accuracy="accurate").particles
