"""Agents of the aggregation."""

from apmethod import Animal


class GregariousAnimal(Animal):
    """Diffuses off its neighbours, leaves a signal, and follows the signal of all."""
