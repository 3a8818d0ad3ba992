"""The scene's widget: it draws the handle on its rail and the environment; the mouse acts as the hand."""

from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import QElapsedTimer, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPen, QPixmap
from PySide6.QtWidgets import QSizePolicy, QWidget

from hapkit_studio.gui.scenes.base import (
    Motion,
    Scene,
    Values,
    Zone,
    beyond,
    draw_zone,
    hand_label,
    hand_ring,
    handle,
    named,
    preparing,
)
from hapkit_studio.gui.scenes.force_arrow import ReadOut, force
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import number, theme

REACH = 0.06  # m: maximum distance of the simulated hand from the centre
COARSE, FINE = 1e-3, 1e-4  # m: the hand's step for one press of an arrow key, without and with Shift
FARTHEST, STRONGEST = 1.0, 1e3  # m, N: maximum position and force in the drawing; both are clipped
_SMOOTHING = 0.25
_KEYS = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}
_BY_KEYBOARD = (
    Qt.FocusReason.TabFocusReason,
    Qt.FocusReason.BacktabFocusReason,
    Qt.FocusReason.ShortcutFocusReason,
)
_HELP = (
    "Press the mouse button and drag: the pointer is your hand. The keys ← → move the hand by 1 mm, with "
    "Shift by 0.1 mm. The key ↓ lets go of the handle."
)


def _within(value: float, most: float) -> float:
    return float(np.clip(np.nan_to_num(value), -most, most))


class SceneView(QWidget):
    """Paints one environment with the handle at its measured position; pointer or arrow keys move the hand.

    Pressing the mouse button grabs the handle, and releasing the button releases the handle. An arrow key
    grabs the handle at its current position and holds it, so that fine steps add up, until the user presses ↓
    or the pointer takes over. ``grabbed`` is emitted when the hand has grabbed the handle.
    """

    grabbed = Signal()
    hand_moved = Signal(float)
    hand_released = Signal()

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self._scene: Scene = named("")
        self._values: Values = {}
        self._motion = Motion()
        self._stage: Stage | None = None
        self._ground = QPixmap()
        self._hand_enabled = self._hint = True
        self._ring = False
        self._target: float | None = None
        self._dragging = self._preparing = self._paused = False
        self._fraction: float | None = None
        self._read_out, self._frames = ReadOut(), QElapsedTimer()
        self._zone: Zone | None = None
        self._shows_force = True
        self._set_least_size()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Scene")
        self.set_hand_enabled(True)
        theme.changed.connect(self._forget)
        theme.changed.connect(self._set_least_size)

    def _set_least_size(self) -> None:
        self.setMinimumSize(theme.px(320), theme.px(150))

    def sizeHint(self) -> QSize:
        """Return the preferred size, at which all parts are large enough."""
        return QSize(880, 236)

    # what is shown ------------------------------------------------------------------------------

    def set_environment(self, environment, values: Mapping[str, float]) -> None:
        """Show another environment."""
        self._scene = named(environment.scene)
        self.setAccessibleName(f"Scene: {environment.title}")
        self.set_values(values)

    def show_force(self, on: bool) -> None:
        """Show or hide the force arrow and its number; they are hidden if they would reveal hidden values."""
        self._shows_force = on
        self.update()

    def set_zone(self, zone: Zone | None) -> None:
        """Mark a range to which the handle is to be moved; None removes the mark."""
        if zone != self._zone:
            self._zone = zone
            self.update()

    @property
    def wanted_height(self) -> int:
        """Return the preferred height of the card in px."""
        return self._scene.height

    def set_values(self, values: Mapping[str, float]) -> None:
        """Apply changed parameters."""
        self._values = self._scene.values(values)
        self._forget()

    def update_state(
        self,
        position: float,
        applied: float,
        asked: float,
        hand_target: float | None,
        clamped: bool,
        stopped: bool,
        state: np.ndarray,
    ) -> None:
        """Show the newest row: ``position`` in m, forces in N, ``hand_target`` in m or None if released.

        The hand is drawn at ``hand_target``, or at the pointer if the row has no target.
        """
        motion = self._motion
        place = motion.position if np.isnan(position) else 1e3 * _within(position, FARTHEST)
        seconds = self._frames.restart() / 1e3 if self._frames.isValid() else 0.0
        if not self._frames.isValid():
            self._frames.start()
        if seconds > 0.0:
            speed = (place - motion.position) / seconds
            motion.velocity += _SMOOTHING * (speed - motion.velocity)
        motion.position = place
        motion.force, motion.asked = _within(applied, STRONGEST), _within(asked, STRONGEST)
        target = self._target if hand_target is None else hand_target
        motion.hand = None if target is None or not np.isfinite(target) else 1e3 * target
        motion.clamped, motion.stopped, motion.state = clamped, stopped, self._scene.state(state)
        motion.trail.append(motion.position)
        if self._read_out.refresh(motion):
            text = f"{number(motion.position, 2, sign=True)} mm"
            text += f", force {motion.force_text}" if self._shows_force else ""
            self.setAccessibleDescription(f"Handle at {text}. {_HELP}")
        self.update()

    def set_hand_enabled(self, enabled: bool) -> None:
        """Set whether pointer and keys move the hand (simulated device) or not (real board)."""
        self._hand_enabled = enabled
        if not enabled:
            self.release()
        self.setCursor(Qt.CursorShape.OpenHandCursor if enabled else Qt.CursorShape.ArrowCursor)
        self.setToolTip(_HELP if enabled else "The picture shows the handle at its measured position")

    def set_hint(self, on: bool) -> None:
        """Show or hide the hint beside the knob; the hint disappears when the user drags the handle."""
        self._hint = on
        self.update()

    def set_paused(self, paused: bool) -> None:
        """Show whether the picture is paused; a paused picture shows exactly the numbers of its row."""
        self._paused = paused
        self._read_out.invalidate()
        self._read_out.refresh(self._motion)
        self.update()

    def set_grip(self, grip: str) -> None:
        """Set the grip; with the grip "released", the ring follows the pointer but does not pull."""
        self._motion.loose = grip == "released"
        self.update()

    def set_preparing(self, preparing: bool, fraction: float | None = None) -> None:
        """Show progress in place of the scene; ``fraction`` is 0..1, or None if unknown."""
        changed = preparing != self._preparing
        self._preparing, self._fraction = preparing, fraction
        if changed:
            self._forget()
        self.update()

    def target_at(self, x: float) -> float:
        """Return the hand's target in m for a pixel column."""
        return float(np.clip(self._layout().mm(x) / 1e3, -REACH, REACH))

    def text_boxes(self) -> list[QRectF]:
        """Return the boxes of the texts in the picture that was painted last."""
        return list(self._layout().texts)

    # painting -----------------------------------------------------------------------------------

    def _forget(self) -> None:
        self._stage = None
        self.update()

    def resizeEvent(self, event) -> None:
        """Discard the cached layout."""
        super().resizeEvent(event)
        self._forget()

    def _layout(self) -> Stage:
        """Return the stage for this size, with the fixed parts painted into the cached picture."""
        ratio = self.devicePixelRatioF()
        if self._stage is None or self._stage.ratio != ratio:
            stage = self._stage = Stage(self.width(), self.height(), ratio, self._scene.widest)
            self._ground = QPixmap(self.size() * ratio)
            self._ground.setDevicePixelRatio(ratio)
            self._ground.fill(Qt.GlobalColor.transparent)
            painter = QPainter(self._ground)
            stage.begin(painter)
            stage.ground()
            if not self._preparing:
                self._scene.fixed(stage, self._values)
            stage.axis()
            stage.keep_occupied()
            painter.end()
        return self._stage

    def paintEvent(self, event) -> None:
        """Paint the cached picture, then the moving parts."""
        stage = self._layout()
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._ground)
        stage.begin(painter)
        if self._preparing:
            preparing(stage, self._fraction)
        else:
            self._play(stage)
        if self._paused:
            beside, row = 10 * stage.u, stage.knob_middle + 4.8 * stage.u
            places = [(beside, row, 1), (stage.width - beside, row, -1)]
            stage.write("Paused", places, "accent", 12, 600, must=True)
        if self._ring and self.hasFocus():
            stage.use(QPen(theme.color("accent"), 2))
            stage.p.drawRoundedRect(QRectF(self.rect()).adjusted(1, 1, -1, -1), 7, 7)
        painter.end()

    def _play(self, stage: Stage) -> None:
        scene, values, motion = self._scene, self._values, self._motion
        if self._zone is not None:
            draw_zone(stage, self._zone)
        scene.moving(stage, values, motion)
        hand_ring(stage, motion)
        if beyond(stage, motion):
            hand_label(stage, motion)
            return
        handle(stage, motion.position, scene.tip(stage, values, motion) if scene.tip else None)
        if self._shows_force:
            force(stage, motion, scene.per_newton)
        if self._hint and self._hand_enabled:
            x, half = stage.x(motion.position), stage.knob_width / 2 + 13 * stage.u
            y = stage.knob_middle + 4.8 * stage.u
            stage.write("Drag the handle", [(x + half, y, 1), (x - half, y, -1)], "accent", 12, 600)
        hand_label(stage, motion)
        scene.labels(stage, values, motion)

    # the hand -----------------------------------------------------------------------------------

    def mousePressEvent(self, event) -> None:
        """Grab the handle: the hand moves to the pointer."""
        if self._hand_enabled and not self._preparing and event.button() == Qt.MouseButton.LeftButton:
            self._dragging, self._hint = True, False
            self.setCursor(Qt.CursorShape.ClosedHandCursor)
            self.grabbed.emit()
            self._move_hand(self.target_at(event.position().x()))

    def mouseMoveEvent(self, event) -> None:
        if self._dragging:
            self._move_hand(self.target_at(event.position().x()))

    def mouseReleaseEvent(self, event) -> None:
        if self._dragging and event.button() == Qt.MouseButton.LeftButton:
            self.release()

    def focusInEvent(self, event) -> None:
        """Show a focus ring if the focus came from the keyboard."""
        self._ring = event.reason() in _BY_KEYBOARD
        super().focusInEvent(event)

    def wheelEvent(self, event) -> None:
        """Accept the event without an effect: the wheel does not move the hand."""
        event.accept()

    def keyPressEvent(self, event) -> None:
        """Move the hand with the arrow keys; the down key releases the handle."""
        key = event.key()
        if not self._hand_enabled or self._preparing or self._dragging:
            super().keyPressEvent(event)
        elif key in _KEYS:
            self._hint, self._ring = False, True
            self.grabbed.emit()
            step = FINE if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else COARSE
            start = self._motion.position / 1e3 if self._target is None else self._target
            self._move_hand(float(np.clip(start + _KEYS[key] * step, -REACH, REACH)))
        elif key == Qt.Key.Key_Down and self._target is not None:
            self.release()
        else:
            super().keyPressEvent(event)

    def _move_hand(self, target: float) -> None:
        self._target = target
        self.hand_moved.emit(target)
        self.update()

    def release(self) -> None:
        """Release the handle; dragging with a button that is still pressed has no further effect."""
        if self._dragging:
            self._dragging = False
            self.setCursor(Qt.CursorShape.OpenHandCursor)
        if self._target is not None:
            self._target = None
            if not self._paused:
                self._motion.hand = None
            self.hand_released.emit()
            self.update()
