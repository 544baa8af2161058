"""Agents among random obstacles for a long time, checked by shapely after every step.

    python tests/obstacle_soak.py --agent-steps 1e8

Random polygons with and without holes, thin walls and closed rooms of thin walls, some of
them moving and turning; agents make large random displacements.  After each step shapely,
which shares no code with the package, places every obstacle itself and is asked

* whether an agent is inside of a polygon,
* whether an agent is in another room than it has been in from the start: the walls of a
  room are thin, and who changes rooms has gone through one,

and the agents that came must be those that are there, have been absorbed, or squeezed.
"""

import argparse
import sys
import time

import numpy as np
import shapely
from shapely import affinity

from apmethod import (
    AgentParticle,
    Bounded,
    Column,
    Law,
    Obstacles,
    ParticleModel,
    Periodic,
    Polygon,
)
from obstacle_samples import random_obstacles


class Wanderer(AgentParticle):
    """Goes where it is pushed."""

    push = Column(2)
    identity = Column(dtype=int)


def area(obstacle):
    """shapely's own idea of an obstacle that has an inside, at time 0; None for the others."""
    chain = obstacle.chains[0]
    if isinstance(obstacle, Polygon):
        return shapely.Polygon(chain, obstacle.chains[1:])
    return shapely.Polygon(chain) if (chain[0] == chain[-1]).all() else None


def area_at(obstacle, now):
    """The same at a time."""
    x, y, turn = obstacle.pose(now)
    turned = affinity.rotate(area(obstacle), turn, origin=tuple(obstacle.pivot), use_radians=True)
    return affinity.translate(turned, x, y)


def rooms_of(obstacles, positions, now):
    """Which room each position is in, (n, rooms), and whether it is in something solid."""
    with_inside = [o for o in obstacles if area(o) is not None]
    members = np.zeros((len(positions), len(with_inside)), bool)
    solid = np.zeros(len(positions), bool)
    for column, obstacle in enumerate(with_inside):
        shape = area_at(obstacle, now)
        x_min, y_min, x_max, y_max = shape.bounds
        x, y = positions.T
        near = np.flatnonzero((x >= x_min) & (x <= x_max) & (y >= y_min) & (y <= y_max))
        shapely.prepare(shape)
        members[near, column] = shapely.contains_xy(shape, positions[near])
        if isinstance(obstacle, Polygon):
            solid |= members[:, column]
            # The hole is a room of its own: who is in it stays.
            if obstacle.chains[1:]:
                filled = shapely.Polygon(shape.exterior)
                shapely.prepare(filled)
                members[near, column] = shapely.contains_xy(filled, positions[near])
    return members, solid


def wander(seed, agents, steps, *, moving=True, domain="bounded", reach=0.15, report=None):
    """One random scene for some steps; returns its model and the agent-steps made.

    Raises:
        AssertionError: as soon as an agent is where it cannot be.
    """
    draw = np.random.default_rng(seed)
    borders = {"bounded": Bounded((0, 0), (1, 1)), "periodic": Periodic((0, 0), (1, 1))}
    obstacles = random_obstacles(draw, moving and domain != "periodic")
    model = ParticleModel(
        Wanderer,
        core_radius=0.1,
        domain=borders.get(domain),
        laws=[Law("push", lambda agent, p: agent.push, reads=("push",))],
        dt=0.1,
        obstacles=Obstacles(obstacles, squeezed="remove"),
        rng=seed,
    )
    positions = draw.random((agents, 2))
    solid = rooms_of(obstacles, positions, 0.0)[1]
    fit = ~solid & ~model.obstacles.near(positions, 1e-6)
    positions = positions[fit]
    came = len(positions)
    Wanderer.create_agents(model, came, position=positions, identity=np.arange(came))
    rooms = rooms_of(obstacles, positions, 0.0)[0]
    made = 0
    for _ in range(steps):
        count = len(model.particles)
        if not count:
            break
        size = reach * draw.exponential(size=(count, 1)) / model.dt
        model.particles.assign("push", size * draw.normal(size=(count, 2)))
        model.step()
        made += count
        table = model.particles
        assert len(table) + model.obstacles.absorbed + len(model.obstacles.squeezed) == came
        assert len(model.agents) == len(table)
        members, solid = rooms_of(obstacles, table.position, model.elapsed)
        assert not solid.any(), (seed, model.steps, table.position[solid][:3])
        moved = (members != rooms[table.identity]).any(axis=1)
        assert not moved.any(), (seed, model.steps, table.position[moved][:3])
    if report is not None:
        report(model, made)
    return model, made


def main():
    """Wander from scene to scene until enough agent-steps have been made."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--agent-steps", type=float, default=1e8)
    parser.add_argument("--agents", type=int, default=20_000)
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    total = absorbed = squeezed = rebuilds = scenes = 0
    began = time.perf_counter()
    domains = ("bounded", "bounded", "open", "periodic")
    while total < options.agent_steps:
        seed = options.seed + scenes
        model, made = wander(
            seed, options.agents, options.steps, domain=domains[scenes % 4],
            reach=(0.02, 0.15, 0.6)[scenes % 3],
        )  # fmt: skip
        total, scenes = total + made, scenes + 1
        absorbed += model.obstacles.absorbed
        squeezed += len(model.obstacles.squeezed)
        rebuilds += model.obstacles.rebuilds
        print(
            f"\r{scenes} scenes, {total:.3g} agent-steps, {absorbed} absorbed, {squeezed} "
            f"squeezed, {rebuilds} rebuilds, {time.perf_counter() - began:.0f} s",
            end="", file=sys.stderr, flush=True,
        )  # fmt: skip
    print(
        f"\n{total} agent-steps in {scenes} scenes: no agent inside an obstacle, none through a "
        f"wall, none lost ({absorbed} absorbed, {squeezed} squeezed and reported)"
    )


if __name__ == "__main__":
    main()
