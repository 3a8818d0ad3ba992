"""The handle on its rail, where the board says it is: the marks, and the force that the motor makes."""

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF, QResizeEvent
from PySide6.QtWidgets import QPushButton, QSizePolicy, QWidget

from hapkit_studio.gui.widgets.theme import number, theme

SPAN = 0.065
"""m from the middle to either end of the picture."""
_HEIGHT = 166
_END = 0.062
_REACH = 0.055
_PER_NEWTON = 90.0
_HINTS = (
    "Drag here: the virtual hand, which holds on until you let go.",
    "Drag here: the virtual hand. It holds on.",
)
_BESIDE = 8
"""Pixels that the button keeps from the edges."""
_EDGE, _WORDS = 6.0, 86.0
"""Pixels that the arrow keeps from the edge, and that its number takes beside its tip."""


class Rail(QWidget):
    """Draws position in m, marks in m with whether each is taken, force in N; None: not known yet.

    ``led(place)``: a person drags the hand of a board that has one, in m; None lets go, by a button.
    """

    led = Signal(object)

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.position: float | None = None
        self.hand: float | None = None
        self.takes_hand = False
        self.force = 0.0
        self.marks: tuple[tuple[float, bool], ...] = ()
        self.let_go = QPushButton("Let go", self)
        self.let_go.setAutoDefault(False)
        self.let_go.setProperty("always", True)  # also while the motor runs: it carries what was held
        self.let_go.clicked.connect(lambda: self.lead(None))
        self.let_go.hide()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.setMinimumSize(320, _HEIGHT)
        self.setAccessibleName("Handle on its rail")

    def show_handle(self, position: float | None, force: float = 0.0) -> None:
        """Show where the handle is in m, and what pushes it in N."""
        self.position, self.force = position, force
        self.update()

    def show_hand(self, taken: bool) -> None:
        """Say whether the board has a hand that can be dragged here."""
        self.takes_hand = taken
        self.setCursor(Qt.CursorShape.PointingHandCursor if taken else Qt.CursorShape.ArrowCursor)

    def lead(self, place: float | None) -> None:
        """Hold the hand at a place in m; None lets go."""
        self.hand = None if place is None else min(max(place, -_REACH), _REACH)
        self.led.emit(self.hand)
        self._look()

    def forget_hand(self) -> None:
        """Hold nothing any more."""
        self.hand = None
        self._look()

    def _look(self) -> None:
        self.let_go.setVisible(self.hand is not None)
        self._place_button()
        self.update()

    def _place_button(self) -> None:
        """Put the button on the side where the hand is not."""
        size = self.let_go.sizeHint()
        left = _BESIDE if (self.hand or 0.0) > 0.0 else self.width() - size.width() - _BESIDE
        self.let_go.setGeometry(left, _BESIDE, size.width(), size.height())

    def hand_place(self) -> QRectF | None:
        """Return where the hand's ring is in pixels; None for no hand."""
        if self.hand is None:
            return None
        at = QPointF(self._x(self.hand), self._base() - 84 * self._size())
        return QRectF(at.x() - 9, at.y() - 9, 18, 18)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place_button()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.mouseMoveEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self.takes_hand and event.buttons() & Qt.MouseButton.LeftButton:
            self.lead((event.position().x() - self.width() / 2) / (self.width() / 2 - 24) * SPAN)

    def show_marks(self, marks: tuple[tuple[float, bool], ...]) -> None:
        """Show places in m, and whether they are taken."""
        self.marks = marks
        self.update()

    def sizeHint(self) -> QSize:
        return QSize(520, _HEIGHT)

    def _size(self) -> float:
        """Return by what the handle is larger where there is more room."""
        return min(max(self.height() / _HEIGHT, 1.0), 1.7)

    def _base(self) -> float:
        """Return the rail's height: in the middle where there is more room than the picture grows."""
        spare = self.height() - _HEIGHT * self._size()
        return self.height() - (52.0 if self.takes_hand else 36.0) - 0.5 * max(spare, 0.0)

    def _x(self, place: float) -> float:
        return self.width() / 2 + place / SPAN * (self.width() / 2 - 24)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("scene"))
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 8, 8)
        base = self._base()
        self._rail(painter, base)
        self._marks(painter, base)
        if self.takes_hand:
            self._hand(painter)
        if self.position is not None:
            self._handle(painter, base, self._x(max(min(self.position, _END), -_END)))

    def _rail(self, painter: QPainter, base: float) -> None:
        painter.setPen(QPen(theme.color("rail"), 3))
        painter.drawLine(QPointF(self._x(-0.06), base), QPointF(self._x(0.06), base))
        painter.setFont(theme.font("tick"))
        for tick in range(-60, 61, 5):
            x, long = self._x(1e-3 * tick), tick % 20 == 0
            painter.setPen(QPen(theme.color("rail"), 1))
            painter.drawLine(QPointF(x, base), QPointF(x, base + (8 if long else 5)))
            if long:
                painter.setPen(theme.color("axis"))
                words = number(tick, 0) + (" mm" if tick == 60 else "")
                painter.drawText(QRectF(x - 30, base + 10, 60, 18), Qt.AlignmentFlag.AlignCenter, words)

    def _hand(self, painter: QPainter) -> None:
        painter.setFont(theme.font("hint"))
        painter.setPen(theme.color("accent"))
        box = QRectF(10, self.height() - 18, self.width() - 20, 16)
        fits = [words for words in _HINTS if painter.fontMetrics().horizontalAdvance(words) <= box.width()]
        painter.drawText(box, Qt.AlignmentFlag.AlignLeft, fits[0] if fits else _HINTS[-1])
        ring = self.hand_place()
        if ring is None:
            return
        painter.setPen(QPen(theme.color("accent"), 2.5))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(ring)
        painter.drawPoint(ring.center())

    def _marks(self, painter: QPainter, base: float) -> None:
        for place, taken in self.marks:
            x, token = self._x(place), "ok" if taken else "accent"
            style = Qt.PenStyle.SolidLine if taken else Qt.PenStyle.DashLine
            painter.setPen(QPen(theme.color(token), 2, style))
            painter.drawLine(QPointF(x, 26), QPointF(x, base))
            painter.setPen(theme.color(token))
            painter.setFont(theme.font("strong"))
            words = f"{number(1e3 * place, 0)}{' ✓' if taken else ''}"
            painter.drawText(QRectF(x - 40, 4, 80, 20), Qt.AlignmentFlag.AlignCenter, words)

    def _handle(self, painter: QPainter, base: float, x: float) -> None:
        size = self._size()
        painter.save()
        painter.translate(x, base)
        painter.scale(size, size)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("handle"))
        painter.drawRect(QRectF(-3, -42, 6, 42))
        painter.drawRoundedRect(QRectF(-11, -4, 22, 8), 2, 2)
        painter.drawRoundedRect(QRectF(-20, -66, 40, 28), 8, 8)
        painter.setPen(QPen(theme.color("ridge"), 2))
        for ridge in (-7, 0, 7):
            painter.drawLine(QPointF(ridge, -60), QPointF(ridge, -44))
        painter.restore()
        if abs(self.force) > 0.005:
            self._arrow(painter, base - 52 * size, x, size)

    def _arrow(self, painter: QPainter, y: float, x: float, size: float) -> None:
        side = 1.0 if self.force > 0.0 else -1.0
        start = x + side * 26 * size
        tip = start + side * (14 + _PER_NEWTON * min(abs(self.force), 2.0))
        tip = min(max(tip, _EDGE), self.width() - _EDGE)
        painter.setPen(QPen(theme.color("applied"), 5))
        painter.drawLine(QPointF(start, y), QPointF(tip - side * 10, y))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("applied"))
        head = [QPointF(tip, y), QPointF(tip - side * 13, y - 8), QPointF(tip - side * 13, y + 8)]
        painter.drawPolygon(QPolygonF(head))
        painter.setPen(theme.color("applied"))
        painter.setFont(theme.font("strong"))
        words = f"{number(self.force, 2)} N"
        roomy = _WORDS <= tip <= self.width() - _WORDS
        at, right = (tip, side > 0.0) if roomy else (x - side * 26 * size, side < 0.0)
        box = QRectF(at + (6 if right else -_WORDS), y - 10, _WORDS - 6, 20)
        where = Qt.AlignmentFlag.AlignLeft if right else Qt.AlignmentFlag.AlignRight
        painter.drawText(box, where | Qt.AlignmentFlag.AlignVCenter, words)
