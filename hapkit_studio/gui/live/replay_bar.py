"""The bar below the plots during a replay: the position, the speed, and a button to close the replay."""

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QHelpEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QComboBox, QFrame, QPushButton, QToolTip, QWidget

from hapkit_studio.formatting import clock
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.live.replay import SPEEDS, Replay
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.parts import hbox, hint, label, vbox
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.sessions.event_values import one_line

Marks = list[tuple[float, str]]
# px: height of the line's widget, margin at its ends, radius of the thumb, thickness of the line
_HEIGHT, _END, _THUMB, _THICK = 24, 8, 6, 4
_MOST_DRAWN = 2_000  # maximum number of changes that are drawn; about the number of pixels of the line
_NEAR = 5  # px: a mark's text is shown if the pointer is nearer than this


def tenths(seconds: float) -> str:
    """Format a time in s as 0:12.3."""
    whole, tenth = divmod(int(10.0 * seconds), 10)
    return f"{clock(whole)}.{tenth}"


class SeekLine(QWidget):
    """The session as a slider; a press or drag emits the new position in s. It takes no keyboard focus."""

    sought = Signal(float)

    def __init__(self) -> None:
        super().__init__()
        self.setMinimumWidth(120)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setAccessibleName("Time in the replayed session")
        self._seconds, self._time = 0.0, 0.0
        self.markers: Marks = []
        self.changes: Marks = []
        self._drawn: Marks = []

    def show_session(self, seconds: float, markers: Marks, changes: Marks) -> None:
        """Show a session of this duration in s, with its markers and changes as (time in s, text)."""
        self._seconds, self.markers, self.changes = seconds, markers, changes
        apart = seconds / _MOST_DRAWN if seconds else 1.0
        self._drawn = list({when // apart: (when, text) for when, text in changes}.values())
        self.update()

    def show_time(self, seconds: float) -> None:
        """Show the replay position in s."""
        self._time = seconds
        self.update()

    def sizeHint(self) -> QSize:
        return QSize(400, theme.px(_HEIGHT))

    def place(self, seconds: float) -> float:
        """Return the x coordinate in px of a time in s."""
        part = seconds / self._seconds if self._seconds else 0.0
        return theme.px(_END) + part * (self.width() - 2 * theme.px(_END))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            part = (event.position().x() - theme.px(_END)) / max(1, self.width() - 2 * theme.px(_END))
            self.sought.emit(min(max(part, 0.0), 1.0) * self._seconds)

    mousePressEvent = mouseMoveEvent

    def event(self, event: QEvent) -> bool:
        """Show a tooltip with the marks under the pointer."""
        if isinstance(event, QHelpEvent) and event.type() == QEvent.Type.ToolTip:
            near = [mark for mark in sorted([*self.markers, *self.changes])
                    if abs(self.place(mark[0]) - event.pos().x()) <= _NEAR]  # fmt: skip
            QToolTip.showText(event.globalPos(), "\n".join(f"{tenths(when)}  {text}" for when, text in near))
            return True
        return super().event(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle, thumb, thick = self.height() / 2.0, self.place(self._time), theme.px(_THICK)
        painter.setPen(Qt.PenStyle.NoPen)
        begin = self.place(0.0)
        for token, end in (("line", self.place(self._seconds)), ("accent", thumb)):
            painter.setBrush(theme.color(token))
            painter.drawRoundedRect(QRectF(begin, middle - thick / 2, end - begin, thick), 2, 2)
        for marks, half, token in ((self._drawn, 5, "ink3"), (self.markers, 9, "ink")):
            reach = theme.px(half)
            painter.setPen(QPen(theme.color(token), 1.5))
            for when, _ in marks:
                x = self.place(when)
                painter.drawLine(QPointF(x, middle - reach), QPointF(x, middle + reach))
        painter.setBrush(theme.color("surface"))
        painter.setPen(QPen(theme.color("accent"), 3))
        painter.drawEllipse(QPointF(thumb, middle), theme.px(_THUMB), theme.px(_THUMB))


class ReplayBar(QWidget):
    """Shows the replay's state and forwards its buttons' actions; visible only during a replay."""

    def __init__(self, replay: Replay, live: Live, parent: QWidget):
        super().__init__(parent)
        self._replay, self._live = replay, live
        self.name, self.label, self.time = label(role="strong", wrap=False), hint(), label(wrap=False)
        self.back = self._button("step_back", "Go back by one picture (←) or by one sample (Shift+←)")
        self.play = self._button("pause", "Play or pause the replay (Space)")
        self.on = self._button("step_on", "Go forward by one picture (→) or by one sample (Shift+→)")
        self.speed = QComboBox()
        self.speed.addItems([f"{speed:g} ×" for speed in SPEEDS])
        self.speed.setAccessibleName("Speed of the replay")
        self.line = SeekLine()
        self.leave = QPushButton("Close the replay", autoDefault=True)
        self.leave.setToolTip(
            "Return to the live view and to the settings from before the replay. The same happens when you "
            "change a setting"
        )
        card = QFrame()
        card.setProperty("card", True)
        row = hbox(
            self.name, 4, self.back, self.play, self.on, self.speed, (self.line, 1), self.time, self.leave,
            gap=6,
        )  # fmt: skip
        vbox(row, self.label, into=card, margins=(14, 5, 8, 5), gap=2)
        vbox(card, into=self, margins=(12, 0, 12, 12))
        self.back.clicked.connect(lambda: replay.step(-1))
        self.on.clicked.connect(lambda: replay.step(1))
        self.play.clicked.connect(live.toggle_paused)
        self.speed.activated.connect(lambda index: replay.set_speed(SPEEDS[index]))
        self.line.sought.connect(replay.seek)
        self.leave.clicked.connect(replay.close)
        live.paused_changed.connect(lambda _paused: self._show_play())
        theme.changed.connect(self._show_play)
        replay.changed.connect(self.show_session)
        replay.moved.connect(self.show_place)
        self.show_session()

    def show_session(self) -> None:
        """Show another session, or hide the bar."""
        history = self._replay.history
        self.setVisible(history is not None)
        if history is None:
            return
        self.name.setText(f"Replay: {one_line(history.session.path.stem)}")
        markers, changes = (
            [(when - history.start, text) for when, text in marks]
            for marks in (history.markers, history.changed)
        )
        self.line.show_session(self._replay.seconds, markers, changes)
        self._show_play()
        self.show_place()

    def show_place(self) -> None:
        """Show the position, the speed, and the settings that could not be applied."""
        replay = self._replay
        self.line.show_time(replay.time)
        self.time.setText(f"{tenths(replay.time)} / {tenths(replay.seconds)}")
        self.speed.setCurrentIndex(SPEEDS.index(replay.speed))
        damage = replay.history.session.damage if replay.history is not None else ()
        self.label.setText(" ".join((*damage, replay.refusal)).strip())
        self.label.setVisible(bool(self.label.text()))

    def _show_play(self) -> None:
        paused = self._live.paused
        self.play.setIcon(icons.icon("play" if paused else "pause", "ink", 18))
        self.play.setAccessibleName("Play" if paused else "Pause")

    def _button(self, icon: str, tip: str) -> QPushButton:
        button = QPushButton()
        button.setProperty("flat", True)
        button.setToolTip(tip)
        button.setAccessibleName(tip)
        icons.bind(button, icon, "ink", 18)
        return button
