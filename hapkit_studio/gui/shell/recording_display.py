"""Shows a recording in the header, in the status bar and in a banner."""

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

MESSAGE_MS = 5000  # ms: the status bar shows a message for this time
_RANK = 5
_WHOLE_S = 1.0  # s: tolerance of the displayed length, because only whole chunks are stored


class RecordingDisplay(QObject):
    """Shows a recording in the header, the stored samples in the status bar, and failures in a banner."""

    def __init__(
        self,
        recording: Recording,
        live: Live,
        header: Header,
        status: StatusBar,
        banners: BannerStack,
        show: Callable[[], Any],
    ):
        """``show()`` opens the view *Sessions*."""
        super().__init__(recording)
        self._recording, self._live = recording, live
        self._header, self._status, self._banners = header, status, banners
        self._message, self._quiet = "", QTimer(self, interval=MESSAGE_MS, singleShot=True)
        self._quiet.timeout.connect(lambda: self.show_message(""))
        header.record_pressed.connect(recording.toggle)
        status.show_sessions.connect(lambda: self._show_newest(show))
        recording.changed.connect(self.show_state)
        recording.failed.connect(self.show_failure)
        live.paused_changed.connect(lambda _on: self.show_state())
        self.show_state()
        try:
            chosen_folder()
        except FileError as error:
            self.show_failure(f"Recordings are saved in the folder {folder()}.", str(error))

    def show_state(self) -> None:
        """Show the recording's duration, the length of the stored samples, or the last written file."""
        progress = self._recording.progress
        time = clock(progress.seconds) if progress is not None else ""
        self._header.show_recording(time, self._recording.possible)
        self._status.show_record(*self._status_field(progress))
        if progress is not None:
            self._banners.set("recording", None)

    def _status_field(self, progress: "Progress | None") -> tuple:
        """Return text, sign and colour token of a status bar field, and whether it links to the sessions."""
        lost, newest = self._live.lost, self._recording.newest
        paused = "Paused. " if self._live.paused else ""
        if progress is not None:
            text = f"Recording {clock(progress.seconds)}, {megabytes(progress.size)}"
            return f"{paused}{text}", "record", "danger"
        if self._message:
            return self._message, "check", "ok"
        if newest is not None:
            return f"{newest[0].stem}, {megabytes(newest[1])}", "check", "ok", True
        if lost:
            return f"{lost:,} samples were lost", "triangle", "warn"
        buffered = self._recording.buffered
        return (f"{paused}You can save the last {_lasting(buffered)}" if buffered else "",)

    def _show_newest(self, show: Callable[[], Any]) -> None:
        show()
        # the user has now seen the written file, so the status bar shows the stored samples again
        self._recording.newest = None
        self.show_state()

    def show_message(self, text: str) -> None:
        """Show a message about a completed action in the status bar for MESSAGE_MS."""
        self._message = text
        self._quiet.start()
        self._banners.set("recording", None)
        self.show_state()

    def show_failure(self, what: str, why: str) -> None:
        """Show a banner that says which action failed, and why."""
        self._banners.warn("recording", what, why, _RANK)


def _lasting(seconds: float) -> str:
    minutes = int((seconds + _WHOLE_S) // 60)
    return f"{minutes} min" if minutes else f"{seconds:.0f} s"
