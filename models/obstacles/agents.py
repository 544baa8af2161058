"""Agents of the diffusion among obstacles."""

from apmethod import DiffusingParticle


class Spreading(DiffusingParticle):
    """A parcel of matter that diffuses away from crowded places, as far as walls let it.

    All of its behaviour is the agent-particle's own; what happens at a wall is the
    obstacle's.
    """
