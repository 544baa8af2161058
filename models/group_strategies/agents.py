"""Agents and strategies of the scene."""

import numpy as np

from apmethod import Animal, Strategy


class Wanderer(Animal):
    """Goes to the group that its strategy prefers; in it, follows the signal as all do."""


class LargestGroup(Strategy):
    """Join the group that most have joined: a strategy of the scene's own."""

    def score(agent, group):
        """The larger, the better."""
        return group.size


class Leader(Animal):
    """Walks in a wide circle whatever the others do, and its signal draws them along.

    ``dynamics`` runs in Python, for leaders only.
    """

    def dynamics(self):
        """A walk of speed 0.15, one turn in 200, pushed as all are by who is near."""
        turn = 2.0 * np.pi * self.model.elapsed / 200.0 + self.unique_id
        return super().dynamics() + 0.15 * np.array([np.cos(turn), np.sin(turn)])
