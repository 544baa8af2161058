"""Scenes and clouds of agents that many tests start from."""

import numpy as np

from apmethod import Column, DiffusingParticle, Diffusion, Flow, ParticleModel, term


def rotation(x, y, t):
    """V = (y, -x)."""
    return y, -x


class Curious(DiffusingParticle):
    """An agent with a term of each parity."""

    charge = Column(start=1.0)
    gaze = Column(2, start=(0.6, 0.8))
    moods = Column(dtype=int, start=3)

    @term("even", own=True)
    def count(pair, i, j):
        """How many agents are near, this one included."""
        return 1.0

    @term("odd", reads=("charge",), components=2)
    def force(pair, i, j):
        """A repulsion that nobody else's mass weighs."""
        size = i.charge * j.charge * pair.w
        return size * pair.x, size * pair.y

    @term("directed", reads=("charge", "gaze", "moods"), weight="mass")
    def envy(pair, i, j):
        """What the neighbours have more."""
        ahead = i.gaze[0] * pair.x + i.gaze[1] * pair.y
        return max(j.charge - i.charge, 0.0) * (pair.distance + ahead + j.moods)


def build(
    count=300,
    *,
    agent_class=DiffusingParticle,
    others=(),
    form="blob",
    kernel="gaussian",
    core_radius=0.2,
    flow=rotation,
    seed=1,
    positions=None,
    **options,
):
    """A cloud of agents of uneven mass in the unit square, as a model.

    ``others`` are further classes; agents are dealt out to all classes in turn.
    """
    draw = np.random.default_rng(seed)
    options.setdefault("integrator", "midpoint")
    options.setdefault("dt", 1e-3)
    classes = [agent_class, *others]
    model = ParticleModel(
        classes,
        core_radius=core_radius,
        kernel=kernel,
        laws=[Diffusion(1e-2, form), *([Flow(flow)] if flow else [])],
        rng=seed,
        **options,
    )
    positions = draw.random((count, 2)) if positions is None else positions
    masses = draw.uniform(0.5, 1.5, len(positions)) / len(positions)
    for k, cls in enumerate(classes):
        chosen = slice(k, None, len(classes))
        part = positions[chosen]
        if len(part):
            cls.create_agents(model, len(part), position=part, mass=masses[chosen])
    return model


def column_by_id(model, name):
    """A column in the order of the agents' ids, which does not change as rows do."""
    order = np.argsort([agent.unique_id for agent in model.particles.agents])
    return getattr(model.particles, name)[order]
