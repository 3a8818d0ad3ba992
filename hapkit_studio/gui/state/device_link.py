"""The current device: it is opened and closed in a thread, and reconnected after it was lost."""

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.errors import DeviceError, PortBusyError, PortGoneError, PortPermissionError, StudioError
from hapkit_studio.worker import Worker

if TYPE_CHECKING:
    from hapkit_studio.devices import DeviceEntry
    from hapkit_studio.haptics.engine import Engine
    from hapkit_studio.haptics.health import Health

Build = Callable[["DeviceEntry"], "Engine"]
RETRY_MS = 1000
TRIES = 3
"""Number of refusals of a reconnected port before they are reported, because access rights arrive late."""


@dataclass(frozen=True)
class LinkStatus:
    """State of the connection: preparing, connecting, running, idle, gone or failed.

    ``step`` and ``command`` are the next step and the command line that a DeviceError suggests.
    """

    state: str
    title: str = ""
    text: str = ""
    step: str = ""
    command: str = ""


def build_engine(entry: "DeviceEntry") -> "Engine":
    """Make an entry's device and an engine for it; raise DeviceError if this is not possible."""
    # imports numba, which must wait until the first frame is visible
    from hapkit_studio.haptics.engine import Engine

    return Engine(entry.make())


class DeviceLink(QObject):
    """Keeps the current device open and reconnects it after a loss; without a device, ``engine`` is None.

    Engines are opened and closed in a thread, and only the newest request is served. ``before_start(engine)``
    runs in that thread, ``configure(engine)`` in the window's thread after the start.
    """

    engine_changed = Signal()
    link_changed = Signal()
    _finished = Signal(int, object)
    _waits = Signal(int, str)

    def __init__(
        self,
        entries: Callable[[], Sequence["DeviceEntry"]],
        build: Build,
        before_start: Callable[["Engine"], None],
        configure: Callable[["Engine"], None],
        parent: QObject | None = None,
    ):
        super().__init__(parent)
        self.entries = entries
        self._build, self._before_start, self._configure = build, before_start, configure
        self.engine: Engine | None = None
        self.entry: DeviceEntry | None = None
        self.link = LinkStatus("preparing")
        self.padding = 0
        self._refusals = 0
        self._request = self._served = 0
        self._started: list[Engine] = []
        self._worker = Worker("connect")
        self._finished.connect(self._deliver)
        self._waits.connect(self._note_waiting)
        self._again = QTimer(self, interval=RETRY_MS)
        self._again.timeout.connect(self._retry)

    def open(self, entry: "DeviceEntry") -> None:
        """Close the current device and open another one in the worker; the force is zero meanwhile."""
        self.entry = entry
        self._again.stop()
        self._refusals = 0
        self._set_link(LinkStatus("connecting", entry.title))
        self._open(entry)

    def open_simulated(self) -> None:
        """Open the simulated device."""
        self.open(next(entry for entry in self.entries() if entry.key == "simulated"))

    def reconnect(self) -> None:
        """Close the current device and open it again."""
        if self.entry is not None:
            self.open(self.entry)

    def release_port(self, user: str = "") -> None:
        """Close the device so that another program can use its port; ``reconnect`` opens it again."""
        self._again.stop()
        text = f"In use: {user}" if user else ""
        self._set_link(LinkStatus("idle", self.entry.title if self.entry else "", text))
        self._request += 1  # close an engine that is still being opened, and do not report its failure
        old = self._detach()
        if old is not None:
            self._submit(old.close)

    def set_padding(self, size: int) -> None:
        """Set the number of bytes to which a board pads its frames (0: no padding).

        This takes effect at once.
        """
        self.padding = size
        if self.engine is not None:
            self.engine.device.pad_frames(size)

    def note_health(self, health: "Health") -> None:
        """Detect the loss of the device."""
        if self.link.state == "running" and not health.running and self.entry is not None:
            name = self.engine.device.name if self.engine is not None else self.entry.title
            gone = f"{name} is disconnected. The force is zero. Trying to reconnect every second."
            self._set_link(LinkStatus("gone", self.entry.title, health.message or gone))
            self._again.start()

    def close(self) -> None:
        """Stop the loop, wait for its last zero command, and ignore further requests."""
        self._again.stop()
        self._request += 1
        engine, self.engine = self.engine, None
        if engine is not None:
            self._worker.submit(engine.close)
        self._worker.shutdown()
        while self._started:
            self._started.pop().close()

    # opening, in the worker's thread

    def _open(self, entry: "DeviceEntry") -> None:
        self._submit(self._start, entry, self._detach(), self._request + 1)

    def _submit(self, work: Callable[..., "Engine | None"], *given: Any) -> None:
        self._request += 1
        job = self._worker.submit(work, *given)
        job.add_done_callback(partial(self._finished.emit, self._request))

    def _start(self, entry: "DeviceEntry", old: "Engine | None", request: int) -> "Engine | None":
        """Close the old engine and start a new one, unless a newer request has arrived."""
        if old is not None:
            old.close()
        if request != self._request:
            return None
        engine = self._build(entry)
        engine.device.report_opening(partial(self._waits.emit, request))
        engine.device.pad_frames(self.padding)
        self._before_start(engine)
        try:
            engine.start()
        except Exception:
            engine.close()
            raise
        self._started.append(engine)
        return engine

    # results

    def _deliver(self, request: int, job: "Future[Engine | None]") -> None:
        self._served = max(self._served, request)
        error = job.exception()
        if error is not None:
            if request == self._request:
                text = str(error) if isinstance(error, StudioError) else f"The device failed: {error!r}."
                self._fail(error if isinstance(error, DeviceError) else DeviceError(text))
            return
        engine = job.result()
        if engine is None or engine not in self._started:
            return
        self._started.remove(engine)
        if request != self._request:
            self._worker.submit(engine.close)
        else:
            self._adopt(engine)

    def _retry(self) -> None:
        """Try to reconnect, unless an attempt is running: a second one would reset a starting board."""
        if self.entry is not None and self._served == self._request:
            self._open(self.entry)

    def _detach(self) -> "Engine | None":
        old, self.engine = self.engine, None
        if old is not None:
            self.engine_changed.emit()
        return old

    def _note_waiting(self, request: int, text: str) -> None:
        """Show what the connection attempt is waiting for.

        If the board was lost before, also say that it is connected again.
        """
        link = self.link
        if request != self._request:
            return
        if link.state == "connecting":
            self._set_link(LinkStatus("connecting", link.title, text))
        elif link.state == "gone":
            self._set_link(
                LinkStatus("gone", link.title, f"{link.title} is connected again. {text} Force is zero.")
            )

    def _adopt(self, engine: "Engine") -> None:
        self._again.stop()
        self._refusals = 0
        self.engine = engine
        self._configure(engine)
        latency = engine.device.latency
        hint = latency.text if latency is not None and latency.long else ""
        self._set_link(LinkStatus("running", engine.device.name, hint))
        self.engine_changed.emit()

    def _fail(self, error: DeviceError) -> None:
        """Show the error. If the device was lost or its port is busy, keep trying to reconnect."""
        if self.link.state in ("gone", "failed") and self._again.isActive():
            if not self._should_report(error):
                return
        elif isinstance(error, PortGoneError):
            self._again.start()
        title = self.entry.title if self.entry else ""
        self._set_link(LinkStatus("failed", title, error.brief, error.step, error.command))

    def _should_report(self, error: DeviceError) -> bool:
        """Return whether to report a failed attempt, which is the case after several failures.

        After busy and permission errors, the attempts go on; after any other reported error, they end.
        """
        if isinstance(error, PortGoneError):
            self._refusals = 0
            self._set_link(replace(self.link, text=error.brief, step="", command=""))
            return False
        self._refusals += 1
        if self._refusals < TRIES:
            return False
        if not isinstance(error, (PortBusyError, PortPermissionError)):
            self._again.stop()
        return True

    def _set_link(self, link: LinkStatus) -> None:
        if link != self.link:
            self.link = link
            self.link_changed.emit()
