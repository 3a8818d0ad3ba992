"""What the handle did after it was let go, in words."""

import math
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.gui.tabs.stability.start import MOST, Held, grows_from
from hapkit_studio.gui.widgets.theme import number

# The stretches that are compared, in s: after the release, and at the end.
_BEGIN, _END = 0.2, 0.4
# Up to so many sensor steps is rest; more than this factor is growth.
_STEPS, _GREW = 3.0, 1.15
_LEAST_STEP = 20e-6
_THROWN = (
    "A wall pushes the handle out, and nothing brings it back. Choose Spring to see it grow, or come to rest."
)


@dataclass(frozen=True)
class Released:
    """The handle after its release: time (n,) s, position (n,) m about its place of rest, asked force (n,) N.

    one_sided: the scene pushes on one side only.
    """

    time: np.ndarray
    position: np.ndarray
    asked: np.ndarray
    one_sided: bool = False

    @property
    def begin(self) -> float:
        """Return the largest distance in m soon after the release."""
        return float(np.abs(self.position[self.time <= self.time[0] + _BEGIN]).max())

    @property
    def end(self) -> float:
        """Return half the way to and fro in m at the end."""
        return 0.5 * float(np.ptp(self.position[self.time >= self.time[-1] - _END]))


def words(seen: Released, held: Held) -> str:
    """Say what happened, and how that goes with the map."""
    if len(seen.time) < 2:
        return ""
    if seen.one_sided:
        return _THROWN
    if seen.end <= _STEPS * max(held.setting.quantum, _LEAST_STEP):
        return f"Came to rest{_why_rest(held)}"
    clamped = bool(np.abs(seen.asked).max() > held.force)
    size = f"±{number(1e3 * seen.end, 1)} mm"
    holds = f"the force limit of {number(held.force, 1)} N holds it at {size}" if clamped else ""
    if seen.end > _GREW * seen.begin:
        return f"Grew{_as_said(held, True)}" + (f" Now {holds}." if holds else "")
    if held.stiffness > held.limit:
        return f"Did not come to rest: {holds}." if holds else f"Did not come to rest: still {size}."
    dies = seen.end < seen.begin / _GREW
    return f"Dies away{_as_said(held, False)}" if dies else f"Goes on moving, {size}."


def _as_said(held: Held, grows: bool) -> str:
    """Say whether the exact limit said so too."""
    if math.isnan(held.limit) or held.setting.controller:
        return "."
    return ", as the map says." if (held.stiffness > held.limit) == grows else ", the map says otherwise."


def _why_rest(held: Held) -> str:
    if held.setting.controller:
        return ", with the passivity controller."
    if not held.stiffness > held.limit:
        return _as_said(held, False)
    least = grows_from(held)
    if math.isinf(least) and math.isfinite(grows_from(replace(held, force=math.inf))):
        return f": friction and the force limit of {number(held.force, 1)} N held it."
    if least > MOST:
        return f": friction held it; more than {number(1e3 * MOST, 0)} mm would grow."
    return f": friction held it; it grows from {number(1e3 * least, 1)} mm on."
