"""Agents of the rotating hill."""

from apmethod import DiffusingParticle


class HillParticle(DiffusingParticle):
    """A parcel of the hill: carried by the flow, it diffuses away from crowded places.

    All of its behaviour is the agent-particle's own: it perceives its neighbours, computes
    their contributions to its density, messages them, and moves with V + A (eq 3.3).
    """
