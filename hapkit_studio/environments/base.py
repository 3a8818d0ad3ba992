"""The class ``Environment``: a force law with its parameters, texts and drawing."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import LawError, ParameterError
from hapkit_studio.laws import Law
from hapkit_studio.parameters import AnyParameter, resolve

Values = Mapping[str, float]
Curve = Callable[[Values, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Conditions(LoopSettings):
    """The loop settings of a scene, and the handle's recent maximum speed in m/s (0 if unknown)."""

    coulomb: float = 0.0
    speed: float = 0.0


@dataclass(frozen=True)
class ForceTerms:
    """Spring, damper and friction of a law at given values; an undefined value is None.

    ``stiffness`` is in N/m about ``centre`` in m, ``damping`` in N·s/m, ``friction`` in N. ``one_way`` is +1
    or -1 if damping acts only on motion to this side. ``contact`` is True if the terms act only while the law
    pushes. ``settle`` is the distance in m after a reversal until friction is fully developed. ``simple``
    is True if the law consists only of these terms. ``terms`` are the terms to identify.
    """

    stiffness: float | None = None
    damping: float | None = None
    friction: float | None = None
    centre: float | None = None
    one_way: float = 0.0
    contact: bool = False
    settle: float = 0.0
    simple: bool = True
    terms: tuple[str, ...] = ("stiffness", "damping", "friction")


def no_terms(values: Values) -> ForceTerms:
    """Return no terms, for a law whose impedance limits its stability but does not describe its force."""
    return ForceTerms(simple=False)


@dataclass(frozen=True)
class MovingObject:
    """An object that moves in addition to the handle: a short name, and the state that is its position in m.

    Without a state, the object rests at the position that a parameter sets, and the handle pushes it to the
    right. ``swing`` returns mass in kg, damping in N·s/m and stiffness in N/m in contact, which limit an
    integrator's step.
    """

    name: str
    state: str = ""
    rests: str = ""
    swing: Callable[[Values], tuple[float, float, float]] | None = None

    def place(self, values: Values, position: np.ndarray, state: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the object's position (n,) in m from the handle's position (n,) in m and the states."""
        return state[self.state] if self.state else np.maximum(position, values[self.rests])


@dataclass(frozen=True)
class Environment:
    """A virtual environment. A module in this folder declares its environment as ``ENVIRONMENT``.

    ``formula`` is short HTML; ``symbols`` says what its symbols mean. ``impedance`` maps values by name to
    the (stiffness N/m, damping N·s/m) that limit stability; it is None if there is no linear limit. ``terms``
    maps values to the terms for identification, by default the impedance. ``shades`` is True if contact is
    shaded in plots. ``check`` returns one line on why values are incompatible, "" if they are compatible.
    ``warnings`` returns warnings about effects that cannot be rendered well under given conditions.
    ``unused`` maps parameters that have no effect at the current values to the reason. ``over_position`` and
    ``over_velocity`` are theory curves, (n,) or one row per branch, NaN for gaps; by default they follow from
    the law. ``restless`` is the reason why the scene does not rest at its defaults, "" if it does. ``stored``
    is a law that returns the energy in J stored in objects. ``moves`` is the object whose position is
    plotted. ``drives`` describes how the scene generates energy. ``counts`` are states that count perceptible
    events. ``hands`` are the hands for judging the scene. ``needs`` are terms of the device whose absence is
    perceptible at the default values.
    """

    key: str
    title: str
    summary: str
    parameters: tuple[AnyParameter, ...]
    force: Law
    shortcut: str = ""
    formula: str = ""
    symbols: str = ""
    explanation: str = ""
    scene: str = ""
    impedance: Callable[[Values], tuple[float, float]] | None = None
    terms: Callable[[Values], ForceTerms] | None = None
    check: Callable[[Values], str] = lambda values: ""
    warnings: Callable[[Values, Conditions], Iterable[str]] = lambda values, conditions: ()
    unused: Callable[[Values], Mapping[str, str]] = lambda values: {}
    over_position: Curve | None = None
    over_velocity: Curve | None = None
    restless: str = ""
    stored: Law | None = None
    moves: MovingObject | None = None
    drives: str = ""
    shades: bool = False
    counts: tuple[str, ...] = ()
    hands: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    order: int = 100
    state_names: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "state_names", self.force.state_names)
        object.__setattr__(self, "scene", self.scene or self.key)
        self.force.bind(self.parameters)
        if self.moves is not None:
            known = {"state": self.state_names, "rests": [p.key for p in self.parameters]}
            kind = "state" if self.moves.state else "rests"
            if getattr(self.moves, kind) not in known[kind]:
                among = ", ".join(known[kind]) or "there is none"
                raise LawError(
                    f"The `{kind}` of the moving object {self.moves.name!r} must be one of: {among}."
                )
        if missing := set(self.counts) - set(self.state_names):
            raise LawError(
                f"`counts` has {min(missing)!r}, but each must be one of the states: "
                f"{', '.join(self.state_names)}."
            )
        if self.stored is not None:
            self.stored.bind(self.parameters)
            self.force.companion = self.stored

    @property
    def explained_formula(self) -> str:
        """Return the formula with the meaning of its symbols as HTML; "" without a formula."""
        return f"{self.formula}, with {self.symbols}." if self.symbols else self.formula

    def values(self, given: Mapping[str, object] | None = None) -> dict[str, float]:
        """Return every parameter's number; missing parameters have defaults.

        Raise ParameterError for an unknown name or an invalid value.
        """
        given = {} if given is None else given
        if not isinstance(given, Mapping):
            raise ParameterError(
                f"The parameters of {self.title} must be given by name, as {{key: value}}, not {given!r}."
            )
        numbers = resolve(self.parameters, given, self.title)
        values = {p.key: n for p, n in zip(self.parameters, numbers, strict=True)}
        if complaint := self.check(values):
            raise ParameterError(complaint)
        return values

    def changed(self, values: Values, changes: Mapping[str, object]) -> dict[str, float]:
        """Return valid values with some changes; raise ParameterError if one of the changes is invalid."""
        known = {p.key: p for p in self.parameters}
        for key in changes.keys() - known.keys():
            resolve(self.parameters, {key: changes[key]}, self.title)  # raises, because the key is unknown
        numbers = {**values, **{key: known[key].check(value) for key, value in changes.items()}}
        if complaint := self.check(numbers):
            raise ParameterError(complaint)
        return numbers

    def needed_at(self, values: Values) -> tuple[str, ...]:
        """Return the device properties, such as friction, that matter in the scene; () if they are unknown.

        They are known only at the default values.
        """
        return self.needs if all(values[p.key] == p.default for p in self.parameters) else ()

    def place(self, values: Values, position: np.ndarray, state: np.ndarray) -> np.ndarray | None:
        """Return the object's position (n,) in m; None for an environment without an object.

        ``position`` (n,) in m is the handle's position; ``state`` (n, values) contains the law's states.
        """
        named = dict(zip(self.state_names, state.T, strict=False))
        return None if self.moves is None else self.moves.place(values, position, named)

    def touched_at(self, values: Values, depth: float) -> float:
        """Return a position in m in contact with the scene: the centre, or ``depth`` inside the surface."""
        place = values.get("position", values.get("center", 0.0))
        if self.shades and "position" in values:
            place += depth if values.get("side", 0.0) == 0.0 else -depth
        return place

    def force_terms(self, values: Values) -> ForceTerms:
        """Return the spring, damper and friction of the law at these values."""
        if self.terms is not None:
            return self.terms(values)
        stiffness, damping = self.impedance(values) if self.impedance else (None, None)
        return ForceTerms(stiffness, damping, contact=self.shades, simple=False)

    def curve(self, values: Values, position: np.ndarray, velocity: np.ndarray | float = 0.0) -> np.ndarray:
        """Return the law's force (n,) in N at positions in m and velocities in m/s, in its initial state.

        Positions and velocities are of shape (n,) or (1,).
        """
        return self.force.forces(values, position, np.asarray(velocity))
