"""Walls that let nothing through, and that absorb: diffusion against exact solutions by images."""

import numpy as np
import pytest

from apmethod import FieldModel, Polyline

WIDTH_2, CENTRE, D = 0.0125, np.array([0.17, 0.23]), 5e-3
ROOM = np.array([0.8, 0.7])
WALLS = {
    "wall": [(-9, 0), (9, 0)],
    "wedge": [(9, 0), (0, 0), (0, 9)],
    "box": [(0, 0), (0.8, 0), (0.8, 0.7), (0, 0.7), (0, 0)],
}


class Release(FieldModel):
    """A Gaussian near walls that are turned, so that no lattice fits to them.

    The walls along both axes have images of the same sign where they bounce agents back, of
    the opposite one where they absorb, and in corners the product.
    """

    until = 0.6

    def __init__(self, kind, turn=0.3, behaviours=("bounce", "bounce"), **options):
        self.kind = kind
        self.signs = [-1 if each == "absorb" else 1 for each in behaviours]
        self.frame = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        ends = np.array(WALLS[kind], float)
        if behaviours[0] == behaviours[1]:
            walls = [Polyline(ends @ self.frame.T, behaviour=behaviours[0])]
        else:
            pairs = [ends[k : k + 2] for k in range(len(ends) - 1)]
            walls = [
                Polyline(pair @ self.frame.T, behaviour=behaviours[int(np.ptp(pair[:, 0]) > 0.0)])
                for pair in pairs
            ]
        super().__init__(
            lambda x, y: self.exact(x, y, 0.0), (-0.6, 1.0, -0.3, 1.1), diffusivity=D,
            obstacles=walls, rng=1, **options,
        )  # fmt: skip

    def exact(self, x, y, time):
        own = np.stack([x, y], axis=-1) @ self.frame
        inside = own[..., 1] > 0.0
        if self.kind != "wall":
            inside &= own[..., 0] > 0.0
        if self.kind == "box":
            inside &= (own < ROOM).all(axis=-1)
        return np.where(
            inside, self.along(own[..., 0], 0, time) * self.along(own[..., 1], 1, time), 0.0
        )

    def along(self, place, axis, time):
        """The solution along one axis; u is the product of both."""
        wider = WIDTH_2 + 2.0 * D * time
        shifts = 2.0 * ROOM[axis] * np.arange(-3, 4) if self.kind == "box" else (0.0,)
        total = 0.0
        for shift in shifts:
            total = total + np.exp(-0.5 * (place - CENTRE[axis] - shift) ** 2 / wider)
            if self.kind != "wall" or axis == 1:
                image = np.exp(-0.5 * (place + CENTRE[axis] - shift) ** 2 / wider)
                total = total + self.signs[axis] * image
        return np.sqrt(WIDTH_2 / wider) * np.maximum(total, 0.0)

    def mass_left(self):
        """The mass that the solution has now."""
        mass = 1.0
        for axis in range(2):
            low = -2.0 if self.kind == "wall" and axis == 0 else 0.0
            high = ROOM[axis] if self.kind == "box" else 2.0
            places = low + (np.arange(4000) + 0.5) * (high - low) / 4000
            mass *= self.along(places, axis, self.elapsed).sum() * (high - low) / 4000
        return mass


@pytest.mark.parametrize(
    ("kind", "options", "order", "level"),
    [
        ("wall", {"accuracy": "accurate"}, 2.5, 1e-4),
        ("wedge", {}, 2.5, 2e-4),
        ("box", {}, 2.5, 2e-4),
        ("box", {"accuracy": "accurate"}, 2.5, 2e-4),
        # The lattice stands along the walls, where they happen to cut it.
        ("box", {"turn": 0.0}, 1.5, 1e-3),
    ],
)
def test_diffusion_has_no_flux_through_walls(kind, options, order, level):
    counts = (800, 3200) if "turn" not in options else (1000, 4000)
    errors = []
    for count in counts:
        model = Release(kind, particles=count, **options)
        mass = model.particles.mass.sum()
        while model.elapsed < model.until:
            model.step()
        assert model.particles.mass.sum() == mass
        errors.append(model.errors()["l2_error"])
    assert errors[-1] < level
    assert np.log(errors[0] / errors[1]) / np.log(2.0) > order


@pytest.mark.parametrize(
    ("kind", "behaviours", "options", "order", "level"),
    [
        ("wall", ("bounce", "absorb"), {}, 2.5, 1e-4),
        ("wedge", ("absorb", "absorb"), {"accuracy": "accurate"}, 3.0, 5e-5),
        ("wedge", ("bounce", "absorb"), {"accuracy": "accurate"}, 3.0, 5e-5),
        ("box", ("absorb", "absorb"), {}, 2.5, 1e-4),
        ("box", ("absorb", "bounce"), {}, 2.5, 1e-4),
    ],
)
def test_at_walls_that_absorb_the_field_is_zero(kind, behaviours, options, order, level):
    errors = []
    for count in (1000, 4000):
        model = Release(kind, behaviours=behaviours, particles=count, **options)
        begun = model.particles.mass.sum()
        while model.elapsed < model.until:
            model.step()
            left = model.particles.mass.sum()
            assert left + model.obstacles.absorbed_mass == pytest.approx(begun, rel=1e-12)
            assert abs(left - model.mass_left()) < begun / count
        assert left < 0.96 * begun
        errors.append(model.errors()["l2_error"])
    assert errors[-1] < level
    assert np.log(errors[0] / errors[1]) / np.log(2.0) > order


def test_among_obstacles_agents_are_not_laid_anew():
    with pytest.raises(ValueError, match=r"remesh is 0\.5.*among obstacles agents cannot be laid"):
        Release("wall", particles=50, remesh=0.5)
