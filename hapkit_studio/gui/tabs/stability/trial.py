"""Letting go of the handle off its place of rest, and saying what it did then."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.dynamics.hand import grip_named
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.tabs.stability.outcome import Released, words
from hapkit_studio.gui.tabs.stability.pair import contact, one_sided
from hapkit_studio.gui.tabs.stability.start import USUAL, Held, start

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live

# For how long the hand holds, and for how long the handle is watched after that.
_HOLD_MS, _WATCH_MS = 700, 1500
_GRIP = "medium"
# The hand's own target stays this near in m.
_FARTHEST = 0.045


class Trial(QObject):
    """Pulls the handle with the simulated hand, then lets go; ``changed`` when it begins, ends, or says more.

    holding: the hand is on the handle now; said: what happened after the last release.
    """

    changed = Signal()

    def __init__(self, studio: Studio, live: "Live", parent: QObject | None = None):
        super().__init__(parent)
        self._studio, self._live = studio, live
        self._grip: str | None = None
        self._held: Held | None = None
        self._since = 0.0
        self.holding, self.said = False, ""
        self._timer = QTimer(self, singleShot=True, interval=_HOLD_MS)
        self._timer.timeout.connect(self._release)
        self._watch = QTimer(self, singleShot=True, interval=_WATCH_MS)
        self._watch.timeout.connect(self.judge)
        for signal in (studio.engine_changed, studio.environment_changed):
            signal.connect(self.let_go)
        for signal in (studio.engine_changed, studio.environment_changed, studio.values_changed):
            signal.connect(self.forget)

    @property
    def possible(self) -> bool:
        """Say whether there is a handle, and the hand on it is ours."""
        return self._studio.engine is not None and self._studio.hand_is_ours

    def begin(self, held: Held | None) -> None:
        """Take the handle as far from its place of rest as shows most; held: what the map says of it."""
        if not self.possible or self.holding:
            return
        self.forget()
        self._held = held
        if self._studio.grip == "released":
            self._grip = self._studio.grip
            self._studio.set_grip(_GRIP)
        self._studio.move_hand(self._target(held))
        self.holding = True
        self._timer.start()
        self.changed.emit()

    def let_go(self) -> None:
        """Let go now, and be as firm as before."""
        if self.holding:
            self.holding = False
            self._timer.stop()
            self._studio.move_hand(None)
        if self._grip is not None:
            grip, self._grip = self._grip, None
            self._studio.set_grip(grip)
        self.changed.emit()

    def forget(self) -> None:
        """Say nothing of the last release any more."""
        self._watch.stop()
        if self.said:
            self.said = ""
            self.changed.emit()

    def judge(self) -> None:
        """Say what the handle did since it was let go."""
        window = self._live.history.between(self._since, float("inf"))
        place, _way = contact(self._studio.environment, self._studio.values)
        one = one_sided(self._studio.environment, self._studio.values)
        here = window.y["position"] == window.y["position"]
        seen = Released(window.x[here], window.y["position"][here] - place, window.y["asked"][here], one)
        self.said = words(seen, self._held) if self._held is not None else ""
        self.changed.emit()

    def _release(self) -> None:
        """Let go, and watch."""
        self._since = self._live.history.now
        self.let_go()
        self._watch.start()

    def _target(self, held: Held | None) -> float:
        """Return where the hand pulls to in m, so that against the scene's force the handle gets there."""
        environment, values = self._studio.environment, self._studio.values
        place, way = contact(environment, values)
        far = start(held) if held is not None else USUAL
        grip = grip_named(self._studio.grip)
        force = min(held.stiffness * far, held.force) if held is not None else 0.0
        target = place + way * (far + (force / grip.stiffness if grip else 0.0))
        return min(max(target, -_FARTHEST), _FARTHEST)
