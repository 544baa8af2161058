"""Agents of the diffusing density."""

from apmethod import DiffusingParticle


class Parcel(DiffusingParticle):
    """A parcel of the density: it moves away from where its neighbours are dense."""
