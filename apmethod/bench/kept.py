"""Finished runs of a study on disk: one that was stopped goes on where it was."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from apmethod.bench.results import machine
from apmethod.compile import threads


class Kept:
    """Finished runs in ``runs.jsonl`` of a folder, by what they were runs of.

    A run is found again by the same settings on the same machine, with as many threads and
    the same versions.

    Args:
        folder: where the file is, or will be; None for nowhere.
    """

    def __init__(self, folder: Path | None):
        self._path = folder / "runs.jsonl" if folder else None
        self._runs: dict[str, Any] = {}
        if self._path and self._path.exists():
            for line in self._path.read_text().splitlines():
                entry = json.loads(line)
                self._runs[entry["key"]] = entry["run"]

    def or_made(self, key: Mapping[str, Any], make: Callable[[], Any]) -> Any:
        """The run of that key, made if it is not there."""
        text = json.dumps({**key, "threads": threads(), "machine": machine()}, sort_keys=True)
        if text not in self._runs:
            self._runs[text] = make()
            if self._path:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                with open(self._path, "a") as file:
                    file.write(json.dumps({"key": text, "run": self._runs[text]}) + "\n")
        return self._runs[text]
