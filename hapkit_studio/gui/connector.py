"""Opens and closes engines in one worker thread, so that a slow or dead port never holds the window."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from hapkit_studio.errors import PortGoneError, StudioError

if TYPE_CHECKING:
    from hapkit_studio.devices import DeviceEntry
    from hapkit_studio.haptics.engine import Engine

Build = Callable[["DeviceEntry"], "Engine"]


def build_engine(entry: "DeviceEntry") -> "Engine":
    """Make an entry's device and an engine for it; raise DeviceError."""
    from hapkit_studio.haptics.engine import Engine  # numba: only once the first picture is up

    return Engine(entry.make())


class Connector(QObject):
    """Emits ``opened`` with a started engine, or ``failed`` with one line; only the newest wish counts.

    The second argument of ``failed`` says whether the port is just not there.
    """

    opened = Signal(object)
    failed = Signal(str, bool)
    _finished = Signal(int, object)

    def __init__(self, build: Build = build_engine, parent: QObject | None = None):
        super().__init__(parent)
        self._build = build
        self._wish = 0
        self._started: list[Engine] = []
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="connect")
        self._finished.connect(self._deliver)

    def open(self, entry: "DeviceEntry", old: "Engine | None", ready: Callable[["Engine"], None]) -> None:
        """Close the old engine, then open an entry; ready(engine) runs in the worker before it starts."""
        self._wish += 1
        job = self._worker.submit(self._open, entry, old, ready, self._wish)
        job.add_done_callback(partial(self._finished.emit, self._wish))

    def close(self, engine: "Engine | None") -> None:
        """Close an engine and those nobody has taken yet, and wait for them; no wish is served after this."""
        self._wish += 1
        if engine is not None:
            self._worker.submit(engine.close)
        self._worker.shutdown(wait=True)
        for left in self._started:
            left.close()

    def _open(self, entry: Any, old: Any, ready: Callable[[Any], None], wish: int) -> "Engine | None":
        if old is not None:
            old.close()
        if wish != self._wish:
            return None
        engine = self._build(entry)
        ready(engine)
        try:
            engine.start()
        except Exception:
            engine.close()
            raise
        self._started.append(engine)
        return engine

    def _deliver(self, wish: int, job: "Future[Engine | None]") -> None:
        error = job.exception()
        if error is not None:
            if wish == self._wish:
                text = str(error) if isinstance(error, StudioError) else f"The device failed: {error!r}."
                self.failed.emit(text, isinstance(error, PortGoneError))
            return
        engine = job.result()
        if engine is None or engine not in self._started:
            return
        self._started.remove(engine)
        if wish != self._wish:
            self._worker.submit(engine.close)
        else:
            self.opened.emit(engine)
