"""Fields laid beside walls: their mass and centre, and that all agents are where they may be."""

import numpy as np
import pytest

from apmethod import Domain, FieldModel, Mirrored, Obstacles, Periodic, Polygon, Polyline, square
from apmethod.field.start import lay


def laid(obstacles, field, count, domain, **options):
    return lay(field, count, (0.0, 1.0, 0.0, 1.0), least=1e-5, offset=(0.3, 0.6), domain=domain,
               obstacles=Obstacles(obstacles), **options)  # fmt: skip


@pytest.mark.parametrize("domain", [Domain(), Mirrored((0, 0), (1, 1)), Periodic((0, 0), (1, 1))])
def test_mass_and_centre_are_those_of_the_field_outside(domain):
    corners = np.array([(0.31, 0.22), (0.77, 0.38), (0.52, 0.81)])
    walls = [Polygon(corners), Polyline([(0.1, 0.9), (0.3, 0.6)])]
    found = laid(walls, lambda x, y: np.ones_like(x), 2000, domain)
    ((x, y), (u, v)) = corners[1:] - corners[0]
    area, middle = 0.5 * (x * v - y * u), corners.mean(axis=0)
    if not domain.is_open:  # where it is, the lattice ends somewhere by the border
        mass = found.masses.sum()
        assert mass == pytest.approx(1.0 - area, rel=3e-4)
    if domain.mirrors:
        centre = (0.5 - area * middle) / (1.0 - area)
        assert found.masses @ found.positions / mass == pytest.approx(centre, abs=3e-4)
    assert not Obstacles([Polygon(corners)]).occupied(found.positions).any()
    domain.check_positions(found.positions)
    assert 1900 < len(found.masses) < 2200


def test_both_sides_of_a_thin_wall_get_their_own():
    wall = Polyline([(-1.0, 0.503), (2.0, 0.503)])
    step = laid([wall], lambda x, y: np.where(y > 0.503, 2.0, 0.0), 1000, Mirrored((0, 0), (1, 1)))
    assert (step.positions[:, 1] > 0.503).all()
    assert step.masses.sum() == pytest.approx(2.0 * 0.497, rel=2e-3)


def test_a_field_among_obstacles_reads_zero_in_them():
    model = FieldModel(
        lambda x, y: np.exp(-30.0 * ((x - 0.5) ** 2 + (y - 0.5) ** 2)), (0, 1, 0, 1),
        particles=900, obstacles=[square((0.6, 0.5), 0.15)], rng=1,
    )  # fmt: skip
    x, y = np.array([0.6, 0.58, 0.5, 0.4]), np.array([0.5, 0.52, 0.5, 0.5])
    expected = np.exp(-30.0 * ((x - 0.5) ** 2 + (y - 0.5) ** 2)) * [0, 0, 1, 1]
    assert model.field(x, y) == pytest.approx(expected, abs=0.01)
    model.step()
