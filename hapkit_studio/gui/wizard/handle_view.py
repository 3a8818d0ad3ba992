"""The handle on its rail as the scenes draw it: where the board says it is, marks, and the motor's force."""

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen, QResizeEvent
from PySide6.QtWidgets import QPushButton, QSizePolicy, QWidget

from hapkit_studio.formatting import number
from hapkit_studio.gui.scenes import base, force_arrow
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme

REACH = 0.050
"""m that the virtual hand goes to either side."""
_HEIGHT, _TALLEST = 150, 236
"""Pixels: of the view at least, and of what is drawn in a taller one."""
_PER_NEWTON = 90.0
_HINT, _SHORT_HINT = "Drag: the virtual hand. It holds on until you let go.", "Drag: virtual hand"
_BESIDE = 8
"""Pixels that the button keeps from the edges."""


class HandleView(QWidget):
    """Draws position in m, force in N (None: not shown), marks in m with whether each is taken.

    ``hand_moved(place)``: a person drags the hand of a board that has one, in m; None lets go, by a button.
    """

    hand_moved = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.position: float | None = None
        self.force: float | None = None
        self.hand: float | None = None
        self.hand_enabled = False
        self.marks: tuple[tuple[float, bool], ...] = ()
        self.let_go = QPushButton("Let go", self)
        self.let_go.setAutoDefault(False)
        self.let_go.setProperty("always_enabled", True)  # the motor carries what the hand held
        self.let_go.clicked.connect(lambda: self.move_hand(None))
        self.let_go.hide()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.setMinimumSize(280, _HEIGHT)
        self.setAccessibleName("Handle on its rail")

    def show_handle(self, position: float, force: float | None = None) -> None:
        """Show where the handle is in m, and what pushes it in N."""
        self.position, self.force = position, force
        self.update()

    def show_marks(self, marks: tuple[tuple[float, bool], ...]) -> None:
        """Show places in m, and whether they are taken."""
        self.marks = marks
        self.update()

    def set_hand_enabled(self, enabled: bool) -> None:
        """Say whether the board has a hand that can be dragged here."""
        self.hand_enabled = enabled
        self.setCursor(Qt.CursorShape.PointingHandCursor if enabled else Qt.CursorShape.ArrowCursor)

    def move_hand(self, place: float | None) -> None:
        """Hold the hand at a place in m; None lets go."""
        self.show_hand(None if place is None else min(max(place, -REACH), REACH))
        self.hand_moved.emit(self.hand)

    def show_hand(self, place: float | None) -> None:
        """Show where the hand holds, without moving it."""
        self.hand = place
        self.let_go.setVisible(place is not None)
        self._place_button()
        self.update()

    def hand_rect(self) -> QRectF | None:
        """Return where the hand's ring is in pixels; None for no hand."""
        if self.hand is None:
            return None
        stage = self._stage()
        x, y = base.ring_place(stage, 1e3 * self.hand), self._top() + stage.knob_middle
        radius = base.RING * stage.u
        return QRectF(x - radius, y - radius, 2 * radius, 2 * radius)

    def sizeHint(self) -> QSize:
        return QSize(520, _HEIGHT)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place_button()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.mouseMoveEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self.hand_enabled and event.buttons() & Qt.MouseButton.LeftButton:
            self.move_hand(1e-3 * self._stage().mm(event.position().x()))

    def paintEvent(self, event: QPaintEvent) -> None:
        painter, stage = QPainter(self), self._stage()
        stage.begin(painter)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("scene"))
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 8, 8)
        painter.translate(0.0, self._top())
        for place, taken in self.marks:
            x = stage.x(1e3 * place)
            pen = stage.pen("ok", 2) if taken else stage.pen("accent", 2, (4, 4))
            stage.line(x, 8 * stage.u, x, stage.rail, pen)
        stage.axis()
        self._draw_handle(stage)
        for place, taken in self.marks:
            x, y = stage.x(1e3 * place), 20 * stage.u
            words = f"{number(1e3 * place, 0)}{' ✓' if taken else ''}"
            places = [(x + side * 6, y, side) for side in (1, -1)]
            stage.say(words, places, "ok" if taken else "accent", 13, 600, must=True)
        if self.hand_enabled:
            y = stage.rail - 8 * stage.u
            places = [(10, y, 1), (self.width() - 10, y, -1)]
            if not stage.say(_HINT, places, "accent"):
                stage.say(_SHORT_HINT, places, "accent")

    def _draw_handle(self, stage: Stage) -> None:
        """Draw handle, force and hand, as far as they are known, and keep words off them."""
        if self.position is None:
            return
        hand = None if self.hand is None else 1e3 * self.hand
        motion = base.Motion(position=1e3 * self.position, hand=hand, force=self.force or 0.0)
        motion.position_text, motion.force_text = motion.position, force_arrow.force_words(motion.force)
        if base.beyond(stage, motion):
            return
        x = stage.x(motion.position)
        stage.taken.append(QRectF(QPointF(x - 6, 0.0), QPointF(x + 6, stage.rail)))
        stage.taken.append(base.knob(stage, motion.position))
        base.handle(stage, motion.position)
        base.hand_ring(stage, motion)
        if self.force is not None:
            force_arrow.force(stage, motion, _PER_NEWTON)

    def _stage(self) -> Stage:
        return Stage(self.width(), min(self.height(), _TALLEST), self.devicePixelRatioF())

    def _top(self) -> int:
        """Return the row where the drawing begins: it stands in the middle of a taller view."""
        return max(self.height() - _TALLEST, 0) // 2

    def _place_button(self) -> None:
        """Put the button on the side where the hand is not, below the knob and its force."""
        size, stage = self.let_go.sizeHint(), self._stage()
        left = _BESIDE if (self.hand or 0.0) > 0.0 else self.width() - size.width() - _BESIDE
        self.let_go.setGeometry(left, round(self._top() + stage.top), size.width(), size.height())
