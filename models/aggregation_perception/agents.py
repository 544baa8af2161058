"""Agents of the aggregation with a floor to perception."""

from apmethod import Animal, Column


class FarSightedAnimal(Animal):
    """Looks at least as far as the floor, however many neighbours are nearer.

    It looks to where it is heading; ``view`` is the cosine of half the angle that it sees.
    """

    view = Column(start=-1.0)
