"""Letting go of the handle a little off its place of rest, so that the scene shows what happens."""

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.dynamics.hand import grip_named
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.tabs.stability_pair import contact

# How hard the hand pulls at most in N, how far it goes in m, and for how long before it lets go.
_FORCE, _FAR = 2.0, 0.010
_HOLD_MS = 700
_GRIP = "medium"


class Trial(QObject):
    """Pulls the handle with the simulated hand, then lets go; ``changed`` when it begins and ends.

    holding: the hand is on the handle now.
    """

    changed = Signal()

    def __init__(self, studio: Studio, parent: QObject | None = None):
        super().__init__(parent)
        self._studio = studio
        self._grip: str | None = None
        self.holding = False
        self._timer = QTimer(self, singleShot=True, interval=_HOLD_MS)
        self._timer.timeout.connect(self.let_go)
        studio.engine_changed.connect(self.let_go)
        studio.environment_changed.connect(self.let_go)

    @property
    def possible(self) -> bool:
        """Say whether there is a handle, and the hand on it is ours."""
        return self._studio.engine is not None and self._studio.hand_is_ours

    def begin(self) -> None:
        """Take the handle to the stiffest place and a little farther."""
        if not self.possible or self.holding:
            return
        if self._studio.grip == "released":
            self._grip = self._studio.grip
            self._studio.set_grip(_GRIP)
        place, direction = contact(self._studio.environment, self._studio.values)
        grip = grip_named(self._studio.grip)
        pull = min(_FAR, _FORCE / grip.stiffness) if grip and grip.stiffness > 0.0 else _FAR
        self._studio.move_hand(place + pull * direction)
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
