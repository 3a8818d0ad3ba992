"""Compute the verdict on a scene: behaviour of the handle when held and released, and the linear limit.

The window, a run's warnings, the command line and exported sketches use it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.analysis.stability import kb_plane, objects
from hapkit_studio.analysis.stability.behaviour import (
    NUDGE,
    PLACES,
    Centre,
    behaviour,
    centres_of,
    settles,
)
from hapkit_studio.analysis.stability.margin import RELEASED, Margin
from hapkit_studio.analysis.stability.scene_verdict import Verdict
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import grip_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError
from hapkit_studio.formatting import with_unit
from hapkit_studio.haptics import headless

# a declared impedance that differs from the law's slope by more than this fraction is rejected
_SAME = 0.05
_SPEED = 0.05
_EVALUATIONS = 33  # number of evaluations over a parameter's range
_INSIDE = (0.08, 0.5, 0.92)  # fractions of a range at which a nudge is simulated


@dataclass(frozen=True)
class VerdictInput:
    """A scene to be judged: an environment's values, and a setting with handle, loop and hand.

    ``max_force`` is the motor's limit in N.
    """

    environment: Environment
    values: Mapping[str, float]
    setting: LoopSettings
    max_force: float = SimulatedHapkit.max_force

    @cached_property
    def impedance(self) -> tuple[float, float] | None:
        """Return the stiffness (N/m) and damping (N·s/m) that decide stability; None if unknown."""
        return self.environment.impedance(self.values) if self.environment.impedance else None

    @property
    def joint(self) -> bool:
        """Return True if the limits are those of handle and object together."""
        return objects.has_object(self.environment)

    def margin(self, hand: str) -> Margin:
        """Return the margin of the impedance in a hand; the impedance must be known."""
        stiffness, damping = self.impedance or (0.0, 0.0)
        setting = replace(self.setting, hand=hand)
        if not (self.joint and setting.linear):
            return kb_plane.margin_of(setting, stiffness, damping)
        limit = objects.contact_limit(setting, self.environment.key, self.values)
        return Margin(stiffness, damping, limit, hand)

    @cached_property
    def centre(self) -> Centre:
        """Return the starting point of a released handle."""
        return centres_of(self.scene, None)[0]

    @property
    def scene(self) -> headless.Scene:
        """Return the input as a scene of the headless loop."""
        device = replace(simulated_handle(self.setting), max_force=self.max_force)
        return headless.Scene(self.environment, self.values, device, self.setting)

    def unknown(self) -> str:
        """Return the reason why no stiffness limit can be given; "" if a limit can be given."""
        if self.impedance is None:
            return "This environment has no stiffness or damping to compare with a limit."
        if not self.setting.linear:
            return "The velocity filter is not linear, so there is no exact limit."
        if self.setting.controller:
            return "The passivity controller is on. The limits do not include it."
        return differs(self.environment, self.values, self.impedance)


def differs(environment: Environment, values: Mapping[str, float], named: tuple[float, float]) -> str:
    """Return a warning if a user's law differs from its declared impedance in the initial state, else ""."""
    if environments.discover().get(environment.key) is environment:
        return ""  # tests check the laws of the library
    force = environment.curve(values, PLACES)
    faster, slower = (environment.curve(values, PLACES, speed) for speed in (_SPEED, -_SPEED))
    stiffness = float((-np.diff(force) / np.diff(PLACES)).max())
    damping = float(((slower - faster) / (2.0 * _SPEED)).max())
    for found, stated, unit in zip((stiffness, damping), named, ("N/m", "N·s/m"), strict=True):
        if abs(found - stated) > _SAME * max(found, stated):
            is_, stated_text = with_unit(max(found, 0.0), unit), with_unit(stated, unit)
            return (
                f"The limit cannot be computed: the law reaches a value of {is_}, but its `impedance` states "
                f"{stated_text}. Correct the law or `impedance`."
            )
    return ""


def verdict(inputs: VerdictInput) -> Verdict:
    """Return the simulated behaviour in the setting's hand and when released, and the exact margins."""
    grips = dict.fromkeys((inputs.setting.hand, RELEASED))
    does = {hand: behaviour(inputs.scene, grip_named(hand)) for hand in grips}
    found = Verdict(does, {})
    if found.not_judged:
        return replace(found, unknown=found.not_judged)
    unknown = inputs.unknown()
    margins = {} if unknown else {hand: inputs.margin(hand) for hand in grips}
    return Verdict(does, margins, unknown, inputs.centre.pushes, inputs.joint)


def unstable_ranges(inputs: VerdictInput) -> dict[str, list[tuple[float, float]]]:
    """Return the ranges of each parameter, in SI units, in which a nudge does not settle.

    The other values are fixed. The handle is released, or held if the scene only pushes it away. The ranges
    are computed from the friction boundary and confirmed by simulated nudges. In a scene without a restoring
    force on both sides, only simulated nudges are used, so the ranges are accurate to half a step. The result
    is empty if there is no limit, if a parameter has no effect, or if the law is too slow.
    """
    try:
        return _ranges(inputs)
    except LawError:
        return {}


def _ranges(inputs: VerdictInput) -> dict[str, list[tuple[float, float]]]:
    named = inputs.environment.impedance
    if named is None or inputs.unknown():
        return {}
    across = {
        p.key: np.linspace(p.low, p.high, _EVALUATIONS)
        for p in inputs.environment.parameters
        if not p.discrete
    }
    pairs = {
        key: np.array([named({**inputs.values, key: v}) for v in x.tolist()]) for key, x in across.items()
    }
    pairs = {key: found for key, found in pairs.items() if np.ptp(found, axis=0).any()}
    setting = inputs.setting if inputs.centre.pushes else replace(inputs.setting, hand=RELEASED)
    if not inputs.centre.returns:
        return {key: _simulated_ranges(inputs, setting, key, across[key][::2]) for key in pairs}
    dampings = np.unique([found[:, 1] for found in pairs.values()])
    limits = kb_plane.friction_boundary(setting, dampings) if pairs else dampings
    found = {
        key: _above_zero(across[key], found[:, 0] - limits[np.searchsorted(dampings, found[:, 1])])
        for key, found in pairs.items()
    }
    return {
        key: [ends for ends in ranges if _unstable_throughout(inputs, setting, key, ends)]
        for key, ranges in found.items()
    }


def _unstable_throughout(
    inputs: VerdictInput, setting: LoopSettings, key: str, ends: tuple[float, float]
) -> bool:
    """Return True if nudges settle neither in the middle of a range nor near its ends."""
    return not any(
        _nudge_settles(inputs, setting, key, float(np.interp(s, (0.0, 1.0), ends))) for s in _INSIDE
    )


def _simulated_ranges(
    inputs: VerdictInput, setting: LoopSettings, key: str, x: np.ndarray
) -> list[tuple[float, float]]:
    """Return the ranges in which a nudge does not settle, simulated at values x (n,) of a parameter."""
    settled = np.array([_nudge_settles(inputs, setting, key, value) for value in x.tolist()])
    return _above_zero(x, 1.0 - 2.0 * settled)


def _nudge_settles(inputs: VerdictInput, setting: LoopSettings, key: str, value: float) -> bool:
    """Return True if a nudge settles when one parameter has a different value."""
    scene = replace(inputs, values={**inputs.values, key: value}, setting=setting).scene
    return settles(scene, grip_named(setting.hand), NUDGE)


def _above_zero(x: np.ndarray, y: np.ndarray) -> list[tuple[float, float]]:
    """Return the ranges of x (n,) in which the linear interpolation of y (n,) is positive."""
    turns = np.flatnonzero((y[:-1] > 0.0) != (y[1:] > 0.0))
    ends = (x[turns] + (x[turns + 1] - x[turns]) * y[turns] / (y[turns] - y[turns + 1])).tolist()
    ends = ([float(x[0])] if y[0] > 0.0 else []) + ends + ([float(x[-1])] if y[-1] > 0.0 else [])
    return list(zip(ends[::2], ends[1::2], strict=True))


def of_spring(setting: LoopSettings, stiffness: float, damping: float) -> Verdict:
    """Return the verdict on a spring with stiffness in N/m and damping in N·s/m on a Hapkit's motor."""
    values = {"stiffness": stiffness, "damping": damping, "center": 0.0}
    return verdict(VerdictInput(environments.named("spring"), values, setting))
