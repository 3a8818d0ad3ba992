"""The chart of stiffness over damping, called plane: every limit of a loop, and the rendered impedance."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hapkit_studio.analysis.checks import DAMPING, STIFFNESS, checked_row, whole_number
from hapkit_studio.analysis.stability.behaviour import NUDGE
from hapkit_studio.analysis.stability.hands import KNOWN, PEOPLE, Family, family
from hapkit_studio.analysis.stability.limits import coulomb_line, simple_rule
from hapkit_studio.analysis.stability.margin import (
    Margin,
    hand_text,
    nice_top,
    round_axes,
    sentence,
    stable_again,
)
from hapkit_studio.analysis.stability.passivity import passive_damping, passive_stiffness
from hapkit_studio.analysis.stability.scene_verdict import Verdict
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.dynamics.loop_settings import LoopSettings, estimator_texts
from hapkit_studio.dynamics.sampled_loop import Intervals, first_end, stable_intervals
from hapkit_studio.formatting import compact, plain, with_unit

RENDERED_STIFFNESS = replace(STIFFNESS, label="The rendered stiffness")
RENDERED_DAMPING = replace(DAMPING, label="The rendered damping")
WIDTH = replace(DAMPING, label="The largest damping shown")
TOP = replace(STIFFNESS, label="The largest stiffness shown")
COLUMNS = 121
# dampers that replace friction: the smallest in N·s/m, the ratio of consecutive dampers, their number
_LEAST, _RATIO, _DAMPERS = 0.02, 1.5, 24
EDGE_POINTS = 41


@dataclass(frozen=True)
class Points:
    """A measured boundary: stiffness (n,) in N/m at damping (n,) in N·s/m.

    ``real`` is True if friction and sensor steps were included. Up to the boundary a spring is stable. With
    the passivity controller the motion of the spring is bounded instead. ``swing`` (n,) is then the final
    amplitude in m at the boundary, NaN if the boundary is 0 or inf; without the controller it is None.
    """

    damping: np.ndarray
    stiffness: np.ndarray
    real: bool
    controller: bool = False
    swing: np.ndarray | None = None

    @property
    def name(self) -> str:
        """Return the label in a chart, with the largest amplitude."""
        if not self.controller:
            return LINES["measured"][0]
        swing = np.array([0.0] if self.swing is None else self.swing)
        most = round(1e3 * float(np.max(swing, initial=0.0, where=np.isfinite(swing))), 2)
        return "Bounded" + (f" to ±{with_unit(most, 'mm', 2)}" if most else "")


@dataclass(frozen=True)
class Cells:
    """A measured map: classes (m, n) of ``rendered`` at stiffness (m,) in N/m and damping (n,) in N·s/m."""

    damping: np.ndarray
    stiffness: np.ndarray
    classes: np.ndarray
    real: bool
    controller: bool = False


@dataclass(frozen=True)
class Plane:
    """The contents of a plane, in SI units.

    ``exact``, ``simple`` and ``friction`` (the limit for settling after a nudge) are (n,) over damping (n,).
    ``again`` (2, n) is the next stable interval above the limit, NaN without such an interval.
    ``edge_damping`` and ``edge`` (k,) are the passivity line up to the largest passive damping. ``coulomb``
    is the stiffness in ``coulomb_line``, inf without sensor steps. ``hands`` are the limits at the margin's
    damping. For a nonlinear estimator exact, friction, and the limits of hands and margin are NaN, and the
    edge is empty. ``verdict`` is the verdict on the margin's impedance, and ``family`` contains the limits of
    the worst hand; each is None unless it was requested.
    """

    setting: LoopSettings
    margin: Margin
    top: float
    damping: np.ndarray
    exact: np.ndarray
    again: np.ndarray
    simple: np.ndarray
    friction: np.ndarray
    edge_damping: np.ndarray
    edge: np.ndarray
    coulomb: float
    hands: dict[str, float]
    points: Points | None = None
    cells: Cells | None = None
    verdict: Verdict | None = None
    family: Family | None = None

    @property
    def text(self) -> str:
        """Return the handle's behaviour if it is known, otherwise the margin."""
        verdict = self.verdict
        if verdict is None:
            return sentence(self.margin)
        return " ".join(
            filter(None, (*verdict.lines, verdict.reason, self.caption, stable_again(self.margin)))
        )

    @property
    def pushes(self) -> bool:
        """Return True if the map is for a released handle, and the scene only pushes it away, like a wall."""
        return self.verdict is not None and self.verdict.pushes and self.setting.grip is None

    @property
    def caption(self) -> str:
        """Return a sentence on the validity of the map; "" if the map is valid for the scene itself."""
        if self.verdict is not None and self.verdict.joint:
            return (
                "This map is for a wall, but the limits in the text are for the handle and the object "
                "together."
            )
        if self.pushes:
            return (
                "This map is for a handle that is attached to the wall's spring, but a released handle "
                "leaves the wall. Choose a grip to see the map of a hand at the wall."
            )
        return ""

    @property
    def width(self) -> float:
        """Return the largest damping shown, in N·s/m."""
        return float(self.damping[-1])


def intervals(setting: LoopSettings, damping: np.ndarray) -> list[Intervals]:
    """Return the stable stiffness intervals (low, high) in N/m for each damping (n,), lowest first.

    Raise ParameterError for a nonlinear estimator.
    """
    return stable_intervals(setting, checked_row(damping, DAMPING))


def exact_boundary(setting: LoopSettings, damping: np.ndarray) -> np.ndarray:
    """Return the stiffness limit (n,) in N/m; it is 0 if the damping (n,) alone is unstable.

    Raise ParameterError for a nonlinear estimator.
    """
    return np.array([first_end(each) for each in intervals(setting, damping)])


def friction_boundary(setting: LoopSettings, damping: np.ndarray, push: float = NUDGE) -> np.ndarray:
    """Return the largest stiffness (n,) in N/m at which a handle settles, released ``push`` m off the centre.

    Dry friction removes 4 F A per cycle of amplitude A, like a damper of 4 F / (pi A w). This is its
    describing function at the handle's natural frequency w = sqrt(K / m). The result is accurate to 1 %;
    boundaries of 0 stay 0. Raise ParameterError for a nonlinear estimator.
    """
    mass, grip_stiffness = setting.moving_mass, setting.grip_stiffness
    force = 4.0 * setting.coulomb / (math.pi * push)

    extra, limits, forces = 0.0, [exact_boundary(setting, damping)], [np.zeros(len(damping))]
    while forces[-1].min() < force and len(limits) < _DAMPERS:
        extra = _RATIO * extra or _LEAST
        limits.append(exact_boundary(replace(setting, viscous=setting.viscous + extra), damping))
        forces.append(extra * np.sqrt((limits[-1] + grip_stiffness) / mass))
    columns = zip(np.transpose(forces), np.transpose(limits), strict=True)
    return np.array([np.interp(force, taken, bound) for taken, bound in columns])


def passivity_line(setting: LoopSettings, damping: np.ndarray) -> np.ndarray:
    """Return the largest stiffness (n,) in N/m that is passive, and so stable with any hand; 0 without one.

    Raise ParameterError for a nonlinear estimator.
    """
    columns = checked_row(damping, DAMPING)
    return passive_stiffness(setting.viscous, columns, *_sampling(setting))


def _sampling(setting: LoopSettings) -> tuple[float, float, Spec, float]:
    return setting.rate, setting.delay, setting.estimator, setting.quantum


def passive_edge(setting: LoopSettings) -> tuple[np.ndarray, np.ndarray]:
    """Return the passivity line as (damping, stiffness), each (k,), up to the largest passive damping."""
    damping = np.linspace(0.0, passive_damping(setting.viscous, *_sampling(setting)), EDGE_POINTS)
    return damping, passivity_line(setting, damping)


def limit(setting: LoopSettings, damping: float) -> float:
    """Return the largest stable stiffness in N/m at one damping; NaN for a nonlinear estimator."""
    return margin_of(setting, 0.0, damping).limit


def margin_of(setting: LoopSettings, stiffness: float, damping: float) -> Margin:
    """Return the margin of a rendered stiffness in N/m at its damping."""
    if not setting.linear:
        return Margin(stiffness, damping, math.nan, setting.hand)
    found = intervals(setting, np.array([DAMPING.check(damping)]))[0]
    again = tuple(ends for ends in found if ends[0] > 0.0)
    return Margin(stiffness, damping, first_end(found), setting.hand, again)


def hands(setting: LoopSettings, damping: float) -> dict[str, float]:
    """Return the limit in N/m at one damping for every grip; the released handle comes first."""
    return {name: limit(replace(setting, hand=name), damping) for name in GRIPS}


# the axes show the friction boundary times _ROOM, but at most _FARTHEST times the exact limit
_ROOM, _FARTHEST = 1.1, 4.0


def plane(
    setting: LoopSettings,
    stiffness: float,
    damping: float,
    *,
    width: float | None = None,
    top: float | None = None,
    columns: int = COLUMNS,
) -> Plane:
    """Return the limits of a setting as a plane around a rendered impedance; default axes have rounded ends.

    Raise ParameterError for a value outside its limits.
    """
    stiffness, damping = RENDERED_STIFFNESS.check(stiffness), RENDERED_DAMPING.check(damping)
    width, top = WIDTH.check(width or 0.0), TOP.check(top or 0.0)
    columns = whole_number(columns, "The number of columns", 2)
    around, margin = hands(setting, damping), margin_of(setting, stiffness, damping)
    if not (width and top):
        limits = exact_boundary if setting.linear else simple_rule
        dot = np.array([damping])
        here = margin.limit if setting.linear else float(simple_rule(setting, dot)[0])
        wide, high = round_axes(lambda across: limits(setting, across), stiffness, damping, here)
        rubbed = float(friction_boundary(setting, dot)[0]) if setting.linear else 0.0
        high = max(high, nice_top(_ROOM * min(rubbed, _FARTHEST * here)))
        width, top = width or wide, top or high
    across = np.linspace(0.0, width, columns)
    found = intervals(setting, across) if setting.linear else [()] * columns
    exact = np.array([first_end(each) for each in found]) if setting.linear else np.full(columns, math.nan)
    none = math.nan, math.nan
    again = np.array([next((ends for ends in each if ends[0] > 0.0), none) for each in found]).T
    passive_b, passive_k = passive_edge(setting) if setting.linear else (np.empty(0), np.empty(0))
    friction = friction_boundary(setting, across) if setting.linear and setting.coulomb > 0.0 else exact
    lines = across, exact, again, simple_rule(setting, across), friction
    return Plane(setting, margin, top, *lines, passive_b, passive_k, coulomb_line(setting), around)


def with_family(plane: Plane) -> Plane:
    """Return a copy of a plane with the limits of the worst hand.

    Raise ParameterError for a nonlinear estimator.
    """
    found = family(plane.setting, plane.damping)
    here = float(np.interp(plane.margin.damping, found.damping, found.people))
    return replace(plane, family=found, top=max(plane.top, nice_top(_ROOM * here)))


def class_names(controller: bool) -> tuple[str, str, str]:
    """Return the names of DECAYS, BUZZES and GROWS, one word each."""
    return "decays", "bounded" if controller else "buzzes", "grows"


def class_descriptions(controller: bool) -> tuple[str, str, str]:
    """Return descriptions of DECAYS, BUZZES and GROWS."""
    return (
        "comes to rest",
        "keeps moving without growing" if controller else "buzzes without growing",
        "grows",
    )


def as_json(plane: Plane) -> dict[str, Any]:
    """Return the plane in SI units; None for values that are not finite."""
    margin, setting = plane.margin, plane.setting
    pair = (setting.estimator, {}) if isinstance(setting.estimator, str) else setting.estimator
    measured, cells = (
        {"friction_and_sensor_steps" if key == "real" else key: value for key, value in vars(found).items()}
        if found
        else None
        for found in (plane.points, plane.cells)
    )
    columns = {key: getattr(plane, key) for key in ("damping", "exact", "simple", "friction")}
    return plain(
        {
            "setting": {**vars(setting), "estimator": pair[0], "estimator_options": pair[1]},
            "stiffness": margin.stiffness,
            "damping": margin.damping,
            "limit": margin.limit,
            "stable_again": margin.again,
            "ratio": margin.ratio,
            "stable": margin.stable if math.isfinite(margin.limit) else None,
            "text": plane.text,
            "handle": plane.verdict.does if plane.verdict else None,
            "hands": plane.hands,
            "coulomb_line": plane.coulomb,
            "columns": {**columns, "passive": passive(plane)},
            "passivity_line": {"damping": plane.edge_damping, "stiffness": plane.edge},
            "measured": {**measured, "kind": "bounded" if measured["controller"] else "stable"}
            if measured
            else None,
            "hand_family": {"known": KNOWN, **vars(plane.family)} if plane.family else None,
            "map": {**cells, "class_names": class_names(cells["controller"])} if cells else None,
        }
    )


def passive(plane: Plane) -> np.ndarray:
    """Return the passivity line (n,) in N/m at the plane's columns; NaN for a nonlinear estimator."""
    if not plane.setting.linear:
        return np.full(len(plane.damping), math.nan)
    return passivity_line(plane.setting, plane.damping)


# name and one-line explanation of each line, by its key
LINES = {
    "exact": ("Exact boundary", "from the roots of the sampled loop"),
    "friction": ("Boundary with friction", "below this line, the handle comes to rest after a push of 1 mm"),
    "measured": ("Measured boundary", "found by simulations on both sides"),
    "simple": (
        "Simple rule",
        "k < (b₀ + b) / (T/2 + td): damping b₀ of handle and hand, virtual damping b, period T, delay td",
    ),
    "passive": ("Passivity line", "below this line, stable in any hand"),
    "people": ("Limit for the worst hand", f"of all hands with {PEOPLE}"),
    "coulomb": (
        "Friction stops sensor buzz",
        "below k = 2 Fc / Δ (dry friction Fc, sensor step Δ), the sensor steps cannot start a buzz",
    ),
    "decays": ("Comes to rest", "after a release 3 and 200 sensor steps from the centre"),
    "buzzes": ("Buzzes", "keeps oscillating without growing"),
    "grows": ("Grows", "after a release, the handle moves farther and farther"),
}
# the simple rule is too optimistic if it exceeds the exact boundary by more than this fraction
_OPTIMISTIC = 0.05


def conditions(setting: LoopSettings, real: bool = False) -> list[tuple[str, str]]:
    """Return the conditions of the limits as pairs of name and value.

    ``real`` is True if friction and sensor steps are included.
    """
    stiction = [
        ("Dry friction", f"{setting.coulomb:g} N"),
        ("Sensor step", f"{compact(1e6 * setting.quantum, 3)} µm"),
    ]
    pairs = [
        ("Mass", f"{setting.mass:g} kg"),
        ("Viscous damping", f"{setting.viscous:g} N·s/m"),
        *(stiction if real else []),
        ("Rate", f"{setting.rate:,g} Hz"),
        ("Delay", f"{1e3 * setting.delay:.2f} ms"),
        ("Velocity filter", estimator_texts(setting.estimator)[1]),
        ("Hand", hand_text(setting.hand)),
    ]
    return [*pairs, ("Passivity controller", "on")] if setting.controller else pairs


def line_texts(plane: Plane, key: str) -> tuple[str, str]:
    """Return a line's name and meaning for this plane."""
    name, text = LINES[key]
    if key == "simple" and rule_is_optimistic(plane):
        return f"{name} (too optimistic here)", text
    if key == "measured" and plane.points is not None:
        name = plane.points.name
        text = f"{text}; below this line, the motion does not grow" if plane.points.controller else text
        text += ", with friction" if plane.points.real else ""
    return name, text


def rule_is_optimistic(plane: Plane) -> bool:
    """Return True if the simple rule exceeds the exact limit in the visible range."""
    low = plane.exact < (1.0 - _OPTIMISTIC) * plane.simple
    return bool((low & (plane.exact < plane.top)).any())
