"""PySPH as a contender, in a process and an environment of its own."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

WORKER = Path(__file__).with_name("pysph_worker.py")


class PySPH:
    """Sums by PySPH with OpenMP.

    Args:
        interpreter: path of the Python that has PySPH.
        positions: of the agents, of shape (n, 2).
        core_radius: their core radius.
        threads: of OpenMP.
        ordered: whether its agents are kept in the order of its own cells, untimed.

    Raises:
        ValueError: if that interpreter cannot run PySPH; its last words are quoted.
    """

    limit = None

    def __init__(
        self,
        interpreter: str,
        positions: np.ndarray,
        core_radius: float,
        threads: int,
        ordered: bool = False,
    ):
        self._files = tempfile.TemporaryDirectory(prefix="apmethod-pysph-")
        self._folder = Path(self._files.name)
        self._interpreter = interpreter
        order = "ordered" if ordered else "given"
        try:
            with open(self._folder / "errors", "w") as errors:
                self._process = subprocess.Popen(
                    [interpreter, str(WORKER), repr(core_radius), order],
                    stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True,
                    env=os.environ | {"OMP_NUM_THREADS": str(threads)},
                )  # fmt: skip
        except OSError as error:
            raise ValueError(f"--pysph is {interpreter!r}, which cannot be run: {error}") from None
        self.threads = threads
        self.prepare(positions)
        self.note = f"sort and sums by {self._search}"

    def prepare(self, positions: np.ndarray) -> None:
        """Put the agents where they should be."""
        file = self._folder / "positions.npy"
        np.save(file, positions)
        self._search = self._ask({"positions": str(file)})["search"]

    def seconds(self) -> float:
        """Search and sum once; what its own clock says."""
        return self._ask({"run": True})["seconds"]

    def sums(self) -> tuple[np.ndarray, np.ndarray]:
        """Density and gradient after the last run."""
        file = self._folder / "sums.npz"
        self._ask({"sums": str(file)})
        with np.load(file) as found:
            return found["density"], found["gradient"]

    def pairs(self) -> int:
        """How many pairs its search finds."""
        return self._ask({"pairs": True})["pairs"]

    def close(self) -> None:
        """End the process."""
        self._process.stdin.close()
        self._process.wait()
        self._files.cleanup()

    def _ask(self, command: dict[str, Any]) -> dict[str, Any]:
        try:
            self._process.stdin.write(json.dumps(command) + "\n")
            self._process.stdin.flush()
            answer = self._process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        if not answer:
            said = (self._folder / "errors").read_text()
            words = said.strip().splitlines() or ["it said nothing"]
            raise ValueError(
                f"--pysph is {self._interpreter!r}, which failed: {words[-1]}; "
                "see apmethod bench sums --help for how to set it up"
            )
        return json.loads(answer)
