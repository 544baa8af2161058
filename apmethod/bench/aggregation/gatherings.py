"""The paper's Figures 9 and 10 over many seeds: how many groups, and how soon they are stable.

Figure 9 compares two diffusivities, Figure 10 perception with a floor and without.  Both
ends of a comparison start from the same places, so that seeds are compared in pairs, and a
difference is told with the 95 % confidence interval of its mean (Student's t).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from apmethod.animals import AnimalModel
from apmethod.bench.timing import Progress, Report
from apmethod.run.scenes import load_scene
from apmethod.skills.groups import Groups

#: Latest end of the runs of a short form: Figure 10's settings differ from some t = 60 on.
QUICK = 150.0
#: For each figure its scene, the end of its runs, and the settings it compares.  Figure 10 is
#: repeated at the lower diffusivity of Figure 9: the paper does not tell which one it has.
FIGURES = {
    "figure 9": ("aggregation", 100.0, ({"diffusivity": 0.1}, {"diffusivity": 0.01})),
    "figure 10": ("aggregation_perception", 300.0, ({"floor": 0.0}, {"floor": 0.06})),
    "figure 10, low diffusivity": (
        "aggregation_perception", 300.0,
        ({"floor": 0.0, "diffusivity": 0.01}, {"floor": 0.06, "diffusivity": 0.01}),
    ),
}  # fmt: skip


def runs(
    figure: str, seeds: Sequence[int], until: float | None = None, report: Report | None = None
) -> tuple[list[dict[str, Any]], list[AnimalModel]]:
    """Run both settings of a figure for each seed.

    Args:
        figure: one of `FIGURES`.
        seeds: seeds of the runs.
        until: end of the runs where that is before the figure's own.

    Returns:
        One row for each run, and the models of the first seed as they ended.
    """
    scene, end, settings = FIGURES[figure]
    progress = Progress(report, [1] * (len(seeds) * len(settings)))
    rows, models = [], []
    for seed in seeds:
        for setting in settings:
            model = load_scene(scene)(rng=seed, **setting)
            model.until = end if until is None else min(end, until)
            rows.append({"figure": figure, "seed": seed, **setting, **outcome(model)})
            if seed == seeds[0]:
                models.append(model)
            progress.made(1)
    return rows, models


def outcome(model: AnimalModel) -> dict[str, Any]:
    """Run a model to its end, and tell what its groups have come to."""
    times, member = [], []
    while model.running:
        times.append(model.elapsed)
        model.step()
        # Groups are those of the step's start.  Rows stay: nobody joins or leaves the model.
        member.append(model.particles.group.astype(np.int32))
    model.groups.find()
    times.append(model.elapsed)
    member.append(model.particles.group.astype(np.int32))
    events = model.groups.events
    return {
        "time": model.elapsed,
        "groups": len(model.groups.current),
        "share_in_groups": sum(g.size for g in model.groups.current) / len(model.particles),
        **lasting_groups(model.groups, model.elapsed),
        "settling_time": settling_time(times, member),
        "last_event": max((event.time for event in events), default=0.0),
        "events": len(events),
    }


def lasting_groups(groups: Groups, elapsed: float) -> dict[str, float]:
    """How soon the groups that last, those there at the end, were made.

    Returns:
        ``born``: their mean time of birth; ``unaltered_since``: the mean time of the last
        event that each took part in, be it its birth, a merge or a split.  Both are
        ``elapsed`` if there are none.
    """
    since = {group.identity: group.born for group in groups.current}
    for event in groups.events:  # in order of time
        since |= {each: event.time for each in (event.group, event.other) if each in since}
    return {
        "born": float(np.mean([group.born for group in groups.current] or [elapsed])),
        "unaltered_since": float(np.mean(list(since.values()) or [elapsed])),
    }


def settling_time(times: Sequence[float], member: Sequence[np.ndarray]) -> float:
    """How soon animals are settled: the mean time that an animal is not in its last group.

        T = integral of 1 - A(t) dt,   A(t) = share of animals in the group that they end in

    If all animals entered their last group at one moment, T would be this moment; else it is
    the mean over all animals, so that a merge counts by the animals that change their group
    in it.  An animal that is alone at the end has not settled at all, so that few groups are
    no advantage.

    Args:
        times: of the records, of shape (records,).
        member: identity of each animal's group at these times, -1 for none, of shape
            (records, animals).
    """
    member = np.asarray(member)
    settled = ((member == member[-1]) & (member[-1] >= 0)).mean(axis=1)
    return float(((1.0 - settled[:-1]) * np.diff(times)).sum())


def compared(rows: Sequence[dict[str, Any]], figure: str, what: str) -> dict[str, Any]:
    """A figure's two settings, by the mean of ``what`` and of the difference in pairs.

    Returns:
        The settings, both means, the mean difference (second less first), the half width
        of its 95 % confidence interval, and whether that leaves out 0.
    """
    from scipy.stats import t

    settings = FIGURES[figure][2]
    values = [
        np.array([row[what] for row in rows if row["figure"] == figure
                  and all(row[name] == value for name, value in setting.items())])
        for setting in settings
    ]  # fmt: skip
    difference = values[1] - values[0]
    count = len(difference)
    half = (
        t.ppf(0.975, count - 1) * difference.std(ddof=1) / np.sqrt(count) if count > 1 else np.inf
    )
    return {
        "figure": figure, "what": what, "seeds": count,
        "first": _named(settings[0]), "second": _named(settings[1]),
        "first_mean": float(values[0].mean()), "second_mean": float(values[1].mean()),
        "difference": float(difference.mean()), "half_width": float(half),
        "certain": bool(abs(difference.mean()) > half),
    }  # fmt: skip


def _named(setting: dict[str, float]) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in setting.items())


def draw(models: Sequence[AnimalModel], figure: str, path: Path) -> None:
    """Draw agents and signal of both settings side by side, as the paper does."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from apmethod.view.animals import draw_animals, draw_signal

    canvas = Figure(figsize=(9.4, 8.8), layout="constrained")
    FigureCanvasAgg(canvas)
    names = [_named(setting) for setting in FIGURES[figure][2]]
    for model, name, axes in zip(models, names, canvas.subplots(len(models), 2), strict=True):
        draw_animals(axes[0], model)
        axes[0].set_title(f"{name}: {len(model.groups.current)} groups at t = {model.elapsed:g}")
        image = draw_signal(axes[1], model.signal)
        canvas.colorbar(image, cax=axes[1].inset_axes((1.04, 0.0, 0.04, 1.0)))
        axes[1].set_title("signal")
    canvas.suptitle(figure.capitalize())
    canvas.savefig(path, dpi=100)
