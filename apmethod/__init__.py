"""apmethod: particle methods whose particles are autonomous agents, on Mesa.

The public names are imported when they are first used, so that ``import apmethod`` does
not wait for Mesa and numba.
"""

from importlib import import_module
from typing import Any

_HOMES = {
    "apmethod.agent": ("AgentParticle", "DiffusingParticle", "InertialParticle"),
    "apmethod.animals": ("AnimalModel", "PerceptionFloor"),
    "apmethod.compile": ("set_threads",),
    "apmethod.contribute.reconstruct": ("reconstruct",),
    "apmethod.contribute.smoothing": ("KERNELS", "Kernel"),
    "apmethod.contribute.terms": ("Pair", "Term", "term"),
    "apmethod.contribute.sample": ("sample",),
    "apmethod.errors": ("StepFailed", "Unstable"),
    "apmethod.explanation": ("explain",),
    "apmethod.field.accuracy": ("ACCURACIES",),
    "apmethod.field.model": ("FieldModel",),
    "apmethod.message.bus": ("MessageBus",),
    "apmethod.model": ("ParticleModel",),
    "apmethod.move.diffusion": ("FORMS", "Diffusion"),
    "apmethod.move.flow": ("Flow",),
    "apmethod.move.integrate": ("INTEGRATORS", "Integrator"),
    "apmethod.move.law": ("Law", "Now"),
    "apmethod.move.obstacles.behaviour": ("BEHAVIOURS",),
    "apmethod.move.obstacles.collection": ("Obstacles",),
    "apmethod.move.obstacles.geojson": ("from_geojson", "from_shapely"),
    "apmethod.move.obstacles.questions": ("KdDomain",),
    "apmethod.move.obstacles.shapes": ("Obstacle", "Polygon", "Polyline", "disc", "square"),
    "apmethod.particles": ("Column", "Particles"),
    "apmethod.perceive.core_radius": ("FollowDensity", "KeepNeighbours", "RadiusRule"),
    "apmethod.perceive.domain": ("Bounded", "Domain", "Mirrored", "Open", "Periodic"),
    "apmethod.perceive.lattice": ("QuadLattice",),
    "apmethod.perceive.pairs": ("brute_force_pairs", "neighbour_pairs"),
    "apmethod.run.scenes": ("load_scene",),
    "apmethod.skills.aggregate": ("Aggregate", "DescriptionScale"),
    "apmethod.skills.animal": ("Animal",),
    "apmethod.skills.cluster": ("clusters",),
    "apmethod.skills.follow": ("Follow", "growth_rate"),
    "apmethod.skills.groups": ("Group", "GroupEvent", "Groups"),
    "apmethod.skills.life": ("Life", "Trajectories"),
    "apmethod.skills.signal": ("SignalField",),
    "apmethod.skills.skill": ("Skill",),
    "apmethod.skills.strategies": (
        "ClosestGroup",
        "FarthestGroup",
        "HighestGradient",
        "OldestGroup",
        "Pursue",
        "Strategies",
        "Strategy",
        "YoungestGroup",
    ),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__version__ = "0.1.0"
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'apmethod' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
