"""A scene's step in words: what it runs, what it skips, and why."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from apmethod.model import ParticleModel

_COMPILED = "; compiled"


def explain(model: ParticleModel) -> list[tuple[str, str]]:
    """(step, what the scene does in it and why) for each step of the procedure, in order."""
    return [
        ("agents", _agents(model)),
        *getattr(model, "explained", list)(),
        ("core radius", "fixed" if model.radius_rule is None else repr(model.radius_rule)),
        *_exchange(model),
        *((type(skill).__name__, repr(skill)) for skill in model.skills),
        ("move", _move(model)),
        *([] if model.obstacles is None else [("obstacles", _obstacles(model))]),
        ("borders", _borders(model)),
        ("time step", _time_step(model)),
    ]


def _agents(model: ParticleModel) -> str:
    table = model.particles
    return ", ".join(f"{len(table.rows_of(cls))} {cls.__name__}" for cls in table.classes)


def _exchange(model: ParticleModel) -> Iterator[tuple[str, str]]:
    if not model.procedure.perceives:
        for phase in ("perceive", "contribute", "message"):
            yield phase, "skipped: no law and no agent asks for neighbours"
        return
    who = _who(model, "pairs")
    yield (
        "perceive",
        f"agents sorted into sub-domains (level p = {model.space.level}), core radius "
        f"{_core_radius(model)}{_skin(model)}{who}",
    )
    for number, terms in enumerate(model.bus.rounds, 1):
        names = ", ".join(f"{term.name} ({term.parity})" for term in terms)
        how = f", {model.bus.evaluation}" if who == _COMPILED else ""
        yield f"contribute {number}", f"{names}, kernel {model.kernel.name}{who}{how}"
        yield f"message {number}", f"sums to columns{_who(model, 'message')}"
    if not model.bus.rounds:
        for phase in ("contribute", "message"):
            yield phase, "skipped: there is no term"


def _core_radius(model: ParticleModel) -> str:
    smallest, largest = model.space.smallest_radius, model.space.core_radius
    return f"{largest:.4g}" if smallest == largest else f"{smallest:.4g} to {largest:.4g}"


def _skin(model: ParticleModel) -> str:
    skin = model.space.skin
    if not skin.share:
        return ""
    if not model.space.may_reuse:
        return ", no search reused: images, obstacles or radii of agents' own"
    return f" and a skin of {skin.share:.0%}: {skin.searches} searches made, {skin.spared} spared"


def _move(model: ParticleModel) -> str:
    motion = model.motion
    laws = ", ".join(map(repr, motion.laws)) or "no law"
    evaluations = sum(stage.interacts for stage in motion.stages())
    times = "once" if evaluations == 1 else f"{evaluations} times"
    return (
        f"{motion.integrator.name}, order {motion.integrator.order}, perceives {times} a step: "
        f"{laws}{_who(model, 'move')}"
    )


def _obstacles(model: ParticleModel) -> str:
    domains = model.obstacles.domains()
    empty = sum(not domain.obstacles for domain in domains)
    return (
        f"{model.obstacles!r}, in {len(domains)} kd-tree-domains, {empty} of them empty; "
        f"contributions {model.obstacles.contributions}"
    )


def _borders(model: ParticleModel) -> str:
    domain = model.space.domain
    if domain.is_open:
        return "skipped: the domain is open"
    return f"displacements end inside the {domain!r}"


def _time_step(model: ParticleModel) -> str:
    largest = model.largest_dt()
    limit = f"stable up to {largest:.4g}" if np.isfinite(largest) else "nothing limits it"
    if model.dt is not None:
        return f"{model.dt:.4g}, given; {limit}"
    return f"{model.next_dt():.4g} next, chosen for each step; {limit}"


def _who(model: ParticleModel, step: str) -> str:
    """Who runs a step, and why."""
    procedure = model.procedure
    if procedure.tier == "agents":
        return "; in Python, agent by agent (tier 'agents')"
    own = [
        f"{cls.__name__} overrides {', '.join(procedure.overrides(cls, step))}"
        for cls in model.particles.classes
        if procedure.overrides(cls, step)
    ]
    return f"; in Python for {'; '.join(own)}" if own else _COMPILED
