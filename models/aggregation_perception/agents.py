"""Agents of the aggregation with a floor to perception."""

from apmethod import Animal


class FarSightedAnimal(Animal):
    """Looks at least as far as the floor, however many neighbours are nearer."""
