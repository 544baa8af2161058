"""Obstacles are made from coordinates, shapely and GeoJSON; bad ones are refused by name."""

import json

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from apmethod import (
    AgentParticle,
    Bounded,
    Obstacles,
    ParticleModel,
    Periodic,
    Polygon,
    Polyline,
    disc,
    from_geojson,
    from_shapely,
    square,
)
from apmethod.move.obstacles.outline import inside

RING = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Polygon([(0, 0), (1, 1), (1, 0), (0, 1)], name="tie"), "sides of tie cross"),
        (lambda: Polygon([(0, 0), (1, 1), (2, 2)], name="flat"), "sides of flat cross or touch"),
        (lambda: Polygon([(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)], name="pinched"), "of pinched"),
        (lambda: Polygon([(0, 0), (1, 0), (1, 0), (0, 1)], name="stutter"), "twice in a row"),
        (lambda: Polygon([(0, 0), (1, 0)], name="line"), "line must have 3 or more points"),
        (lambda: Polygon([(0, 0), (1, np.nan), (1, 1)], name="hazy"), r"hazy has a point at \[1"),
        (lambda: Polygon([(0, 0), (1, 1e200), (1, 1)], name="huge"), "between 1e-100 and 1e100"),
        (lambda: Polygon([(0, 0, 0)] * 3, name="solid"), "solid must have 3 or more"),
        (lambda: Polygon(RING, holes=[[(9, 9), (9, 8), (8, 8)]], name="far"), "not inside of it"),
        (lambda: Polygon(RING, holes=[[(3, 1), (5, 1), (5, 2)]], name="cut"), "sides of cut cross"),
        (lambda: Polyline([(0, 0)], name="dot"), "dot must have 2 or more points"),
        (lambda: Polyline([(0, 0), (0, 0)], name="dot"), "twice in a row"),
        (lambda: square((0, 0), -1.0), "side is -1.0; it must be a finite number above 0"),
        (lambda: disc((0, 0), 1.0, corners=2), "corners is 2; it must be"),
        (lambda: square((0, 0), 1, name="a", behaviour="jump"), "behaviour of a is 'jump'; it"),
        (lambda: square((0, 0), 1, name="a", behaviour=lambda x: x), r"behaviour of a is .*giv"),
        (lambda: square((0, 0), 1, name="a", velocity=(np.inf, 0)), "velocity of a is inf"),
        (lambda: square((0, 0), 1, name="a", path=lambda t: 3), r"path of a is .*must give"),
        (lambda: square((0, 0), 1, name="a", path=lambda t: (t, t), spin=1), "give one of them"),
        (lambda: Obstacles([square((0, 0), 1), 7]), "obstacle 1 is 7; it must be an Obstacle"),
        (lambda: Obstacles([], rule="random"), "rule is 'random'; it must be one of"),
        (lambda: Obstacles([], squeezed="ignore"), "squeezed is 'ignore'; it must be"),
        (lambda: from_geojson({"type": "Point", "coordinates": [0, 0]}), "geometry is a Point"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_disc_has_the_area_of_the_circle():
    ring = disc((2.0, 1.0), 0.5, corners=24).chains[0]
    assert shapely.Polygon(ring).area == pytest.approx(np.pi * 0.25, rel=1e-12)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(*[st.integers(0, 8)] * 2), min_size=3, max_size=7, unique=True))
def test_polygons_are_refused_where_shapely_finds_them_invalid(corners):
    valid = shapely.Polygon(corners).is_valid
    try:
        Polygon(corners)
    except ValueError:
        assert not valid
    else:
        assert valid


def test_inside_is_as_shapely_says():
    draw = np.random.default_rng(1)
    ring = np.array([*RING[:2], (1.0, 1.0), *RING[2:], RING[0]])
    points = np.concatenate([draw.uniform(-1, 5, (500, 2)), draw.integers(-1, 6, (200, 2))])
    assert (inside(points, ring) == shapely.intersects_xy(shapely.Polygon(ring), points)).all()


def test_from_shapely_and_geojson(tmp_path):
    shape = shapely.MultiPolygon(
        [shapely.Polygon(RING, [[(1, 1), (2, 1), (2, 2)]]), shapely.box(9, 0, 10, 1)]
    )
    both = shapely.GeometryCollection([shape, shapely.LineString([(0, 5), (9, 5)])])
    made = from_shapely(both, behaviour="slide")
    assert [type(obstacle) for obstacle in made] == [Polygon, Polygon, Polyline]
    assert len(made[0].chains) == 2
    assert {obstacle.behaviour for obstacle in made} == {"slide"}
    feature = {
        "type": "Feature",
        "properties": {"name": "island", "behaviour": "stick", "height": 3},
        "geometry": shapely.geometry.mapping(shape),
    }
    path = tmp_path / "map.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    loaded = from_geojson(path, behaviour="slide")
    assert [obstacle.name for obstacle in loaded] == ["island", "island"]
    assert {obstacle.behaviour for obstacle in loaded} == {"stick"}
    assert (loaded[0].walls == made[0].walls).all()


def model_among(obstacles, **options):
    return ParticleModel(AgentParticle, core_radius=0.1, dt=1.0, obstacles=obstacles, **options)


def test_agents_that_start_in_an_obstacle_are_named():
    ring = Polygon(RING, holes=[[(1, 1), (2, 1), (2, 2), (1, 2)]], name="atoll")
    model = model_among([ring])
    with pytest.raises(ValueError, match=r"position is \[3.0, 2.0\] \(agent 1 of 3.*inside atoll"):
        AgentParticle.create_agents(model, 3, position=[[9.0, 9.0], [3.0, 2.0], [1.5, 1.5]])
    assert len(model.particles) == 0
    with pytest.raises(ValueError, match=r"agent 0, 1 of 2 given.*at the edge of an obstacle"):
        AgentParticle.create_agents(model, 2, position=[[0.0, 1.0], [4.0, 3.0]])
    places = np.array([[3.0, 2.0], [1.5, 1.5], [4.0, 3.0]])
    assert model.obstacles.occupied(places).tolist() == [True, False, True]
    agents = AgentParticle.create_agents(model, 2, position=[[1.5, 1.5], [9.0, 9.0]])
    with pytest.raises(ValueError, match=r"agent 1, 0 of 1 given.*inside atoll"):
        agents[0].position = (0.5, 0.5)
    with pytest.raises(ValueError, match=r"agent in row 1 of 2 given.*inside late"):
        model.obstacles.add(square((9.0, 9.0), 1.0, name="late"))
    assert len(model.obstacles) == 1
    assert model.obstacles.rebuilds == 0


def test_what_periodic_domains_cannot_have_is_refused():
    domain = Periodic((0, 0), (1, 1))
    with pytest.raises(ValueError, match="drum moves, and the domain is periodic along x"):
        model_among([square((0.5, 0.5), 0.1, name="drum", spin=1.0)], domain=domain)
    with pytest.raises(ValueError, match="dam reaches the periodic sides of the domain, along x"):
        model_among([Polyline([(0, 0.5), (0.7, 0.5)], name="dam")], domain=domain)
    model = model_among([square((0.5, 0.5), 0.1)], domain=domain)
    with pytest.raises(ValueError, match="late reaches the periodic sides"):
        model.obstacles.add(square((0.5, 1.0), 0.2, name="late"))
    assert len(
        model_among([Polyline([(-1, 0.5), (2, 0.5)])], domain=Bounded((0, 0), (1, 1))).obstacles
    )


def test_obstacles_belong_to_one_model():
    obstacles = Obstacles([square((0, 0), 1)])
    model_among(obstacles)
    with pytest.raises(ValueError, match="these obstacles are another model's"):
        model_among(obstacles)
