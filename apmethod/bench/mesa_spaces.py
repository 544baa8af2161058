"""Mesa's own continuous spaces, asked for the neighbours of its agents."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from random import Random

import mesa
import numpy as np

#: A search of this many agents at most; beyond, it would go on for minutes.
WHOLE = 20_000


def experimental_space(
    positions: np.ndarray, radius: float, *, torus: bool, sample: int | None = None
) -> Callable[[], int]:
    """A search by ``mesa.experimental.continuous_space.ContinuousSpace``.

    Args:
        positions: of the agents, in ]-1/2, 1/2[^2, of shape (n, 2).
        radius: agents at most this far are neighbours.
        torus: whether the square is periodic.
        sample: search for the first that many agents only.

    Returns:
        A function that searches and gives back how many neighbours it has found.
    """
    from mesa.experimental.continuous_space import ContinuousSpace, ContinuousSpaceAgent

    model = mesa.Model()
    space = ContinuousSpace(
        [[-0.5, 0.5], [-0.5, 0.5]], torus=torus, random=Random(0), n_agents=len(positions)
    )
    agents = [ContinuousSpaceAgent(space, model) for _ in positions]
    for agent, position in zip(agents, positions, strict=True):
        agent.position = position
    searching = agents[:sample]

    def search() -> int:
        return sum(len(agent.get_neighbors_in_radius(radius)[0]) for agent in searching)

    return search


def stable_space(
    positions: np.ndarray, radius: float, *, torus: bool, sample: int | None = None
) -> Callable[[], int]:
    """The same by ``mesa.space.ContinuousSpace``."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that newer versions of Mesa have a newer space
        from mesa.space import ContinuousSpace

        space = ContinuousSpace(0.5, 0.5, torus, x_min=-0.5, y_min=-0.5)
    model = mesa.Model()
    for x, y in positions.tolist():
        space.place_agent(mesa.Agent(model), (x, y))
    searching = positions[:sample].tolist()

    def search() -> int:
        found = sum(len(space.get_neighbors((x, y), radius)) for x, y in searching)
        return found - len(searching)  # with the agent itself each time

    return search


SPACES = {
    "Mesa, experimental space": experimental_space,
    "Mesa, space": stable_space,
}
