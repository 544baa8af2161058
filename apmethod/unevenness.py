"""How unlike neighbours are, and by how much that shortens the steps that a model chooses.

A diffusion velocity is stable up to a step that theory knows for agents who each carry as much
of the field as their neighbours do.  One that is much lighter is flung about by those around it.
What tells is the area that an agent stands for, its mass over the density where it is: in a
smooth field neighbours have about the same, however steep the field is.  The unevenness is
the typical ratio of these areas of two neighbours,

    exp(mean |log(V_i/V_j)|),   V_i = m_i/rho_i.

``apmethod bench stability`` measures the largest stable step of agents whose masses differ at
random, and what the model chooses for them; see `share_for`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from apmethod.perceive.images import REAL

if TYPE_CHECKING:
    from apmethod.model import ParticleModel

#: Unevenness up to which steps need not be shorter: fields of a few hundred agents have up to
#: 1.6, agents of equal mass that stand at random or in clusters up to 1.6, too.
ALIKE = 1.65
#: Agents from which on there is something typical.
_FEWEST = 10
#: Least density, as a share of what the agent itself adds; as in the plain form.
_LEAST = 0.05


def areas(model: ParticleModel) -> np.ndarray:
    """The area that each agent stands for, by the densities of the current stage, (n,)."""
    mass, density = (model.particles.array(name) for name in ("mass", "density"))
    least = _LEAST * mass * model.motion.now().own_w
    return np.divide(mass, np.maximum(np.abs(density), least), out=np.zeros_like(mass),
                     where=mass > 0.0)  # fmt: skip


def unevenness(model: ParticleModel, size: np.ndarray) -> float:
    """The typical ratio of ``size``, of shape (n,), of two neighbours, 1 or more.

    Agents of size 0 do not count: without mass they act on nobody.
    """
    if not len(size) or size.min() == size.max():
        return 1.0
    cells = model.space.cells
    beside = size[cells.row[cells.of_kind(REAL)]]  # in this order neighbours follow each other
    beside = beside[beside > 0.0]
    if len(beside) < _FEWEST:
        return 1.0
    return float(np.exp(np.abs(np.diff(np.log(beside))).mean()))


def share_for(unevenness: float, power: float, end: float) -> float:
    """The share of a chosen step that an unevenness leaves: (ALIKE/unevenness)^power.

    From ``end`` on no step is stable, and it shrinks no more.
    """
    return min(1.0, (ALIKE / min(unevenness, end)) ** power)
