"""The stability card: the verdict for a held and a released handle, and a small stability map."""

import math
from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, Qt, QTimer, Signal
from PySide6.QtGui import QBrush, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from hapkit_studio.analysis.stability.margin import RELEASED, height, nice_width
from hapkit_studio.gui.panel.limits import JUDGING, CardRequest, CardResult, LoopFacts, answer
from hapkit_studio.gui.state.background import LatestResult
from hapkit_studio.gui.state.permissions import HIDDEN_BY_LESSON
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets import strokes
from hapkit_studio.gui.widgets.canvas import Canvas
from hapkit_studio.gui.widgets.parts import AnswerLines, hint, label, vbox
from hapkit_studio.gui.widgets.theme import number, theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.stability.verdict import VerdictInput
    from hapkit_studio.devices.base import Device
    from hapkit_studio.haptics.health import Health

LONG = 2e-3
"""s: a longer delay is explained. This value is two periods at 1 kHz; a good link needs half a period."""
_HEIGHT, _LEFT = 150, 68.0
_RING = 9  # px: radius of the ring that marks the dot as a warning
ASK_MS = 50
_LEAST_WIDTH = 4.0
_REGIONS = (
    "Green: the handle is stable. Amber: only friction stops the handle after a push of 1 mm. "
    "Hatched: the handle buzzes after a push of 1 mm."
)
_PALE = 0.35


def delay_reason(device: "Device", delay: float) -> str:
    """Return the most probable reason for a delay in s, and a remedy; "" for a short delay."""
    if not device.measures_delay or delay <= LONG:
        return ""
    if not device.usb_chip:
        return (
            "The virtual board and the window share this computer's processors. Let the board compute the "
            "force."
        )
    timer = latency_timer(device)
    cause = f"The USB chip delays each force by up to {timer} ms." if timer else "USB delays each force."
    if device.padding:
        return f"{cause} Let the board compute the force."
    return f"{cause} Run Set up my Hapkit… in the menu Device, or let the board render."


def latency_timer(device: "Device") -> str:
    """Return the USB chip's latency timer in ms; "" if it is short or unknown."""
    latency = device.latency
    return f"{1e3 * latency.timer:.0f}" if latency is not None and latency.long else ""


class StabilityMap(Canvas):
    """Paints the map of one verdict. A dot outside the frame is drawn at the frame's edge.

    The unstable region is hatched.
    """

    paper, below = "side", 36

    def __init__(self) -> None:
        self._answer: CardResult | None = None
        self._opacity = 1.0
        super().__init__(bottom=True, left_width=_LEFT)
        self.bottom.setLabel("damping, N·s/m")
        self.left.setLabel("stiffness, N/m")
        self.setAccessibleName(
            "Stability map: damping on the horizontal axis, stiffness on the vertical axis"
        )

    def recolor(self) -> None:
        """Apply the theme's colours and fonts."""
        super().recolor()
        self.setFixedHeight(theme.px(_HEIGHT))
        # move the tick labels away from the axis, so that a dot at zero damping does not cover them
        self.left.setStyle(tickTextOffset=theme.px(_RING) + 3)
        for axis in (self.bottom, self.left):
            axis.label.setFont(theme.font("tick"))
            axis.label.setDefaultTextColor(theme.color("ink3"))

    def show_answer(self, answer: CardResult) -> None:
        """Show another verdict; the axes include the dot, the limit, and the whole of a low boundary."""
        self._answer, self._opacity = answer, 1.0
        margin = answer.verdict.margins[answer.verdict.worst]
        highest = max([k for _, k in answer.edge if math.isfinite(k)], default=1.0)
        top = height(margin.stiffness, margin.limit, highest)
        self.view.setRange(xRange=(0.0, answer.question.width), yRange=(0.0, top), padding=0)
        self.viewport().update()

    def fade(self) -> None:
        """Paint the map in paler colours, because the verdict is out of date."""
        self._opacity = _PALE
        self.viewport().update()

    def paint_under(self, painter: QPainter, box: QRectF) -> None:
        """Paint the regions: unstable, stable for small knocks because of friction, and stable."""
        if self._answer is None:
            return
        edge, friction = (
            [self.pixel(b, min(k, 1e7)) for b, k in points]
            for points in (self._answer.edge, self._answer.friction)
        )
        painter.setOpacity(self._opacity)
        painter.fillRect(box, theme.color("unstable"))
        painter.fillRect(box, QBrush(theme.color("danger", 0.25), Qt.BrushStyle.BDiagPattern))
        painter.setPen(Qt.PenStyle.NoPen)
        for curve, token in ((friction, "warnsoft"), (edge, "stable")):
            painter.setBrush(theme.color(token))
            painter.drawPolygon(QPolygonF([*curve, box.bottomRight(), box.bottomLeft()]))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(theme.color("ink2"), 1, Qt.PenStyle.DashLine))
        painter.drawPolyline(QPolygonF(friction))
        painter.setPen(QPen(theme.color("ink"), 2))
        painter.drawPolyline(QPolygonF(edge))

    def paint_marks(self, painter: QPainter, box: QRectF) -> None:
        """Paint the dot and a dotted line to the boundary."""
        if self._answer is None:
            return
        painter.setOpacity(self._opacity)
        verdict, (_, top) = self._answer.verdict, self.view.viewRange()[1]
        margin = verdict.margins[verdict.worst]
        across = min(margin.damping, self._answer.question.width)
        dot, edge = (self.pixel(across, min(k, top)) for k in (margin.stiffness, margin.limit))
        token = "accent" if verdict.calm else verdict.sign[1]
        painter.setPen(QPen(theme.color(token), 1.6, Qt.PenStyle.DotLine))
        painter.drawLine(dot, edge)
        strokes.mark(painter, dot, "accent", 6.0)
        if not verdict.calm:
            painter.setPen(QPen(theme.color(token), 2))
            painter.drawEllipse(dot, theme.px(_RING), theme.px(_RING))


def details(answer: CardResult) -> str:
    """Return the text below a verdict: the reason or the nearest limit, then the delay."""
    verdict, setting = answer.verdict, answer.question.asked.setting
    delay = f"The delay is {number(setting.delay * 1e3, 2)} ms."
    return " ".join(part for part in (verdict.reason, delay, verdict.unknown) if part)


def caption(answer: CardResult) -> str:
    """Return the map's caption, which says whether the map is valid for a released or for a held handle."""
    whose = "after you let go" if answer.verdict.worst == RELEASED else "while you hold the handle"
    return f"This map is valid {whose}. Hatched: the handle buzzes."


class StabilityCard(QWidget):
    """Shows the verdict and the map; passes the unstable ranges to the studio.

    ``judged(text, icon, token)`` is emitted for the status bar.
    """

    judged = Signal(str, str, str)

    def __init__(self, studio: Studio):
        super().__init__()
        self._studio = studio
        self._worker = LatestResult(answer, self)
        self.facts = LoopFacts(studio, self)
        self._judged: CardResult | None = None
        self._room, self._mapped = True, False
        self.verdict, self.label, self.drives, self.map = AnswerLines(), hint(), hint(), StabilityMap()
        self.caption = hint()
        self.map.setToolTip(_REGIONS)
        parts = self.verdict, self.label, self.drives, self.map, self.caption
        vbox(label("Stability", "section"), *parts, into=self, gap=4)
        self._soon = QTimer(self, singleShot=True, interval=ASK_MS)
        self._soon.timeout.connect(self.ask)
        self._worker.answered.connect(self.show_answer)
        self._worker.late.connect(self.show_judging)
        for signal in (
            studio.settings_changed,
            studio.engine_changed,
            studio.hidden_changed,
            studio.lock_changed,
            studio.stop_changed,
            studio.link_changed,
            self.facts.changed,
        ):
            signal.connect(self._ask_soon)
        studio.lock_changed.connect(lambda: self.show_map(self._room))
        studio.environment_changed.connect(self._show_drives)
        self._show_drives()
        self.ask()

    @property
    def calm(self) -> bool:
        """Return whether the handle is known to come to rest, both held and released."""
        return self._judged is not None and self._judged.verdict.calm

    def note_health(self, health: "Health") -> None:
        """Update the measured delay."""
        self.facts.note_health(health)
        if self._judged is None:
            self._ask_soon()  # the reason for the missing verdict may have changed, for example after a fault

    def verdict_input(self) -> "VerdictInput | None":
        """Return the shown scene as the input of a verdict; None while the loop is unknown."""
        # imported late to keep start-up fast
        from hapkit_studio.analysis.stability.verdict import VerdictInput

        studio = self._studio
        setting = self.facts.setting(studio.grip)
        if setting is None or studio.engine is None:
            return None
        return VerdictInput(studio.environment, dict(studio.values), setting, studio.engine.max_force)

    @property
    def _hidden(self) -> str:
        """Return the reason why the verdict is hidden; "" if the verdict is shown."""
        permissions = self._studio.permissions
        return permissions.hidden or (HIDDEN_BY_LESSON if "verdict" in permissions.left_out else "")

    def question(self) -> CardRequest | None:
        """Return the request for the current scene; None while its loop or values are unknown."""
        asked = self.verdict_input()
        if asked is None or self._hidden:
            return None
        damping = asked.impedance[1] if asked.impedance else 0.0
        return CardRequest(asked, nice_width(damping, least=_LEAST_WIDTH))

    def ask(self) -> None:
        """Request a verdict, or show the reason why none can be computed."""
        question = self.question()
        if question is not None:
            self._worker.ask(question)
            return
        self._worker.forget()
        self._mapped = False
        self._show_no_verdict(*((self._hidden, "") if self._hidden else self.facts.why_unknown()))

    def show_judging(self) -> None:
        """Remove the previous scene's verdict until the new one is computed."""
        self.map.fade()
        self._show_no_verdict(JUDGING)

    def _show_no_verdict(self, headline: str, text: str = "") -> None:
        self._judged = None
        self.show_map(self._room)
        self.label.setText(text)
        self.verdict.show_text((headline, "circle", "ink2"))
        self.judged.emit(headline, "", "ink2")
        self._studio.note_ranges({})

    def show_answer(self, answer: CardResult) -> None:
        """Show a verdict."""
        self._judged, self._mapped, verdict = answer, bool(answer.edge), answer.verdict
        self.show_map(self._room)
        if answer.edge:
            self.map.show_answer(answer)
            self.caption.setText(caption(answer))
        self.label.setText(f"{details(answer)} {self._why_late(answer)}".rstrip())
        self.verdict.show_text(*verdict.signed)
        self.judged.emit(verdict.short, *verdict.sign)
        self._studio.note_ranges(answer.unstable_ranges)

    def show_map(self, room: bool) -> None:
        """Show the map if the verdict has one, a lesson does not hide it, and ``room`` is True."""
        self._room = room
        for part in (self.map, self.caption):
            part.setVisible(room and self._mapped and "map" not in self._studio.permissions.left_out)

    def wait(self) -> None:
        """Wait until the verdict is computed (tests only); Qt delivers it with the next events."""
        self._soon.stop()
        self._worker.wait()

    def _why_late(self, answer: CardResult) -> str:
        """Return an explanation of a long measured delay; the delay added by the user does not count."""
        engine = self._studio.engine
        if engine is None:
            return ""
        self.label.setToolTip(engine.device.latency.text if latency_timer(engine.device) else "")
        delay = answer.question.asked.setting.delay
        return delay_reason(engine.device, delay - self._studio.loop.delay)

    def _show_drives(self) -> None:
        text = self._studio.environment.drives
        self.drives.setText(text)
        self.drives.setVisible(bool(text))

    def _ask_soon(self) -> None:
        if not self._soon.isActive():
            self._soon.start()
