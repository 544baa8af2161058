"""The contenders of ``apmethod bench sums`` that run in this process.

Each has ``prepare(positions)``, untimed; ``seconds()``, which does its work once and
gives back how long that took; ``sums()``, density and gradient, or None if it only finds
pairs; ``pairs()``, their number, or None from those that the others are held against; and
``limit``, the largest number of agents at which waiting for it is reasonable.
"""

from __future__ import annotations

import importlib.util

import numpy as np

from apmethod import ParticleModel, set_threads
from apmethod.bench.mesa_spaces import SPACES
from apmethod.bench.population import exchange, put, take
from apmethod.bench.timing import stopwatch
from apmethod.compile import in_blocks

#: By how much the numbers of pairs may differ where a peer computes in single precision.
SINGLE = 1e-5


class Ours:
    """One perceive, contribute and message of a model, on a number of threads."""

    limit = None

    def __init__(self, model: ParticleModel, threads: int):
        self.model = model
        self.threads = threads
        self.note = "sort and sums of all agents"

    def prepare(self, positions: np.ndarray) -> None:
        """Put the agents where they should be."""
        put(self.model, positions)

    def seconds(self) -> float:
        """Sort and sum once."""
        set_threads(self.threads)
        # Threads are started by the first pass that needs them; a run has done so long ago.
        in_blocks(lambda first, last: None, self.threads, least=1)
        return stopwatch(lambda: exchange(self.model))

    def sums(self) -> tuple[np.ndarray, np.ndarray]:
        """Density and gradient after the last run."""
        return take(self.model, "density"), take(self.model, "density_gradient")

    def pairs(self) -> None:
        """The others' numbers of pairs are held against the lattice's."""
        return None

    def close(self) -> None:
        """Nothing to end."""


class PairSearch:
    """A peer that only finds pairs.

    Args:
        core_radius: two agents closer than this are neighbours.
    """

    limit: int | None = None
    threads = 1
    note = "pair search only"
    #: By how much, relative, its number of pairs may differ from the others'.
    tolerance = 0.0

    def __init__(self, core_radius: float):
        self.core_radius = core_radius

    def prepare(self, positions: np.ndarray) -> None:
        """Take the positions."""
        self.positions = positions

    def seconds(self) -> float:
        """Search once."""
        return stopwatch(self.search)

    def search(self) -> None:
        """Find all pairs."""
        raise NotImplementedError

    def sums(self) -> None:
        """It has none."""
        return None

    def pairs(self) -> int:
        """How many pairs the last search found."""
        return self.found

    def close(self) -> None:
        """Nothing to end."""


class KDTree(PairSearch):
    """SciPy's k-d tree: building it, and all pairs as an array.

    A tree that is not balanced, with whole nodes, builds fastest and searches as fast; the
    array is its fastest answer, faster on one thread than lists of neighbours are on two.
    """

    def search(self) -> None:
        """Find all pairs."""
        from scipy.spatial import cKDTree

        tree = cKDTree(self.positions, balanced_tree=False, compact_nodes=False)
        self.found = len(tree.query_pairs(self.core_radius, output_type="ndarray"))


class Freud(PairSearch):
    """freud's query of a tree of boxes, in single precision, on all of its threads."""

    limit = 64_000
    tolerance = SINGLE
    note = "neighbour list only, single precision"

    def __init__(self, core_radius: float, threads: int):
        import freud

        super().__init__(core_radius)
        self.threads = threads
        freud.parallel.set_num_threads(threads)
        # freud's box is periodic; this margin keeps its images out of reach.
        side = 1.0 + 2.0 * core_radius
        self._freud, self._box = freud, freud.box.Box(Lx=side, Ly=side, is2D=True)

    def prepare(self, positions: np.ndarray) -> None:
        """Take the positions as freud wants them."""
        self.positions = np.column_stack([positions, np.zeros(len(positions))]).astype("f4")

    def search(self) -> None:
        """Find the neighbours of all agents."""
        query = self._freud.locality.AABBQuery(self._box, self.positions)
        wanted = {"r_max": self.core_radius, "exclude_ii": True}
        self.found = len(query.query(self.positions, wanted).toNeighborList()) // 2


class MesaSpace(PairSearch):
    """One of Mesa's continuous spaces, every agent asking for its neighbours."""

    limit = 2000
    note = "neighbours of each agent only"

    def __init__(self, core_radius: float, name: str):
        super().__init__(core_radius)
        self._space = SPACES[name]

    def prepare(self, positions: np.ndarray) -> None:
        """Fill a new space with agents."""
        self._search = self._space(positions, self.core_radius, torus=False)

    def search(self) -> None:
        """Let every agent look around."""
        self.found = self._search() // 2


def installed_searches(core_radius: float, threads: int) -> dict[str, PairSearch]:
    """The peers in this environment, by name."""
    found: dict[str, PairSearch] = {"SciPy cKDTree": KDTree(core_radius)}
    if importlib.util.find_spec("freud"):
        found["freud AABBQuery"] = Freud(core_radius, threads)
    return found | {name: MesaSpace(core_radius, name) for name in SPACES}
