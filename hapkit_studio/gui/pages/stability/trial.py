"""A trial: it releases the handle away from its rest position, and reports how the handle moved."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.analysis.stability.behaviour import Behaviour, Centre
from hapkit_studio.dynamics.hand import grip_named
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.theme import number
from hapkit_studio.parameters import Parameter
from hapkit_studio.quantity import Quantity

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live


# m: minimum and maximum starting distance of a trial; starting distance if the handle settles after pushes
# of every size
LEAST, MOST, USUAL = 0.001, 0.020, 0.005
# If the handle does not settle after every push, the starting distance is the largest push after which it
# settles, times _TIMES, plus _MORE (m).
_TIMES, _MORE = 2.0, 0.0005


@dataclass(frozen=True)
class TrialConditions:
    """The verdict on a released handle, and the position at which the handle is released.

    The stiffness is in N/m, the force limit in N, the sensor step in m.
    """

    does: Behaviour
    centre: Centre
    stiffness: float
    force: float
    quantum: float


def starting_distance(does: Behaviour) -> float:
    """Return the distance in m from the rest position at which a trial releases the handle.

    If the handle does not settle after every push, the distance is larger than the largest push after which
    it settles.
    """
    if does.calm or does.flick:
        return USUAL
    return min(max(_TIMES * does.push + _MORE, LEAST), MOST)


_UNITS = ("N/m", "N·s/m")
# Fractions of a parameter's range. A parameter sets stiffness or damping if its value equals the impedance's
# stiffness or damping at both fractions.
_PROBES = (0.3, 0.6)


@dataclass(frozen=True)
class MapParameters:
    """The parameters that set stiffness and damping.

    Each is None if the environment has no such parameter.
    """

    stiffness: Parameter | None
    damping: Parameter | None

    def values(self, stiffness: float, damping: float) -> dict[str, float]:
        """Return the parameters' values for a point of the map, rounded to steps and within their limits."""
        found = {}
        for parameter, value in ((self.stiffness, stiffness), (self.damping, damping)):
            if parameter is not None:
                quantity = Quantity(parameter)
                found[parameter.key] = quantity.si(quantity.on_step(value * quantity.factor))
        return found

    @property
    def text(self) -> str:
        """Describe the effect of a click on the map."""
        if self.stiffness and self.damping:
            return "Click the map to set stiffness and damping there. Ctrl+Z undoes it."
        if self.stiffness or self.damping:
            name = (self.stiffness or self.damping).label.lower()  # type: ignore[union-attr]
            return f"Click the map to set the {name}. This environment has no slider for the other axis."
        return (
            "This environment has no slider for stiffness or damping. Choose Spring or Wall to set "
            "them by clicking the map."
        )


def map_parameters(environment: Environment, values: Values) -> MapParameters:
    """Return the parameters whose values are the impedance's stiffness and damping."""
    impedance = environment.impedance

    def sets(parameter: Parameter, which: int) -> bool:
        tried = [parameter.low + share * (parameter.high - parameter.low) for share in _PROBES]
        return impedance is not None and all(
            impedance({**values, parameter.key: value})[which] == value for value in tried
        )

    numbers = [p for p in environment.parameters if isinstance(p, Parameter)]
    found = [
        next((p for p in numbers if p.unit == unit and sets(p, which)), None)
        for which, unit in enumerate(_UNITS)
    ]
    return MapParameters(*found)


# s: lengths of the first and the last interval after the release; the motions in these intervals are compared
_BEGIN, _END = 0.2, 0.4
# A handle that moves by at most _STEPS sensor steps is at rest. A change of the amplitude by the factor _GREW
# is significant.
_STEPS, _GREW = 3.0, 1.15
_LEAST_STEP = 20e-6
_THROWN = (
    "The wall has pushed the handle away, and nothing brings the handle back. Choose Spring to see the "
    "handle buzz or come to rest."
)


@dataclass(frozen=True)
class Released:
    """The motion after a release: position (n,) in m relative to the rest position, over time (n,) in s."""

    time: np.ndarray
    position: np.ndarray

    @property
    def begin(self) -> float:
        """Return the largest distance from the rest position in m soon after the release."""
        return float(np.abs(self.position[self.time <= self.time[0] + _BEGIN]).max())

    @property
    def end(self) -> float:
        """Return half the peak-to-peak motion in m at the end of the trial."""
        return 0.5 * float(np.ptp(self.position[self.time >= self.time[-1] - _END]))


def outcome_text(seen: Released, conditions: TrialConditions) -> str:
    """Describe the outcome, and say whether it agrees with the verdict."""
    if len(seen.time) < 2:
        return ""
    if conditions.centre.pushes:
        return _THROWN
    rests = seen.end <= _STEPS * max(conditions.quantum, _LEAST_STEP)
    size = f"±{number(1e3 * seen.end, 1)} mm"
    if not rests and seen.end < seen.begin / _GREW:
        return f"The motion is still decaying. It is {size} now."
    settles = seen.begin <= conditions.does.push or conditions.does.flick > 0.0
    agrees = "as was predicted" if rests == settles else "which was not predicted"
    grew = "The motion grew to" if seen.end > _GREW * seen.begin else "The handle keeps oscillating by"
    return f"The handle came to rest, {agrees}." if rests else f"{grew} {size}, {agrees}."


# ms: how long the hand holds the handle, and how long the handle is observed after the release
_HOLD_MS, _WATCH_MS = 700, 1500
_GRIP = "medium"
# m: maximum distance of the hand's target
_FARTHEST = 0.045


class Trial(QObject):
    """Pulls the handle with the simulated hand, then releases it; emits ``changed`` on every change.

    ``holding`` is true while the hand holds the handle. ``report`` describes the last release.
    """

    changed = Signal()

    def __init__(self, studio: Studio, live: "Live", parent: QObject | None = None):
        super().__init__(parent)
        self._studio, self._live = studio, live
        self._grip: str | None = None
        self._conditions: TrialConditions | None = None
        self._since = 0.0
        self.holding, self.report = False, ""
        self._timer = QTimer(self, singleShot=True, interval=_HOLD_MS)
        self._timer.timeout.connect(self._release)
        self._watch = QTimer(self, singleShot=True, interval=_WATCH_MS)
        self._watch.timeout.connect(self.judge)
        for signal in (studio.engine_changed, studio.environment_changed):
            signal.connect(self.let_go)
            signal.connect(self.forget)
        studio.values_changed.connect(self.forget)

    @property
    def possible(self) -> bool:
        """Return whether there is a handle that the simulated hand can move."""
        return self._studio.engine is not None and self._studio.hand_is_ours

    def begin(self, conditions: TrialConditions) -> None:
        """Pull the handle away from its rest position."""
        if not self.possible or self.holding:
            return
        self.forget()
        self._conditions = conditions
        if self._studio.grip == "released":
            self._grip = self._studio.grip
            with self._studio.temporarily():
                self._studio.set_loop(hand=_GRIP)
        self._studio.move_hand(self._target(conditions))
        self.holding = True
        self._timer.start()
        self.changed.emit()

    def let_go(self) -> None:
        """Release the handle and restore the grip."""
        if self.holding:
            self.holding = False
            self._timer.stop()
            self._studio.move_hand(None)
        if self._grip is not None:
            grip, self._grip = self._grip, None
            with self._studio.temporarily():
                self._studio.set_loop(hand=grip)
        self.changed.emit()

    def forget(self) -> None:
        """Clear the report on the last release."""
        self._watch.stop()
        if self.report:
            self.report = ""
            self.changed.emit()

    def judge(self) -> None:
        """Compare the handle's motion since its release with the verdict, and report the result."""
        if self._conditions is None:
            return
        window = self._live.history.between(self._since, math.inf)
        known = np.isfinite(window.y["position"])
        position = window.y["position"][known] - self._conditions.centre.position
        self.report = outcome_text(Released(window.x[known], position), self._conditions)
        self.changed.emit()

    def _release(self) -> None:
        """Release the handle and record its motion."""
        self._since = self._live.history.now
        self.let_go()
        self._watch.start()

    def _target(self, conditions: TrialConditions) -> float:
        """Return the target in m of a hand that holds the handle at the starting distance."""
        far, grip = starting_distance(conditions.does), grip_named(self._studio.grip)
        force = min(conditions.stiffness * far, conditions.force)
        target = conditions.centre.position + conditions.centre.side * (
            far + (force / grip.stiffness if grip else 0.0)
        )
        return min(max(target, -_FARTHEST), _FARTHEST)
