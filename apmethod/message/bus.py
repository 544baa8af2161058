"""The message bus: each pair's contribution is computed once and both ends get it.

In Python, an agent that has computed a pair posts the other end its half, and the other
one, finding that message, does not compute the pair again (paper 2.3).  In the compiled
tier the bus sums for the whole population at once.  Both leave the same sums, and an
agent cannot tell from what it reads which of the two its neighbours used.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numba.core.errors import NumbaError

from apmethod.compile import in_blocks, memory
from apmethod.contribute.smoothing import Kernel
from apmethod.contribute.terms import Term, odd_columns, pair_maker
from apmethod.message.passes import BEST_EVALUATION, EVALUATIONS, RoundPass
from apmethod.particles import Particles
from apmethod.perceive.cells import SortedCells
from apmethod.perceive.lattice import QuadLattice
from apmethod.perceive.lists import NeighbourLists, neighbour_lists

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle

Message = tuple[float, ...]
#: Agents whose sums are copied so quickly that another thread does not pay for fewer.
_MANY = 50_000


class MessageBus:
    """Exchanges a scene's terms over the pairs that its agents perceive.

    Args:
        particles: the agents' table; columns for the terms' sums are added to it.
        space: the lattice the agents perceive in.
        kernel: smoothing kernel of all terms.
        terms: what is exchanged, in any order.  A term that reads what another one
            delivers is exchanged in a later round.
        evaluation: how compiled sums are taken, "gathered", "scattered" or "stored"; "auto"
            takes the quickest one, `BEST_EVALUATION`.

    Raises:
        ValueError: for an unknown evaluation, or a term that does not hold its parity,
            reads a column that nobody has, or waits for itself.
    """

    def __init__(
        self,
        particles: Particles,
        space: QuadLattice,
        kernel: Kernel,
        terms: Sequence[Term],
        evaluation: str = "auto",
    ):
        self.particles = particles
        self.space = space
        self.kernel = kernel
        self._pair = pair_maker(kernel)
        self.rounds = _rounds(terms)
        for term in terms:
            particles.declare(term.name, term)
        self._check(terms)
        if evaluation not in ("auto", *EVALUATIONS):
            choice = ", ".join(map(repr, EVALUATIONS))
            raise ValueError(f"evaluation is {evaluation!r}; it must be 'auto', {choice}")
        #: How compiled sums are taken.
        self.evaluation = BEST_EVALUATION if evaluation == "auto" else evaluation
        if space.own_radii:
            self._check_own_radii()
        self._odd = odd_columns(terms)
        self._passes = [
            RoundPass(each, kernel, particles, self.evaluation, self._odd) for each in self.rounds
        ]
        self._lists: tuple[SortedCells | None, NeighbourLists | None] = (None, None)
        self.close()

    @property
    def smoothing_length(self) -> float:
        """h of the kernel: the (largest) core radius over the kernel's support."""
        return self.space.core_radius / self.kernel.support

    @property
    def shortest_length(self) -> float:
        """The smallest h of any agent: what limits the time step."""
        return self.space.smallest_radius / self.kernel.support

    # -- one round ---------------------------------------------------------------------

    def open(self, number: int) -> None:
        """Begin round ``number`` with nothing sent."""
        #: The terms that are being exchanged.
        self.terms: tuple[Term, ...] = self.rounds[number]
        self._pass = self._passes[number]
        self._begun: np.ndarray | None = None
        self._mail: dict[AgentParticle, dict[AgentParticle, Message]] = {}

    def close(self) -> None:
        """End the round and drop its messages."""
        self.terms = ()
        self._begun = None
        self._mail = {}

    @property
    def _sums(self) -> np.ndarray:
        """What each agent has been sent in all, of shape (agents, width); zeros at first."""
        if self._begun is None:
            self._begun = self._empty_sums()
            self._begun.fill(0.0)
        return self._begun

    def _empty_sums(self) -> np.ndarray:
        # Part by part in memory, as the columns are that sums are delivered to.
        return memory.empty((self._pass.width, len(self.particles))).T

    def contribute_all(self, cells: SortedCells, rows: np.ndarray | None = None) -> None:
        """Sum the contributions among the agents in ``cells``, compiled.

        ``rows`` are the table's rows that the cells were made from, None for all.
        """
        if rows is None:
            self._begun = self._empty_sums()  # each of them is about to be written
        try:
            sights = self.space.sights_of(cells)
            self._pass(cells, self._lists_of(cells), self._sums, rows, sights)
        except NumbaError as error:
            names = ", ".join(term.name for term in self.terms)
            error.add_note(
                f"compiling terms {names}; their formulas must be Python that numba compiles, or "
                "run the scene with tier='agents'"
            )
            raise

    def _lists_of(self, cells: SortedCells) -> NeighbourLists | None:
        """The neighbours listed, once for each search; None where nobody needs the list."""
        if self.evaluation != "stored":
            return None
        cells = cells.searched or cells
        if self._lists[0] is not cells:
            self._lists = (cells, neighbour_lists(cells))
        return self._lists[1]

    def deliver_all(self, rows: np.ndarray | None = None) -> None:
        """Write the sums to the columns, for all agents or those in ``rows``."""
        for part, column in enumerate(self._columns()):
            if rows is None:
                in_blocks(_copy, len(column), self._sums[:, part], column, least=_MANY)
            else:
                column[rows] = self._sums[rows, part]

    # -- one agent ---------------------------------------------------------------------

    def exchange(self, agent: AgentParticle, other: AgentParticle) -> tuple[Message, Message]:
        """Compute a pair once: what ``agent`` gets from ``other``, and the other's half."""
        dx, dy = self.space.displacement(agent, other)
        pair = self._pair(dx, dy, self.space.radius_between(agent, other) / self.kernel.support)
        mine: list[float] = []
        theirs: list[float] = []
        for term in self.terms:
            values = term.values(pair, agent, other)
            if term.sign:
                back = tuple(term.sign * value for value in values)
            else:
                back = term.values(pair.mirrored(), other, agent)
            mine += self._weighed(term, values, sender=other)
            theirs += self._weighed(term, back, sender=agent)
        return tuple(mine), tuple(theirs)

    def own(self, agent: AgentParticle) -> Message:
        """What nobody sends: the agent's part of its own sums, and that of mirror images.

        The first goes to the terms that count the agent in; the second comes from beyond
        walls and the mirrored sides of the domain, if there are any.
        """
        pair = self._pair(0.0, 0.0, self.space.radius_of(agent) / self.kernel.support)
        message: list[float] = []
        for term in self.terms:
            if term.own:
                message += self._weighed(term, term.values(pair, agent, agent), sender=agent)
            else:
                message += [0.0] * (term.components or 1)
        if self.space.mirrors:
            return tuple(np.add(message, self.reflected(agent)))
        return tuple(message)

    def reflected(
        self, agent: AgentParticle, senders: Container[AgentParticle] | None = None
    ) -> np.ndarray:
        """What the mirror images of ``senders``, None for all agents, give ``agent``."""
        total = np.zeros(self._pass.width)
        for other, dx, dy, sign in self.space.mirrored_near(agent):
            if senders is None or other in senders:
                reach = self.space.radius_between(agent, other)
                pair = self._pair(dx, dy, reach / self.kernel.support)
                image = other if sign > 0 else _Opposite(other, self._odd)
                message: list[float] = []
                for term in self.terms:
                    # Terms that are not weighed by the mass know of no negative one.
                    if sign > 0 or term.weight in self._odd:
                        message += self._weighed(term, term.values(pair, agent, image), image)
                    else:
                        message += [0.0] * (term.components or 1)
                total += message
        return total

    def post(self, sender: AgentParticle, receiver: AgentParticle, message: Message) -> None:
        """Send ``message``, one number for each part of each term, to ``receiver``."""
        self._must_be_open()
        self._mail.setdefault(receiver, {})[sender] = message
        self._sums[self.particles.row(receiver)] += message

    def add_reflected(self, agent: AgentParticle, senders: Container[AgentParticle]) -> None:
        """Add to a compiled agent's sums what mirror images of agents in Python give it."""
        self._sums[self.particles.row(agent)] += self.reflected(agent, senders)

    def received(self, receiver: AgentParticle, sender: AgentParticle) -> bool:
        """Whether ``sender`` has sent ``receiver`` a message in this round."""
        return sender in self._mail.get(receiver, ())

    def messages(self, agent: AgentParticle) -> dict[AgentParticle, Message]:
        """The messages posted to ``agent`` in this round, by sender."""
        return dict(self._mail.get(agent, {}))

    def read(self, agent: AgentParticle) -> dict[str, float | np.ndarray]:
        """What all messages to ``agent`` add up to, by name of the term."""
        self._must_be_open()
        sums = self._sums[self.particles.row(agent)]
        return {term.name: sums[part] for term, part in self._parts()}

    def _columns(self) -> Iterator[np.ndarray]:
        """The columns that sums go to, vectors axis by axis: a sixth of the time of all at once."""
        for term in self.terms:
            column = self.particles.array(term.name)
            yield from (column,) if term.components is None else column.T

    def _must_be_open(self) -> None:
        if not self.terms:
            raise RuntimeError(
                "messages are exchanged in a round; call model.bus.open(0) first, or model.step()"
            )

    def _parts(self) -> list[tuple[Term, int | slice]]:
        """Each term of the round with its place in a message."""
        parts, place = [], 0
        for term in self.terms:
            width = term.components or 1
            parts.append((term, place if term.components is None else slice(place, place + width)))
            place += width
        return parts

    @staticmethod
    def _weighed(term: Term, values: Message, sender: AgentParticle) -> list[float]:
        weight = getattr(sender, term.weight) if term.weight else 1.0
        return [weight * value for value in values]

    def _check_own_radii(self) -> None:
        if self.space.obstacles is not None and self.space.obstacles.contributions != "through":
            raise ValueError(
                "agents have core radii of their own, and walls that agents do not feel each "
                "other through take one for all; give Obstacles(..., contributions='through')"
            )

    def _check(self, terms: Sequence[Term]) -> None:
        widths = {name: column.components for name, column in self.particles.columns.items()}
        for term in terms:
            for name in term.columns:
                if name not in widths:
                    raise ValueError(
                        f"term {term.name!r} reads column {name!r}, which no agent class "
                        f"declares and no term delivers; there are {', '.join(widths)}"
                    )
            term.check(widths)


def _copy(first: int, last: int, values: np.ndarray, column: np.ndarray) -> None:
    column[first:last] = values[first:last]


class _Opposite:
    """An agent's image in a wall that absorbs, as a formula reads it."""

    def __init__(self, agent: AgentParticle, odd: frozenset[str]):
        self._agent, self._odd = agent, odd

    def __getattr__(self, name: str):
        value = getattr(self._agent, name)
        return -value if name in self._odd else value


def _rounds(terms: Sequence[Term]) -> list[tuple[Term, ...]]:
    """Group terms so that each comes after those that deliver what it reads."""
    waiting = {term.name: term for term in terms}
    rounds = []
    while waiting:
        ready = [
            term
            for term in waiting.values()
            if not any(name in waiting and name != term.name for name in term.columns)
            and term.name not in term.columns
        ]
        if not ready:
            raise ValueError(
                f"terms {', '.join(waiting)} wait for each other's sums; break the circle by "
                "keeping one of them in a column of its own"
            )
        rounds.append(tuple(ready))
        for term in ready:
            del waiting[term.name]
    return rounds
