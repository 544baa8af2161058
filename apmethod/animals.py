"""Scenes of animals that leave a signal, follow it and gather (paper 3.2)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from apmethod.checks import finite_number, seed_checked, whole_number
from apmethod.model import ParticleModel
from apmethod.move.diffusion import Diffusion
from apmethod.particles import Particles
from apmethod.perceive.core_radius import FollowDensity
from apmethod.perceive.domain import Periodic
from apmethod.perceive.lattice import QuadLattice
from apmethod.skills.aggregate import Aggregate, DescriptionScale
from apmethod.skills.animal import Animal
from apmethod.skills.follow import Follow
from apmethod.skills.groups import Group, Groups
from apmethod.skills.signal import SignalField
from apmethod.skills.skill import Skill
from apmethod.skills.strategies import Pursue, Strategies, Strategy


class PerceptionFloor(FollowDensity):
    """A core radius that keeps the number of neighbours, but never falls below a floor.

    Args:
        floor: h_min, a length (paper Figure 10).
    """

    def __init__(self, floor: float):
        super().__init__()
        self.floor = finite_number("floor", floor, least=0.0)

    def __repr__(self) -> str:
        return f"{super().__repr__()}, at least {self.floor:g}"

    def adapt(self, space: QuadLattice, particles: Particles) -> None:
        """Set the core radius from the density that agents last received."""
        super().adapt(space, particles)
        space.core_radius = max(space.core_radius, self.floor)


class AnimalModel(ParticleModel):
    """Animals at random places of a periodic square, with a signal and groups (eq 3.4).

    Lengths are in patches, times in steps of the paper, masses in animals: see the README
    of ``models/aggregation``.  The order of a step is the paper's: adapt the core radius,
    produce signal, let it spread, diffuse and follow its gradient.

    Args:
        particles: number of animals.
        diffusivity: D of the animals.
        sensitivity: lambda; they go up the signal's gradient at lambda grad s.
        production: alpha, signal that an animal produces in a unit of time.
        evaporation: beta.
        signal_diffusivity: Ds.
        side: side of the square.
        patch: side of a patch.
        core_radius: how far animals perceive each other and the signal.
        floor: below what the core radius never falls as animals crowd.  That is a patch at
            least: the signal tells nothing about what is nearer.
        sensing: how they sense the signal, see `SignalField`.
        sight, view: columns of the animals' class with how far and in what cone each
            perceives the signal and groups, see `SignalField` and `Strategies`.
        near: distance at which two animals are near, for groups.
        least: animals within it, itself included, that make one the core of a group.
        strategies: strategies that animals may be given, see `Strategies`.
        speed: of animals on the way to the group of their strategy.
        gather: tells of a `Group` whether it becomes one agent, see `DescriptionScale`.
        dissolve: tells of such an `Aggregate` whether it becomes many again.
        skills: further ones.
        dt: longest time step; steeper peaks of the signal make shorter ones.
        tier, rng: see `ParticleModel`.
        agent_class: class of the animals.

    Attributes:
        signal, groups, strategies: the scene's skills; strategies is None without any.
    """

    def __init__(
        self,
        *,
        particles: int = 2500,
        diffusivity: float = 0.1,
        sensitivity: float = 0.1,
        production: float = 0.3,
        evaporation: float = 0.1,
        signal_diffusivity: float = 0.2,
        side: float = 50.0,
        patch: float = 1.0,
        core_radius: float = 3.0,
        floor: float = 0.0,
        sensing: str = "vicinity",
        sight: str | None = None,
        view: str | None = None,
        near: float = 1.0,
        least: int = 10,
        strategies: Sequence[type[Strategy]] = (),
        speed: float = 0.5,
        gather: Callable[[Group], bool] | None = None,
        dissolve: Callable[[Aggregate], bool] = lambda aggregate: False,
        skills: Sequence[Skill] = (),
        dt: float = 0.25,
        tier: str = "compiled",
        rng: int | None = None,
        agent_class: type[Animal] = Animal,
    ):
        count = whole_number("particles", particles, least=0)
        side = finite_number("side", side, above=0.0)
        self.signal = SignalField(
            patch,
            production=production,
            diffusivity=finite_number("signal_diffusivity", signal_diffusivity, least=0.0),
            evaporation=evaporation,
            sensing=sensing,
            sight=sight,
            view=view,
        )
        self.groups = Groups(finite_number("near", near, above=0.0), least)
        self.strategies = (
            Strategies(self.groups, strategies, sight=sight, view=view) if strategies else None
        )
        follow = (
            Pursue(self.signal, sensitivity, speed)
            if strategies
            else Follow(self.signal, sensitivity)
        )
        chosen = [self.strategies] if strategies else []
        if gather is not None:
            chosen.append(DescriptionScale(self.groups, gather, dissolve))
        floor = finite_number("floor", floor, least=0.0)
        domain = Periodic((0, 0), (side, side))
        domain.check_radius(floor)
        super().__init__(
            [agent_class, *([] if gather is None else [Aggregate])],
            core_radius=core_radius,
            domain=domain,
            laws=[Diffusion(diffusivity), follow],
            skills=[self.signal, self.groups, *chosen, *skills],
            radius_rule=PerceptionFloor(max(floor, self.signal.patch)),
            dt=dt,
            tier=tier,
            rng=rng,
        )
        draw = np.random.default_rng(seed_checked(rng))
        agent_class.create_agents(self, count, position=side * draw.random((count, 2)))
        self.groups.find()

    def next_dt(self) -> float:
        """``dt``, or less where the signal has become too steep for it."""
        return min(super().next_dt(), self.margin * self.largest_dt())
