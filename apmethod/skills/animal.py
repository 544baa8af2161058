"""The animal: an agent-particle with the attributes that skills fill (paper 3.2)."""

from __future__ import annotations

import numpy as np

from apmethod.agent import DiffusingParticle
from apmethod.particles import Column


class Animal(DiffusingParticle):
    """An animal diffuses, which keeps it off its neighbours, and follows what it senses.

    Its mass is 1, one animal, so that the density u counts animals per area.  Each of the
    attributes below is there in scenes with the skill that fills it.
    """

    signal = Column(kept=False, unit="signal/area")
    group = Column(kept=False, dtype=np.int64)
    signal_gradient = Column(2, kept=False, unit="signal/volume")
    strategy = Column(kept=False, dtype=np.int64)
    goal = Column(2, kept=False)
    age = Column(kept=False, unit="time")
    heading = Column(2, kept=False)
