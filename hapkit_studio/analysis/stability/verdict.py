"""What is said of a scene: what the handle does in a hand and let go, beside how far the linear limit is.

The one place that says it: for the window, a run's warnings, the command line and sketches.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.setting import Setting
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
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError
from hapkit_studio.formatting import with_unit
from hapkit_studio.haptics import headless

# An impedance that differs by more from its law's own slope is not that law's.
_SAME = 0.05
_SPEED = 0.05
_LOOKS = 33  # at a parameter's range
_INSIDE = (0.08, 0.5, 0.92)  # of a range: where a nudge is tried


@dataclass(frozen=True)
class Asked:
    """A scene to be judged: values of an environment on the setting's handle and loop, in its hand.

    max_force: of the motor, in N.
    """

    environment: Environment
    values: Mapping[str, float]
    setting: Setting
    max_force: float = SimulatedHapkit.max_force

    @cached_property
    def impedance(self) -> tuple[float, float] | None:
        """Return the stiffness (N/m) and damping (N·s/m) that bound stability, None where nothing does."""
        return self.environment.impedance(self.values) if self.environment.impedance else None

    @property
    def joint(self) -> bool:
        """Say whether the limits are those of handle and object together."""
        return objects.holds(self.environment)

    def margin(self, hand: str) -> Margin:
        """Return how far the impedance, which there is, is from the limit in a hand."""
        stiffness, damping = self.impedance or (0.0, 0.0)
        setting = replace(self.setting, hand=hand)
        if not (self.joint and setting.linear):
            return kb_plane.margin_of(setting, stiffness, damping)
        limit = objects.contact_limit(setting, self.environment.key, self.values)
        return Margin(stiffness, damping, limit, hand)

    @cached_property
    def centre(self) -> Centre:
        """Return where a handle that is let go is tried."""
        return centres_of(self.scene, None)[0]

    @property
    def scene(self) -> headless.Scene:
        """Return it as the headless loop takes it."""
        device = replace(self.setting.device(), max_force=self.max_force)
        return headless.Scene(self.environment, self.values, device, self.setting.loop)

    def unknown(self) -> str:
        """Return why no limit can be named, "" where there is one."""
        if self.impedance is None:
            return "This environment names no stiffness or damping of its own."
        if not self.setting.linear:
            return "The velocity filter is not linear: there is no exact limit."
        if self.setting.controller:
            return "The limits leave the passivity controller out, which is on."
        return differs(self.environment, self.values, self.impedance)


def differs(environment: Environment, values: Mapping[str, float], named: tuple[float, float]) -> str:
    """Return in one line where a student's law is not what its impedance says, at the start of its state."""
    if environments.discover().get(environment.key) is environment:
        return ""  # the library's own are held by tests
    force = environment.curve(values, PLACES)
    faster, slower = (environment.curve(values, PLACES, speed) for speed in (_SPEED, -_SPEED))
    stiffness = float((-np.diff(force) / np.diff(PLACES)).max())
    damping = float(((slower - faster) / (2.0 * _SPEED)).max())
    for found, said, unit in zip((stiffness, damping), named, ("N/m", "N·s/m"), strict=True):
        if abs(found - said) > _SAME * max(found, said):
            is_, says = with_unit(max(found, 0.0), unit), with_unit(said, unit)
            return f"No limit: the law's steepest place is {is_}, and its impedance says {says}."
    return ""


def verdict(asked: Asked) -> Verdict:
    """Return what the handle does in the setting's hand and let go, by simulation, and the exact margins."""
    grips = dict.fromkeys((asked.setting.hand, RELEASED))
    does = {hand: behaviour(asked.scene, grip_named(hand)) for hand in grips}
    found = Verdict(does, {})
    if found.not_judged:
        return replace(found, unknown=found.not_judged)
    unknown = asked.unknown()
    margins = {} if unknown else {hand: asked.margin(hand) for hand in grips}
    return Verdict(does, margins, unknown, asked.centre.pushes, asked.joint)


def too_much(asked: Asked) -> dict[str, list[tuple[float, float]]]:
    """Return the ranges of each parameter in which a nudge does not settle, the other values as they are; SI.

    Let go, or in the hand where the scene only pushes the handle out of itself. By the boundary of dry
    friction, and only where a simulated nudge agrees; by nudges alone, to half a look, where nothing brings
    the handle back from both sides. Nothing where no limit is known, where a parameter does not matter, or
    where the law takes too long.
    """
    try:
        return _ranges(asked)
    except LawError:
        return {}


def _ranges(asked: Asked) -> dict[str, list[tuple[float, float]]]:
    named = asked.environment.impedance
    if named is None or asked.unknown():
        return {}
    across = {
        p.key: np.linspace(p.low, p.high, _LOOKS) for p in asked.environment.parameters if not p.discrete
    }
    pairs = {
        key: np.array([named({**asked.values, key: v}) for v in x.tolist()]) for key, x in across.items()
    }
    pairs = {key: found for key, found in pairs.items() if np.ptp(found, axis=0).any()}
    setting = asked.setting if asked.centre.pushes else replace(asked.setting, hand=RELEASED)
    if not asked.centre.returns:
        return {key: _tried(asked, setting, key, across[key][::2]) for key in pairs}
    dampings = np.unique([found[:, 1] for found in pairs.values()])
    limits = kb_plane.friction_boundary(setting, dampings) if pairs else dampings
    found = {
        key: _above_zero(across[key], found[:, 0] - limits[np.searchsorted(dampings, found[:, 1])])
        for key, found in pairs.items()
    }
    return {
        key: [ends for ends in ranges if _swings(asked, setting, key, ends)] for key, ranges in found.items()
    }


def _swings(asked: Asked, setting: Setting, key: str, ends: tuple[float, float]) -> bool:
    """Return whether a nudge does not settle in the middle of a parameter's range, nor near its ends."""
    return not any(
        _nudge_settles(asked, setting, key, float(np.interp(s, (0.0, 1.0), ends))) for s in _INSIDE
    )


def _tried(asked: Asked, setting: Setting, key: str, x: np.ndarray) -> list[tuple[float, float]]:
    """Return the ranges of a parameter in which a nudge does not settle, tried at its values x (n,)."""
    settled = np.array([_nudge_settles(asked, setting, key, value) for value in x.tolist()])
    return _above_zero(x, 1.0 - 2.0 * settled)


def _nudge_settles(asked: Asked, setting: Setting, key: str, value: float) -> bool:
    """Return whether a nudge settles at another value of one parameter."""
    scene = replace(asked, values={**asked.values, key: value}, setting=setting).scene
    return settles(scene, grip_named(setting.hand), NUDGE)


def _above_zero(x: np.ndarray, y: np.ndarray) -> list[tuple[float, float]]:
    """Return the ranges of x (n,) in which the line through y (n,) is above zero."""
    turns = np.flatnonzero((y[:-1] > 0.0) != (y[1:] > 0.0))
    ends = (x[turns] + (x[turns + 1] - x[turns]) * y[turns] / (y[turns] - y[turns + 1])).tolist()
    ends = ([float(x[0])] if y[0] > 0.0 else []) + ends + ([float(x[-1])] if y[-1] > 0.0 else [])
    return list(zip(ends[::2], ends[1::2], strict=True))


def of_spring(setting: Setting, stiffness: float, damping: float) -> Verdict:
    """Return the verdict on a spring of N/m and N·s/m, on a Hapkit's motor."""
    values = {"stiffness": stiffness, "damping": damping, "center": 0.0}
    return verdict(Asked(environments.named("spring"), values, setting))
