"""A force law: the student's Python function with its state, which is checked and compiled on first use."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace

import numpy as np

from hapkit_studio.errors import LawError
from hapkit_studio.laws import drift, native
from hapkit_studio.laws.translate import checked, translate
from hapkit_studio.parameters import AnyParameter, Choice

MAX_PARAMETERS = 32
MAX_STATE = 16
_OWN = "hapkit_studio.environments."

StateValue = float | tuple[float, ...]


@dataclass(frozen=True)
class CompiledLaw:
    """The machine code of a law: its address, and the object that keeps the code in memory."""

    address: int
    initial_state: np.ndarray
    keepalive: object
    companion: "CompiledLaw | None" = None


class Law:
    """A force law: a function ``(p, s, x, v, dt)`` that returns a force in N, and its initial state."""

    def __init__(self, function: Callable, state: Mapping[str, StateValue] | None = None):
        self.function = function
        self.state = {key: _start(key, value) for key, value in (state or {}).items()}
        self.parameters: tuple[AnyParameter, ...] = ()
        self._source = ""
        # a second law, compiled and cached together with this law
        self.companion: Law | None = None
        self._compiled: CompiledLaw | None = None
        if len(self.state_names) > MAX_STATE:
            raise LawError(f"A law can have at most {MAX_STATE} state values, not {len(self.state_names)}.")

    def bind(self, parameters: Sequence[AnyParameter]) -> None:
        """Set the parameters and check the law; raise LawError if it does not belong to the law language.

        This translates a user's law at once. The studio's own laws are translated on first use, because tests
        have already checked them.
        """
        if len(parameters) > MAX_PARAMETERS:
            raise LawError(f"A law can have at most {MAX_PARAMETERS} parameters, not {len(parameters)}.")
        if self._source and self.parameters == tuple(parameters):
            return
        self.parameters = tuple(parameters)
        self._source, self._compiled = "", None
        if not getattr(self.function, "__module__", "").startswith(_OWN):
            self._source = translate(self.function, self.parameters, self.state)

    @property
    def source(self) -> str:
        """Return the source that numba compiles; ``bind`` must be called before."""
        self._source = self._source or translate(self.function, self.parameters, self.state)
        return self._source

    @property
    def state_names(self) -> tuple[str, ...]:
        names: list[str] = []
        for key, value in self.state.items():
            names += [f"{key}[{i}]" for i in range(len(value))] if isinstance(value, tuple) else [key]
        return tuple(names)

    @property
    def initial_state(self) -> np.ndarray:
        """Return the initial state, shape (number of values,)."""
        flat: list[float] = []
        for value in self.state.values():
            flat += list(value) if isinstance(value, tuple) else [value]
        return np.array(flat, dtype=float)

    @cached_property
    def remarks(self) -> tuple[drift.Remark, ...]:
        """Return remarks by line on drift in single precision, on board and in sketch.

        ``bind`` must be called before.
        """
        return drift.remarks(checked(self.function, self.parameters, self.state), self.state_names)

    def compiled(self) -> CompiledLaw:
        """Return the machine code; it is compiled on first use and kept in numba's cache."""
        if self._compiled is None:
            address, keepalive = native.load(self.source)
            companion = self.companion.compiled() if self.companion else None
            self._compiled = CompiledLaw(address, self.initial_state, keepalive, companion)
        return self._compiled

    def is_compiled(self) -> bool:
        """Return True if ``compiled`` needs only to load machine code, which takes milliseconds."""
        if self._compiled is not None:
            return True
        return native.is_compiled(self.source) and (self.companion is None or self.companion.is_compiled())

    def plain(self, values: Mapping[str, float], x: float, v: float, dt: float = 1e-3) -> float:
        """Return the force in N of the Python function in the initial state; NaN if the function fails."""
        return float(self.forces(values, np.array([x]), np.array([v]), dt)[0])

    def forces(
        self, values: Mapping[str, float], x: np.ndarray, v: np.ndarray, dt: float = 1e-3
    ) -> np.ndarray:
        """Return the forces (n,) in N of ``plain`` at positions in m and velocities in m/s.

        Positions and velocities broadcast together.
        """
        choices = {p.key: _Option(values[p.key], p) for p in self.parameters if isinstance(p, Choice)}
        p, function, forces = SimpleNamespace(**{**values, **choices}), self.function, []
        for place, speed in zip(*(a.tolist() for a in np.broadcast_arrays(x, v)), strict=True):
            state = {k: _Values(s) if isinstance(s, tuple) else s for k, s in self.state.items()}
            try:
                forces.append(float(function(p, SimpleNamespace(**state), place, speed, dt)))
            except (ArithmeticError, LookupError, TypeError, ValueError):
                forces.append(math.nan)
        return np.array(forces)


class _Option(float):
    """An option of a choice.

    It compares equal to the option's name, and in a helper function to the option's index.
    """

    def __new__(cls, value: float, choice: Choice):
        made = super().__new__(cls, value)
        made.name = choice.text(value)  # type: ignore[attr-defined]
        return made

    def __eq__(self, other):
        return self.name == other if isinstance(other, str) else float(self) == other  # type: ignore

    def __ne__(self, other):
        return not self == other

    __hash__ = float.__hash__


class _Values(list):
    """A state array with the index rule of laws: 0 <= index < size."""

    def __getitem__(self, i):
        return super().__getitem__(self._place(i))

    def __setitem__(self, i, value):
        super().__setitem__(self._place(i), value)

    def _place(self, i) -> int:
        if not 0 <= i < len(self):
            raise IndexError(i)
        return int(i)


def _start(key: str, value: object) -> StateValue:
    """Return the validated initial value of a state, a number or a tuple of numbers.

    Raise LawError for an invalid value.
    """
    several = isinstance(value, tuple | list)
    try:
        many = tuple(float(v) for v in (value if several else [value]))  # type: ignore
    except (TypeError, ValueError):
        many = ()
    if not many or not all(map(math.isfinite, many)):
        raise LawError(f"State {key!r} must start with one number or several numbers, not with {value!r}.")
    return many if several else many[0]


def law(function: Callable | None = None, *, state: Mapping[str, StateValue] | None = None):
    """Decorate a function ``(p, s, x, v, dt)`` as a force law; ``state`` contains the initial state."""
    if function is None:
        return lambda f: Law(f, state)
    return Law(function, state)
