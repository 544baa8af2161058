"""Models of agents that only perceive and exchange, and their columns by agent.

Benchmarks hand positions to a model and take sums from it in the order in which its
agents were made, so that what they compare does not hang on how a model orders its rows.
"""

from __future__ import annotations

import numpy as np

from apmethod import AgentParticle, Domain, ParticleModel, Term


def population(
    positions: np.ndarray,
    core_radius: float,
    terms: list[Term],
    *,
    domain: Domain | None = None,
    level: int | None = None,
) -> ParticleModel:
    """Agents of equal mass, together 1, that exchange terms by the cubic B-spline."""
    model = ParticleModel(
        AgentParticle, core_radius=core_radius, kernel="cubic", terms=terms, dt=1.0,
        domain=domain, level=level, rng=0,
    )  # fmt: skip
    count = len(positions)
    AgentParticle.create_agents(model, count, position=positions, mass=1.0 / count)
    if model.procedure.worth_tidying:
        model.space.tidy()  # as the first step of a model does, and every 50th
    return model


def made(model: ParticleModel) -> np.ndarray:
    """For each row of the table, the place in which its agent was made."""
    identities = (agent.unique_id for agent in model.particles.agents)
    return np.fromiter(identities, np.int64, len(model.particles)) - 1


def put(model: ParticleModel, positions: np.ndarray) -> None:
    """Put the agents where they should be, positions in the order they were made."""
    model.particles.assign("position", positions[made(model)])
    model.space.forget()


def take(model: ParticleModel, name: str) -> np.ndarray:
    """A column in the order in which the agents were made."""
    values = model.particles.array(name)
    ordered = np.empty_like(values)
    ordered[made(model)] = values
    return ordered


def exchange(model: ParticleModel) -> None:
    """One perceive, contribute and message of all agents."""
    model.perceive()
    for number in range(len(model.bus.rounds)):
        model.contribute(number)
        model.message()


def candidates(model: ParticleModel) -> int:
    """How many agents are tried in a search for the neighbours of all, none by itself."""
    return model.space.cells.candidates() - len(model.particles)


def pairs(model: ParticleModel) -> np.ndarray:
    """All pairs i < j of neighbours, agents numbered as they were made, in order."""
    found = np.sort(made(model)[model.space.pairs()], axis=1)
    return found[np.lexsort((found[:, 1], found[:, 0]))]
