"""What a skill is: something that has its turns in each step of the scenes that name it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from apmethod.particles import Column

if TYPE_CHECKING:
    from apmethod.model import ParticleModel


class Skill:
    """Something that agents can do besides the four steps.

    A scene names its skills, ``ParticleModel(..., skills=[scent, herds])``, and they have
    their turns in that order.  A scene that names none knows nothing of them.  A skill of
    one's own overrides what it needs; what it does not override does nothing.

    Attributes:
        model: the model that the skill belongs to, from `attach` on.
    """

    model: ParticleModel

    def attach(self, model: ParticleModel) -> None:
        """Become part of a model: check that it fits, and declare columns.

        Raises:
            ValueError: if it does not fit.
        """
        self.model = model

    def begin(self, dt: float) -> None:
        """Turn at the start of a step, before the agents perceive."""

    def perceived(self) -> None:
        """Turn whenever the agents have perceived, before they contribute.

        That is once a stage; ``self.model.motion.stage`` tells which.
        """

    def end(self, dt: float) -> None:
        """Turn at the end of a step, when the agents have moved."""

    def state(self) -> Any:
        """What `restore` needs to take a failed step back."""

    def restore(self, state: Any) -> None:
        """Go back to what `state` gave."""

    def diagnostics(self) -> dict[str, float]:
        """Numbers for the model's diagnostics."""
        return {}

    def require(self, *names: str | None) -> None:
        """Check that the scene has the columns that the skill reads; None is none.

        Raises:
            ValueError: if it has not.
        """
        for name in names:
            if name is not None and name not in self.model.particles:
                raise ValueError(
                    f"{type(self).__name__} reads column {name!r}; the scene has "
                    f"{', '.join(self.model.particles.names)}"
                )

    def declare(self, name: str, components: int | None = None, **options: Any) -> None:
        """Add a column that the skill fills, for all agents of the model."""
        self.model.particles.declare(name, Column(components, kept=False, **options))

    def declare_heading(self) -> None:
        """Add the column ``heading``: where agents look, unit vectors for `Life` to turn."""
        self.declare("heading", 2, start=(1.0, 0.0))

    def column(self, name: str) -> np.ndarray:
        """A column of all agents, writable."""
        return self.model.particles.array(name)
