"""Plays a demo in a loop and shows its captions at the bottom of the window."""

import time
from collections.abc import Callable
from contextlib import suppress

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.state.undo import ENVIRONMENT, Snapshot, differing, put, settings_of
from hapkit_studio.gui.teach.demos import Demo, Step
from hapkit_studio.gui.widgets.parts import Sign, hbox, hint, label, vbox
from hapkit_studio.gui.widgets.theme import theme

FRAME_MS = 16
HEIGHT = 68
_NO_HAND = "A board has no virtual hand, so the demo changes settings and captions only"
_RATE = "loop", "rate"


class DemoPlayer(QObject):
    """Changes settings and moves the virtual hand as a demo prescribes, until the user intervenes.

    The previous settings are then restored. If a motor stays off until the user presses *Render*, the demo
    goes on; any other E-stop ends the demo. The player never releases an E-stop. ``changed`` is emitted when
    a demo starts or ends, and for each new caption. ``clock()`` returns the time in s.
    """

    changed = Signal()

    def __init__(self, studio: Studio, parent: QObject, clock: Callable[[], float] = time.monotonic):
        super().__init__(parent)
        self._studio, self.clock = studio, clock
        self.demo: Demo | None = None
        self._start: float | None = None
        self._step: Step | None = None
        self._hand: float | None = None
        self._before: Snapshot = {}
        self._ours: Snapshot = {}
        self._frames = QTimer(self, interval=FRAME_MS, timerType=Qt.TimerType.PreciseTimer)
        self._frames.timeout.connect(self.tick)
        studio.settings_changed.connect(self._refresh)
        for signal in (studio.lock_changed, studio.hidden_changed):
            signal.connect(self.end)
        studio.stop_changed.connect(self._end_if_stopped)
        studio.engine_changed.connect(self._end_if_begun)

    @property
    def caption(self) -> str:
        """Return the current caption."""
        if self.demo is None:
            return ""
        return self._step.caption if self._step else "The demo begins as soon as everything is ready."

    @property
    def note(self) -> str:
        """Return why the demo does not move the hand; "" if it moves the hand."""
        studio = self._studio
        if self.demo is None or studio.engine is None or studio.hand_is_ours:
            return ""
        return (
            f"{_NO_HAND}; the force is zero until you press Render."
            if studio.waits_for_render
            else f"{_NO_HAND}."
        )

    @property
    def possible(self) -> bool:
        """Return whether a demo may change every setting."""
        permissions = self._studio.permissions
        return not (permissions.hidden or permissions.lock.places or permissions.lesson.places)

    def play(self, demo: Demo) -> None:
        """Start a demo in place of a running one; raise ParameterError if settings are locked or hidden."""
        if not self.possible:
            raise ParameterError("A demo cannot play while settings are locked or hidden.")
        self.end()
        self._before = self._ours = settings_of(self._studio)
        self._studio.stop_state.wait_for_render()
        self.demo, self._start, self._step, self._hand = demo, None, None, None
        self._frames.start()
        self.changed.emit()
        self.tick()

    def end(self) -> None:
        """Release the handle and restore the previous settings, except those that the user changed."""
        if self.demo is None:
            return
        self.demo = None
        self._frames.stop()
        if self._hand is not None:
            self._studio.move_hand(None)
        person_set = differing(self._studio, self._ours)
        back = {place: value for place, value in self._before.items() if place not in person_set}
        with self._studio.temporarily(), suppress(ParameterError):  # a deleted file may be needed
            put(self._studio, differing(self._studio, back))
        self.changed.emit()

    def tick(self) -> None:
        """Advance the demo to the current time."""
        studio, demo = self._studio, self.demo
        if demo is None or not self._is_ready(demo):
            return
        if studio.fault is not None:
            self.end()
            return
        now = self.clock()
        self._start = now if self._start is None else self._start
        place = (now - self._start) % demo.seconds
        step = demo.step(place)
        if step is not self._step:
            self._apply(step)
        hand = step.hand(place) if studio.hand_is_ours else None
        if self.demo is not None and hand != self._hand:
            self._hand = hand
            studio.move_hand(hand)

    def _is_ready(self, demo: Demo) -> bool:
        studio = self._studio
        waiting = (studio.readiness.state(key) in ("preparing", "next") for key in demo.environments)
        return studio.engine is not None and not any(waiting)

    def _apply(self, step: Step) -> None:
        """Apply a step's settings; end the demo if they are refused."""
        studio, changes = self._studio, differing(self._studio, step.settings)
        if studio.opened is None or studio.opened.own_clock:
            changes.pop(_RATE, None)
        try:
            with studio.temporarily():
                put(studio, changes)
        except ParameterError:
            self.end()
            return
        self._step, self._ours = step, settings_of(studio)
        if studio.environment.key != step.settings[ENVIRONMENT]:
            self.end()
            return
        self.changed.emit()

    def _refresh(self) -> None:
        """End the demo if the user has changed a setting."""
        if self.demo is not None and not self._studio.temporary and settings_of(self._studio) != self._ours:
            self.end()

    def _end_if_stopped(self) -> None:
        if self._studio.stopped and not self._studio.waits_for_render:
            self.end()
        self.changed.emit()

    def _end_if_begun(self) -> None:
        """End the demo when the device changes: the new device may have a real motor, or no virtual hand."""
        if self._start is not None:
            self.end()


class CaptionBar(QWidget):
    """Shows the demo's caption in large letters; the bar is hidden without a demo."""

    def __init__(self, player: DemoPlayer, parent: QWidget):
        super().__init__(parent)
        self._player = player
        self.setObjectName("caption")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.label, self.note, self.title = label(role="title"), hint(), label(role="hint", wrap=False)
        self.title.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.leave = QPushButton("End demo")
        self.leave.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.leave.setToolTip("End the demo and restore your settings. Taking the handle does the same")
        self.leave.clicked.connect(player.end)
        texts = vbox(None, self.label, self.note, None)
        beside = vbox(None, self.title, self.leave, None, gap=4)
        hbox(Sign(24, "play", "accent"), (texts, 1), beside, into=self, margins=(14, 0, 12, 0), gap=12)
        player.changed.connect(self.show_state)
        theme.changed.connect(self._fit)
        self._fit()
        self.show_state()

    def show_state(self) -> None:
        """Show the current caption."""
        demo, note = self._player.demo, self._player.note
        self.label.setText(self._player.caption)
        self.note.setText(note)
        self.note.setVisible(bool(note))
        self.title.setText(demo.title if demo else "")
        self.setAccessibleName(f"Demo: {self._player.caption}")
        self.setVisible(demo is not None)

    def _fit(self) -> None:
        # the height fits two lines, so that a longer caption does not move the layout
        self.setFixedHeight(theme.px(HEIGHT))
