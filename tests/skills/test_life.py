"""Age, heading and trajectories."""

import numpy as np
import pytest

from apmethod import Animal, Flow, Life, ParticleModel, Periodic, Trajectories


def wind(x, y, t):
    return -3.0, 4.0


def drifting(*skills, **options):
    return ParticleModel(
        Animal,
        core_radius=1.0,
        domain=Periodic((0, 0), (10, 10)),
        laws=[Flow(wind)],
        skills=skills,
        dt=0.5,
        **options,
    )


def test_animals_age_from_when_they_came_and_look_where_they_go():
    model = drifting(Life())
    early = Animal(model, position=(1, 9))
    assert early.heading.tolist() == [1.0, 0.0]
    model.step()
    late = Animal(model, position=(5, 5))
    model.step()
    assert (early.age, late.age) == (1.0, 0.5)
    np.testing.assert_allclose(early.heading, [-0.6, 0.8])  # across both sides, too


def test_trajectories_of_some_agents():
    paths = Trajectories(every=2)
    model = drifting(paths)
    followed = Animal(model, position=(9, 1))
    Animal(model, position=(1, 1))
    paths.follow([followed])
    for _ in range(3):
        model.step()
    followed.remove()
    model.step()
    assert paths.times == [0.0, 1.0, 2.0]
    (path,) = paths.paths.values()
    assert path == [(9.0, 1.0), pytest.approx((6.0, 5.0))]
