"""Guards of a step: it happens or it does not, and says which agents it failed on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from apmethod.compile import compiled, in_blocks
from apmethod.errors import StepFailed
from apmethod.mesa_versions import stay_alive

if TYPE_CHECKING:
    from apmethod.model import ParticleModel

#: Coordinates from here on overflow when distances are squared.
_FAR = 1e150
#: Agents that are looked through so quickly that another thread does not pay for fewer.
_MANY = 50_000


@contextmanager
def whole_or_not_at_all(model: ParticleModel) -> Iterator[None]:
    """Put a model's agents back if its step fails, and say which step it was."""
    state, changes = model.particles.state(), model.particles.changes
    radius = model.space.core_radius
    skills = [(skill, skill.state()) for skill in model.skills]
    try:
        yield
    except BaseException as error:  # Ctrl-C too: a step happens or it does not
        model.space.core_radius = radius
        for skill, kept in skills:
            skill.restore(kept)
        if model.particles.changes == changes:
            model.particles.restore(state)
            where = "the agents were put back to where it began"
        else:
            where = "agents came or went in it, so it could not be undone"
        error.add_note(f"step {model.steps}, from time {model.elapsed:g}: {where}")
        stay_alive(model)
        raise
    finally:
        model.motion.end()
        model.bus.close()
        model.space.forget()


def check_places(model: ParticleModel) -> None:
    """Refuse to sort agents into a lattice that are nowhere.

    Trial places within a step come here before any column is looked through, and sorting
    relies on numbers.

    Raises:
        StepFailed: for a place that is not finite, or so far off that distances overflow.
    """
    positions = model.particles.array("position")
    found = np.zeros(1, np.bool_)
    in_blocks(_look_for_lost, len(positions), positions, found, least=_MANY)
    if not found[0]:
        return
    lost = np.flatnonzero(~(np.abs(positions) < _FAR).all(axis=1))
    agent = model.particles._agents[lost[0]]
    others = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
    raise StepFailed(
        f"agent {agent.unique_id} ({type(agent).__name__}){others} went to "
        f"{positions[lost[0]].tolist()}, where no neighbour can be looked for"
        f"{model.watch.likely_cause()}",
        model.steps,
        model.elapsed,
    )


@compiled
def _look_for_lost(first, last, positions, found):
    """Tell whether any place is further off than one can be, or no number."""
    places, lost = positions[first:last].ravel(), 0
    for k in range(len(places)):
        lost += not abs(places[k]) < _FAR  # NaN compares with nothing
    if lost:
        found[0] = True


def check_finite(model: ParticleModel) -> None:
    """Look through all columns at the end of a step.

    Raises:
        StepFailed: for a NaN or an infinity.
    """
    found = model.particles.first_not_finite()
    if found is not None:
        name, agent = found
        value = model.particles.array(name)[model.particles.row(agent)]
        raise StepFailed(
            f"column {name!r} of agent {agent.unique_id} ({type(agent).__name__}) became {value}"
            f"{model.watch.likely_cause()}",
            model.steps,
            model.elapsed,
        )
