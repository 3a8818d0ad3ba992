"""Shows a recording in the header, the status bar and a banner."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, QTimer

from hapkit_studio.errors import FileError
from hapkit_studio.formatting import clock, megabytes
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.shell.banners import BannerStack
from hapkit_studio.gui.shell.header import Header
from hapkit_studio.gui.shell.status_bar import StatusBar
from hapkit_studio.gui.state.recording import Recording
from hapkit_studio.sessions.folder import chosen_folder, folder

if TYPE_CHECKING:
    from hapkit_studio.sessions.recorder import Progress

SAID_MS = 5000  # how long the status bar says what was written
_RANK = 5
_WHOLE_S = 1.0  # what is kept ends with a chunk, not with the second


class RecordingDisplay(QObject):
    """Shows a recording in the header, what is kept in the status bar, and what failed as a banner."""

    def __init__(
        self,
        recording: Recording,
        live: Live,
        header: Header,
        status: StatusBar,
        banners: BannerStack,
        show: Callable[[], Any],
    ):
        """show: brings the sessions into sight."""
        super().__init__(recording)
        self._recording, self._live = recording, live
        self._header, self._status, self._banners = header, status, banners
        self._said, self._quiet = "", QTimer(self, interval=SAID_MS, singleShot=True)
        self._quiet.timeout.connect(lambda: self.say(""))
        header.record_pressed.connect(recording.toggle)
        status.show_sessions.connect(lambda: self._show_newest(show))
        recording.changed.connect(self.show_state)
        recording.failed.connect(self.show_failure)
        live.paused_changed.connect(lambda _on: self.show_state())
        self.show_state()
        try:
            chosen_folder()
        except FileError as error:
            self.show_failure(f"Recordings go into {folder()}.", str(error))

    def show_state(self) -> None:
        """Show whether it records and for how long, how much is kept, what was written last."""
        progress = self._recording.progress
        time = clock(progress.seconds) if progress is not None else ""
        self._header.show_recording(time, self._recording.possible)
        self._status.show_kept(*self._words(progress))
        if progress is not None:
            self._banners.set("recording", None)

    def _words(self, progress: "Progress | None") -> tuple:
        """Return words for the status bar, a sign, its token, and whether the sessions are offered."""
        lost, newest = self._live.lost, self._recording.newest
        paused = "Paused. " if self._live.paused else ""
        if progress is not None:
            words = f"Recording {clock(progress.seconds)}, {megabytes(progress.size)}"
            return f"{paused}{words}", "record", "danger"
        if self._said:
            return self._said, "check", "ok"
        if newest is not None:
            return f"{newest[0].stem}, {megabytes(newest[1])}", "check", "ok", True
        if lost:
            return f"{lost:,} rows not read", "triangle", "warn"
        kept = self._recording.kept
        return (f"{paused}Last {_lasting(kept)} kept" if kept else "",)

    def _show_newest(self, show: Callable[[], Any]) -> None:
        show()
        self._recording.newest = None  # it was seen: the status bar is free for what is kept
        self.show_state()

    def say(self, words: str) -> None:
        """Say for a while in the status bar what was done."""
        self._said = words
        self._quiet.start()
        self._banners.set("recording", None)
        self.show_state()

    def show_failure(self, what: str, why: str) -> None:
        """Say in two sentences what was not done, and why."""
        self._banners.warn("recording", what, why, _RANK)


def _lasting(seconds: float) -> str:
    minutes = int((seconds + _WHOLE_S) // 60)
    return f"{minutes} min" if minutes else f"{seconds:.0f} s"
