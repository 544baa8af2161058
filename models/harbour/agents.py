"""Agents of the harbour."""

from apmethod import DiffusingParticle


class Oil(DiffusingParticle):
    """A parcel of oil: it spreads, and the tide carries it."""
