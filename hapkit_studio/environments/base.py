"""What an environment is: a force law with its parameters, its words and its picture's name."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.dynamics import sampled_loop
from hapkit_studio.dynamics.estimators import Spec, parse
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.errors import LawError, ParameterError
from hapkit_studio.laws import Law
from hapkit_studio.parameters import AnyParameter, resolve

Values = Mapping[str, float]
Curve = Callable[[Values, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Conditions:
    """What a scene is rendered with: period s, sensor quantum m, the device's damping N·s/m, speed m/s.

    speed is the handle's highest of late, delay s goes from sample to force, mass kg, coulomb N and max_force
    N are the device's: speed, delay and coulomb are 0 where they are unknown. estimator as in a loop.
    """

    period: float = 1e-3
    quantum: float = 20.7e-6
    viscous: float = 0.5
    speed: float = 0.0
    delay: float = 0.0
    mass: float = 0.044
    coulomb: float = 0.0
    max_force: float = 3.0
    estimator: Spec = "difference"

    def loop(self) -> sampled_loop.Loop:
        """Return the loop of a released handle, without what is rendered.

        An estimator that is not linear has no exact limit: the quickest one stands for it.
        """
        linear = parse(self.estimator)[0].response is not None
        estimator = self.estimator if linear else "difference"
        held, rate = Grip(0.0, 0.0, 0.0), 1.0 / self.period
        return sampled_loop.Loop(
            self.mass, self.viscous, held, 0.0, rate, self.delay, estimator, self.quantum
        )


@dataclass(frozen=True)
class ForceTerms:
    """The spring, damper and friction that a law asks for at given values; None for what it does not set.

    stiffness N/m about centre m, damping N·s/m, friction N. one_way: +1 or -1 where damping acts only on
    motion to that side; contact: only while the law pushes; settle: how far the handle goes after a turn
    until friction is all there, in m; simple: the law is no more than these numbers; terms: those that
    identification looks for.
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
    """Set nothing: for a law whose impedance bounds its stability but does not describe its force."""
    return ForceTerms(simple=False)


@dataclass(frozen=True)
class MovingObject:
    """What moves besides the handle: its name in a few letters, and the law's state that is its place in m.

    One without a state rests where a parameter says, and the handle pushes it to the right. swing: its mass
    kg, damping N·s/m and stiffness N/m in contact, which decide how long an integrator's step may be.
    """

    name: str
    state: str = ""
    rests: str = ""
    swing: Callable[[Values], tuple[float, float, float]] | None = None

    def place(self, values: Values, position: np.ndarray, state: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return where it is in m (n,): the handle's position is in m, each state by name, (n,) all."""
        return state[self.state] if self.state else np.maximum(position, values[self.rests])


@dataclass(frozen=True)
class Environment:
    """One virtual environment; its file in this folder is found by the name ``ENVIRONMENT``.

    formula is short HTML; impedance maps named values to the (stiffness N/m, damping N·s/m) that bound
    stability, None where no linear limit applies; terms maps them to what identification compares with, the
    impedance where it is None; shades says whether contact is shaded in the plots.
    check says in one line why values do not go together, "" where they do; warnings says what cannot be
    rendered well under given conditions; unused maps each parameter without effect on the force as the others
    are set to the words that say so. over_position and over_velocity return the theory drawn beneath the
    data, (n,) or one row a branch, nan where there is none; without them it is the law at rest. restless says
    why the scene with its defaults does not come to rest, "" where it does. stored is a law of the energy in
    J that objects hold and may give back; moves is an object whose place is plotted; drives says in words
    that a scene gives energy by itself. counts are states that count events a person notices; hands are those
    that the scene is judged by, needs the device
    terms whose absence is felt with the default values.
    """

    key: str
    title: str
    summary: str
    parameters: tuple[AnyParameter, ...]
    force: Law
    shortcut: str = ""
    formula: str = ""
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
                raise LawError(f"{self.moves.name}: its `{kind}` is one of {among}.")
        if missing := set(self.counts) - set(self.state_names):
            raise LawError(
                f"`counts` are among the states {', '.join(self.state_names)}, not {min(missing)!r}."
            )
        if self.stored is not None:
            self.stored.bind(self.parameters)
            self.force.companion = self.stored

    def values(self, given: Mapping[str, object] | None = None) -> dict[str, float]:
        """Return every parameter's number, defaults filled in; raise ParameterError."""
        given = {} if given is None else given
        if not isinstance(given, Mapping):
            raise ParameterError(
                f"{self.title} takes its parameters by name, as {{key: value}}, not {given!r}."
            )
        numbers = resolve(self.parameters, given, self.title)
        values = {p.key: n for p, n in zip(self.parameters, numbers, strict=True)}
        if complaint := self.check(values):
            raise ParameterError(complaint)
        return values

    def needed_at(self, values: Values) -> tuple[str, ...]:
        """Return the device's terms that it needs; () where nobody has looked, as at other values."""
        return self.needs if all(values[p.key] == p.default for p in self.parameters) else ()

    def place(self, values: Values, position: np.ndarray, state: np.ndarray) -> np.ndarray | None:
        """Return where its object is in m (n,) at positions (n,) and states (n, values), None without one."""
        named = dict(zip(self.state_names, state.T, strict=False))
        return None if self.moves is None else self.moves.place(values, position, named)

    def touched_at(self, values: Values, depth: float) -> float:
        """Return a place in m where a hand touches a scene: its centre, or so deep in its surface."""
        place = values.get("position", values.get("center", 0.0))
        if self.shades and "position" in values:
            place += depth if values.get("side", 0.0) == 0.0 else -depth
        return place

    def force_terms(self, values: Values) -> ForceTerms:
        """Return the spring, damper and friction that the law asks for at these values."""
        if self.terms is not None:
            return self.terms(values)
        stiffness, damping = self.impedance(values) if self.impedance else (None, None)
        return ForceTerms(stiffness, damping, contact=self.shades, simple=False)

    def curve(self, values: Values, position: np.ndarray, velocity: np.ndarray | float = 0.0) -> np.ndarray:
        """Return the law's force (n,) in N at positions in m and velocities in m/s, its state at the start.

        Positions and velocities are of shape (n,) or (1,).
        """
        return self.force.forces(values, position, np.asarray(velocity))
