"""No flux through walls made of obstacles: diffusion against the exact solutions by images."""

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
    """A Gaussian near walls that are turned, so that no lattice fits to them."""

    until = 0.6

    def __init__(self, kind, turn=0.3, **options):
        self.kind = kind
        self.frame = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        wall = Polyline(np.array(WALLS[kind], float) @ self.frame.T, behaviour="bounce")
        super().__init__(
            lambda x, y: self.exact(x, y, 0.0), (-0.6, 1.0, -0.3, 1.1), diffusivity=D,
            obstacles=[wall], rng=1, **options,
        )  # fmt: skip

    def exact(self, x, y, time):
        own = np.stack([x, y], axis=-1) @ self.frame
        inside = own[..., 1] > 0.0
        if self.kind != "wall":
            inside &= own[..., 0] > 0.0
        if self.kind == "box":
            inside &= (own < ROOM).all(axis=-1)
        sides = [(1,), (1, -1)] if self.kind == "wall" else [(1, -1), (1, -1)]
        rooms = (-1, 0, 1) if self.kind == "box" else (0,)
        wider = WIDTH_2 + 2.0 * D * time
        total = np.zeros(inside.shape)
        for sign in [np.array([a, b]) for a in sides[0] for b in sides[1]]:
            for room in [np.array([a, b]) for a in rooms for b in rooms]:
                apart = own - (sign * CENTRE + 2.0 * room * ROOM)
                total += WIDTH_2 / wider * np.exp(-0.5 * (apart**2).sum(axis=-1) / wider)
        return np.where(inside, total, 0.0)


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


def test_among_obstacles_agents_are_not_laid_anew():
    with pytest.raises(ValueError, match=r"remesh is 0\.5.*among obstacles agents cannot be laid"):
        Release("wall", particles=50, remesh=0.5)
