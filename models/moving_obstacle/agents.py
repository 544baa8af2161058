"""Agents that a moving obstacle stirs."""

from apmethod import DiffusingParticle


class Stirred(DiffusingParticle):
    """A parcel of matter that diffuses, and makes way for what comes."""
