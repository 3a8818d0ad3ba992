"""The stability limit of the current loop: the data it depends on, and its computation in a thread."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from PySide6.QtCore import QObject, Signal

from hapkit_studio.analysis.stability.margin import RELEASED
from hapkit_studio.dynamics.loop_settings import BOARD, COMPUTER
from hapkit_studio.gui.state import prepare
from hapkit_studio.gui.state.studio import Studio

if TYPE_CHECKING:
    from hapkit_studio.analysis.stability.scene_verdict import Verdict
    from hapkit_studio.analysis.stability.verdict import VerdictInput
    from hapkit_studio.dynamics.loop_settings import LoopSettings
    from hapkit_studio.haptics.engine import Engine
    from hapkit_studio.haptics.health import Health

JUDGING = "Judging the stability…"
"""This text is shown until the verdict on the current settings is known."""
DELAY_STEP, SHORT = 20e-6, 0.5e-3
"""s: step to which a delay is rounded; below the delay SHORT the step is half as large."""
_HYSTERESIS = 0.8
"""Hysteresis as a fraction of the step; half a step would still flicker."""
_steady: "WeakKeyDictionary[Engine, dict[str, float]]" = WeakKeyDictionary()
POINTS = 25

Points = tuple[tuple[float, float], ...]


def coarse(delay: float, before: float | None) -> float:
    """Round a delay in s to a coarse step; within the hysteresis, return the previous value."""
    step = DELAY_STEP if delay >= SHORT else 0.5 * DELAY_STEP
    if before is not None and abs(delay - before) < _HYSTERESIS * step:
        return before
    return round(delay / step) * step


def steady_delay(engine: "Engine", where: str) -> float | None:
    """Return the delay in s of computer or board, rounded to coarse steps; None if it is unknown."""
    found = engine.delay_of(where)
    if found is None:
        return None
    shown = _steady.setdefault(engine, {})
    shown[where] = coarse(found.mean, shown.get(where))
    return shown[where]


class LoopFacts(QObject):
    """Follows the studio's loop; ``changed`` is emitted when limits may have changed.

    The delay is None until it is measured.
    """

    changed = Signal()

    def __init__(self, studio: Studio, parent: QObject | None = None):
        super().__init__(parent)
        self._studio = studio
        self.delay: float | None = None
        self._where = COMPUTER
        self._forget()
        studio.engine_changed.connect(self._forget)
        studio.loop_changed.connect(self._follow)
        studio.environment_changed.connect(self._follow)

    def setting(self, hand: str = "released") -> "LoopSettings | None":
        """Return the current device and loop with a given hand; None without a device or a known delay."""
        engine = self._studio.engine
        if engine is None or self.delay is None:
            return None
        return engine.loop_of(COMPUTER if engine.decision().in_force is None else BOARD, self.delay, hand)

    def why_unknown(self) -> tuple[str, str]:
        """Return the reason why ``setting`` returns None, as a few words and as a sentence."""
        engine, link = self._studio.engine, self._studio.link
        if engine is None:
            known = link.state == "idle" and link.text
            return "Stability not judged yet", f"{link.text}." if known else "Connect a device first."
        if self._studio.stopped or engine.fault is not None:
            return "Delay not measured", "The delay can be measured only while the motor is on."
        if engine.where == BOARD:
            return "Measuring the delay", "The delay is measured as soon as the board computes the force."
        return (
            "Measuring the delay",
            "Measuring the delay takes half a second after connecting. The force is zero meanwhile.",
        )

    def note_health(self, health: "Health") -> None:
        """Update the measured delay, rounded to a coarse step so that noise causes no new requests."""
        engine = self._studio.engine
        handing_over = engine is not None and engine.rendering != engine.where
        if handing_over or health.delay is None:
            return
        measures = engine is not None and engine.device.measures_delay
        own = steady_delay(engine, engine.where) if engine is not None and measures else None
        delay = coarse(health.delay, self.delay) if own is None else own
        if delay != self.delay:
            self.delay = delay
            self.changed.emit()

    def _follow(self) -> None:
        """Use the measured delay of the active renderer, which is the computer or the board."""
        engine = self._studio.engine
        if engine is not None and engine.device.measures_delay and engine.where != self._where:
            self._where = engine.where
            self.delay = steady_delay(engine, engine.where)
        self.changed.emit()

    def _forget(self) -> None:
        """Discard the old device's delay. If the new device cannot measure its delay, use the added delay."""
        opened, self._where = self._studio.opened, COMPUTER
        known = opened is not None and not opened.measures_delay
        self.delay = self._studio.loop.delay if known else None
        self.changed.emit()


@dataclass(frozen=True)
class CardRequest:
    """A request for a verdict on a scene, and the width in N·s/m of the map to compute."""

    asked: "VerdictInput"
    width: float


@dataclass(frozen=True)
class CardResult:
    """The verdict, and the map's boundaries as (damping, limit) points, for the hand with the worst verdict.

    ``edge`` is the linear limit. ``friction`` is the limit up to which dry friction stops the motion after a
    knock of 1 mm. ``unstable_ranges`` are each parameter's ranges beyond that limit. All are empty if no
    limit is known. The boundaries are also empty if they do not apply, for example with a second body.
    """

    question: CardRequest
    verdict: "Verdict"
    edge: Points = ()
    friction: Points = ()
    unstable_ranges: "Mapping[str, list[tuple[float, float]]]" = field(default_factory=dict)


@lru_cache(maxsize=256)
def boundaries(setting: "LoopSettings", width: float) -> tuple[Points, Points]:
    """Return the exact and the friction boundary for dampings from zero to a width in N·s/m."""
    from hapkit_studio.analysis.stability import kb_plane  # imported late to keep start-up fast

    across = np.linspace(0.0, width, POINTS)
    found = kb_plane.exact_boundary(setting, across), kb_plane.friction_boundary(setting, across)
    edge, friction = (tuple(zip(across.tolist(), one.tolist(), strict=True)) for one in found)
    return edge, friction


def answer(question: CardRequest) -> CardResult:
    """Compute the verdict on a scene; compile its functions first if necessary."""
    from hapkit_studio.analysis.stability.verdict import unstable_ranges, verdict

    program = prepare.begin("verdict", gently=False)
    if program is not None:
        program.wait()
    asked = question.asked
    found = verdict(asked)
    if not found.margins:
        return CardResult(question, found)
    attached = not (found.joint or (found.pushes and found.worst == RELEASED))
    setting = replace(asked.setting, hand=found.worst)
    edges = boundaries(setting, question.width) if attached else ((), ())
    return CardResult(question, found, *edges, unstable_ranges(asked))
