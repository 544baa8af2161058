"""The columns behind the agents: `Column` declares one, `Particles` holds them all.

An agent's attribute is a place in a column, so that one agent reads and writes plain
values and a compiled step reads and writes whole arrays of the same memory.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from apmethod.agent import AgentParticle


class Column:
    """An attribute of an agent class that is stored as a column.

    ::

        class Cell(AgentParticle):
            energy = Column(start=1.0, unit="J", minimum=0.0)
            heading = Column(2)

    On an agent it reads and writes that agent's row.  A vector is handed out as a
    read-only copy: assign a new one instead of changing it in place.

    Args:
        components: number of components of a vector, or None for a scalar.
        dtype: numpy type of the stored values.
        start: value of an agent that is created without one.
        unit: physical unit, for people.
        minimum: smallest value accepted.
        kept: False for a column that exists only in scenes whose procedure fills it
            (a sum delivered by the message bus); it is not part of an agent's state.
        like: name of a column that a new agent's value is taken from instead of ``start``.
    """

    def __init__(
        self,
        components: int | None = None,
        *,
        dtype: type = float,
        start: float | Sequence[float] = 0.0,
        unit: str = "",
        minimum: float | None = None,
        kept: bool = True,
        like: str | None = None,
    ):
        self.components = components
        self.dtype = np.dtype(dtype)
        self.start = start
        self.unit = unit
        self.minimum = minimum
        self.kept = kept
        self.like = like
        self.name = ""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one agent's value."""
        return () if self.components is None else (self.components,)

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = self.name or name

    def __get__(self, agent: AgentParticle | None, owner: type | None = None) -> Any:
        if agent is None:
            return self
        table = agent.model.particles
        value = table.array(self.name)[table.row(agent)]
        if self.components is None:
            return value.item()
        value = value.copy()  # a view would change under whoever keeps it
        value.flags.writeable = False
        return value

    def __set__(self, agent: AgentParticle, value: Any) -> None:
        table = agent.model.particles
        row = table.row(agent)
        table.array(self.name)[row] = self.checked(value, 1)[0]

    def checked(self, values: Any, count: int) -> np.ndarray:
        """``values`` as an array of ``count`` rows.

        One value serves all agents; otherwise there must be one for each.

        Raises:
            ValueError: for a wrong shape, a value that is not finite or below the
                minimum; it names the column, the value and what would be right.
        """
        try:
            array = np.asarray(values, self.dtype)
        except (TypeError, ValueError):
            kind = "number" if self.components is None else f"{self.components}-vector"
            raise ValueError(f"{self.name} is {values!r}; it must be a {kind}") from None
        if array.shape == self.shape:
            array = np.broadcast_to(array, (count, *self.shape))
        elif array.shape != (count, *self.shape):
            raise ValueError(
                f"{self.name} has shape {array.shape}; it must be {self.shape} for one value "
                f"or {(count, *self.shape)} for one each of {count} agents"
            )
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            self._refuse(array, ~np.isfinite(array), "finite")
        if self.minimum is not None and (array < self.minimum).any():
            self._refuse(array, array < self.minimum, f"{self.minimum:g} or more")
        return array

    def _refuse(self, array: np.ndarray, bad: np.ndarray, wanted: str) -> None:
        first = int(np.argwhere(bad)[0, 0])
        raise ValueError(
            f"{self.name} is {array[first]} (agent {first} of {len(array)} given); "
            f"it must be {wanted}"
        )


class Particles:
    """The table of all agents of a model: one array a column, one row an agent.

    ``particles.mass`` is the column as a read-only array of the agents' rows;
    ``particles.agents`` are the agents in the same order.  Rows move when agents are
    removed; an agent finds its own through a handle that stays right.
    """

    def __init__(self) -> None:
        self.columns: dict[str, Column] = {}
        self.checks: dict[str, Callable[[np.ndarray], None]] = {}
        self.changes = 0  # grows when agents come or go, so that others can notice
        self._arrays: dict[str, np.ndarray] = {}
        self._agents: list[AgentParticle] = []
        self._classes: list[type] = []
        self._kind = np.zeros(0, np.int16)  # which class, by row

    def __len__(self) -> int:
        return len(self._agents)

    def __getattr__(self, name: str) -> np.ndarray:
        if name.startswith("_") or name not in self._arrays:
            raise AttributeError(self._no_column(name))
        view = self.array(name)[:]
        view.flags.writeable = False
        return view

    def __contains__(self, name: str) -> bool:
        return name in self._arrays

    @property
    def names(self) -> list[str]:
        """Names of the columns, without those that steps use as scratch."""
        return [name for name in self.columns if not name.startswith("_")]

    @property
    def agents(self) -> tuple[AgentParticle, ...]:
        """The agents in the order of their rows."""
        return tuple(self._agents)

    @property
    def classes(self) -> tuple[type, ...]:
        """The agent classes whose columns the table has, in order of arrival."""
        return tuple(self._classes)

    def array(self, name: str) -> np.ndarray:
        """The agents' rows of a column, writable: for compiled passes and skills."""
        try:
            return self._arrays[name][: len(self._agents)]
        except KeyError:
            raise AttributeError(self._no_column(name)) from None

    def row(self, agent: AgentParticle) -> int:
        """The row of ``agent``.

        Raises:
            ValueError: if the agent has been removed.
        """
        if agent._row is None:
            raise ValueError(f"agent {agent.unique_id} has been removed from its model")
        return agent._row

    def rows_of(self, *classes: type) -> np.ndarray:
        """Rows of the agents whose class is exactly one of ``classes``."""
        kinds = [self._classes.index(cls) for cls in classes if cls in self._classes]
        return np.flatnonzero(np.isin(self._kind[: len(self)], kinds))

    def assign(self, name: str, values: Any) -> None:
        """Set a whole column, checked as an agent's attribute is."""
        values = self.columns[name].checked(values, len(self))
        if name in self.checks:
            self.checks[name](values)
        self.array(name)[:] = values

    def declare(self, name: str, column: Column) -> None:
        """Make sure that a column exists; one of the same name must have the same shape."""
        column.name = column.name or name
        known = self.columns.get(name)
        if known is None:
            self.columns[name] = column
            self._arrays[name] = np.full(
                (len(self._kind), *column.shape), column.start, column.dtype
            )
        elif known.shape != column.shape:
            raise ValueError(
                f"column {name!r} is declared with shapes {known.shape} and {column.shape}; "
                "rename one of them"
            )

    def declare_class(self, cls: type) -> None:
        """Add the kept columns that an agent class declares."""
        if cls in self._classes:
            return
        for owner in reversed(cls.__mro__):
            for name, column in vars(owner).items():
                if isinstance(column, Column) and column.kept:
                    self.declare(name, column)
        self._classes.append(cls)

    def checked(self, cls: type, count: int, values: Mapping[str, Any]) -> dict[str, np.ndarray]:
        """Columns of ``count`` new agents of ``cls``, refused here or not at all."""
        if cls not in self._classes:
            self._check_exchanged(cls)
            self.declare_class(cls)
        unknown = [name for name in values if not isinstance(getattr(cls, name, None), Column)]
        if unknown:
            declared = ", ".join(
                n for n in self.columns if isinstance(getattr(cls, n, None), Column)
            )
            raise TypeError(f"{cls.__name__} has no column {unknown[0]!r}; it has {declared}")
        arrays = {name: self.columns[name].checked(v, count) for name, v in values.items()}
        for name in arrays.keys() & self.checks.keys():
            self.checks[name](arrays[name])
        return arrays

    def _check_exchanged(self, cls: type) -> None:
        """Refuse a class that came too late for the terms it declares."""
        for owner in cls.__mro__:
            for name, column in vars(owner).items():
                if getattr(column, "parity", None) and self.columns.get(name) is not column:
                    raise ValueError(
                        f"{cls.__name__} declares term {name!r}, which this model does not "
                        f"exchange; name {cls.__name__} among its agent_classes"
                    )

    def append(self, agents: Sequence[AgentParticle], values: Mapping[str, np.ndarray]) -> None:
        """Give each of ``agents`` (all of one class) a row, with `checked` values."""
        first, last = len(self._agents), len(self._agents) + len(agents)
        if last > len(self._kind):
            self._grow(max(last, 2 * first))
        for name, array in self._arrays.items():
            column = self.columns[name]
            start = self._arrays[column.like][first:last] if column.like else column.start
            array[first:last] = values.get(name, start)
        if agents:
            self._kind[first:last] = self._classes.index(type(agents[0]))
        for row, agent in enumerate(agents, first):
            agent._row = row
        self._agents.extend(agents)
        self.changes += 1

    def remove(self, agent: AgentParticle) -> None:
        """Take an agent's row away; the last row moves into its place."""
        row, last = self.row(agent), len(self._agents) - 1
        moved = self._agents[last]
        for array in (self._kind, *self._arrays.values()):
            array[row] = array[last]
        self._agents[row] = moved
        moved._row = row
        self._agents.pop()
        agent._row = None
        self.changes += 1

    def remove_all(self, agents: Collection[AgentParticle]) -> None:
        """Take the rows of many agents away; the others move up, in the order they had."""
        stays = np.ones(len(self), bool)
        stays[[self.row(agent) for agent in agents]] = False
        for agent in agents:
            agent._row = None
        self.reorder(np.flatnonzero(stays))
        self.changes += 1

    def reorder(self, order: np.ndarray) -> None:
        """Put the agents of rows ``order`` into rows 0, 1, 2, ...; their handles follow."""
        for array in (self._kind, *self._arrays.values()):
            array[: len(order)] = array[order]
        self._agents = [self._agents[row] for row in order.tolist()]
        for row, agent in enumerate(self._agents):
            agent._row = row

    def state(self) -> dict[str, np.ndarray]:
        """Copies of all columns but a step's scratch: where a failed step goes back to."""
        return {
            name: self.array(name).copy()
            for name, column in self.columns.items()
            if column.kept or not name.startswith("_")
        }

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Put back what `state` gave."""
        for name, values in state.items():
            self.array(name)[:] = values

    def first_not_finite(self) -> tuple[str, AgentParticle] | None:
        """The first column with a NaN or infinity, and an agent that has it; or None."""
        # Position last: a NaN gets there from a sum, which is what one wants to know.
        for name, column in sorted(self.columns.items(), key=lambda item: item[0] == "position"):
            if name.startswith("_"):
                continue
            values = self.array(name)
            # A sum is one quick pass, and NaN and infinity do not vanish from it.
            if column.dtype.kind == "f" and not np.isfinite(values.sum()):
                bad = np.argwhere(~np.isfinite(values))
                if len(bad):
                    return name, self._agents[bad[0, 0]]
        return None

    def _grow(self, capacity: int) -> None:
        self._kind = np.resize(self._kind, capacity)
        for name, old in self._arrays.items():
            new = np.empty((capacity, *old.shape[1:]), old.dtype)
            new[: len(self)] = old[: len(self)]
            self._arrays[name] = new

    def _no_column(self, name: str) -> str:
        return f"this scene has no column {name!r}; it has {', '.join(self.names) or 'none'}"
