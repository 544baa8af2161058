"""The command line: ``apmethod run``, ``explain`` and ``scenes``."""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from apmethod import __version__
from apmethod.bench.command import add_parser as add_bench


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Returns:
        0, 1 if a run failed, 2 for input that was refused, 130 after Ctrl-C.
    """
    # Imports and machine code make hundreds of thousands of lasting objects; looking
    # through them for garbage as often as by default is a tenth of a short run.
    gc.set_threshold(100_000, 20, 20)
    options = _parser().parse_args(arguments)
    try:
        return options.command(options)
    except (ValueError, TypeError) as error:
        if options.debug:
            raise
        print(f"apmethod: {error}", file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="apmethod", description="Agent-particle models: particles that are agents."
    )
    parser.add_argument("--version", action="version", version=f"apmethod {__version__}")
    parser.add_argument("--debug", action="store_true", help="show where an error comes from")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    run = commands.add_parser("run", help="run a scene and report on it")
    _add_scene(run)
    end = run.add_mutually_exclusive_group()
    end.add_argument("--until", type=float, metavar="TIME", help="physical time to end at")
    end.add_argument("--steps", type=int, help="number of steps to make")
    run.add_argument("--threads", type=int, help="threads of the compiled tier")
    run.add_argument(
        "--out", type=Path, metavar="DIR", help="folder for the results (default: out/SCENE)"
    )
    run.set_defaults(command=_run)

    explain = commands.add_parser("explain", help="what a step runs, what it skips, and why")
    _add_scene(explain)
    explain.set_defaults(command=_explain)

    scenes = commands.add_parser("scenes", help="the scenes that come with the package")
    scenes.add_argument("--json", action="store_true", help="print JSON")
    scenes.set_defaults(command=_scenes)

    add_bench(commands)
    return parser


def _add_scene(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", help="path of a scene's folder, or a shipped scene's name")
    parser.add_argument("--particles", type=int, help="number of agents")
    parser.add_argument("--seed", type=int, help="seed of the random streams (default: 0)")
    parser.add_argument("--tier", choices=["agents", "compiled"], help="how steps are run")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", dest="settings",
        help="any other setting of the scene; may be given several times",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print JSON")


def _build(options: argparse.Namespace) -> tuple[str, Any]:
    """The scene's name and a model of it."""
    from apmethod.run.scenes import build, load_scene, parse_setting

    scene = load_scene(options.scene)
    settings: dict[str, Any] = {"rng": 0 if options.seed is None else options.seed}
    settings |= dict(parse_setting(text) for text in options.settings)
    for name in ("particles", "tier"):
        if getattr(options, name) is not None:
            settings[name] = getattr(options, name)
    return scene.__module__.split(".")[-2], build(scene, settings)


def _run(options: argparse.Namespace) -> int:
    from apmethod.compile import set_threads
    from apmethod.run.report import print_json, print_table, summary_rows, write_run
    from apmethod.run.runner import run
    from apmethod.view.progress import progress_bar

    if options.threads is not None:
        set_threads(options.threads)
    name, model = _build(options)
    name = Path(options.scene).resolve().name if Path(options.scene).is_dir() else name
    with progress_bar(name) as progress:
        result = run(model, until=options.until, steps=options.steps, progress=progress)
    summary = result.summary()
    files = write_run(result, name, options.out or Path("out") / name, summary)
    if options.json:
        print_json({"scene": name, **summary, "files": files})
    else:
        print_table(name, summary_rows(summary))
        for kind, path in files.items():
            print(f"{kind:8} {path}")
    if result.failure:
        print(f"apmethod: {result.failure}", file=sys.stderr)
    return {"finished": 0, "failed": 1, "interrupted": 130}[result.ended]


def _explain(options: argparse.Namespace) -> int:
    from apmethod.explanation import explain
    from apmethod.run.report import print_json, print_table

    name, model = _build(options)
    rows = explain(model)
    if options.json:
        print_json({"scene": name, "steps": dict(rows)})
    else:
        print_table(f"a step of {name}", rows, ("step", "what it does"))
    return 0


def _scenes(options: argparse.Namespace) -> int:
    from apmethod.run.report import print_json, print_table
    from apmethod.run.scenes import load_scene, shipped_scenes

    rows = [(name, (load_scene(name).__doc__ or "").split("\n")[0]) for name in shipped_scenes()]
    if options.json:
        print_json(dict(rows))
    else:
        print_table("scenes", rows, ("name", "what it is"))
    return 0
