"""Opens and closes engines in one worker thread, so that a slow or dead port never holds the window."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from hapkit_studio.errors import DeviceError, StudioError

if TYPE_CHECKING:
    from hapkit_studio.devices import DeviceEntry
    from hapkit_studio.haptics.engine import Engine

Build = Callable[["DeviceEntry"], "Engine"]


def build_engine(entry: "DeviceEntry") -> "Engine":
    """Make an entry's device and an engine for it; raise DeviceError."""
    from hapkit_studio.haptics.engine import Engine  # numba: only once the first picture is up

    return Engine(entry.make())


class Connector(QObject):
    """Emits ``opened`` with a started engine, or ``failed`` with a DeviceError; only the newest wish counts.

    ``waiting`` says in words what opening waits for.
    """

    opened = Signal(object)
    failed = Signal(object)
    waiting = Signal(str)
    _finished = Signal(int, object)
    _waits = Signal(int, str)

    def __init__(self, build: Build = build_engine, parent: QObject | None = None):
        super().__init__(parent)
        self._build = build
        self._wish = self._served = 0
        self._started: list[Engine] = []
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="connect")
        self._finished.connect(self._deliver)
        self._waits.connect(self._tell)

    @property
    def busy(self) -> bool:
        """Say whether the newest wish is still being served."""
        return self._served < self._wish

    def open(self, entry: "DeviceEntry", old: "Engine | None", ready: Callable[["Engine"], None]) -> None:
        """Close the old engine, then open an entry; ready(engine) runs in the worker before it starts."""
        self._wish += 1
        job = self._worker.submit(self._open, entry, old, ready, self._wish)
        job.add_done_callback(partial(self._finished.emit, self._wish))

    def leave(self, engine: "Engine") -> None:
        """Close an engine and open none."""
        self._wish += 1
        job = self._worker.submit(self._leave, engine)
        job.add_done_callback(partial(self._finished.emit, self._wish))

    def close(self, engine: "Engine | None") -> None:
        """Close an engine and those nobody has taken yet, and wait for them; no wish is served after this."""
        self._wish += 1
        if engine is not None:
            self._worker.submit(engine.close)
        self._worker.shutdown(wait=True)
        while self._started:
            self._started.pop().close()

    def _open(self, entry: Any, old: Any, ready: Callable[[Any], None], wish: int) -> "Engine | None":
        if old is not None:
            old.close()
        if wish != self._wish:
            return None
        engine = self._build(entry)
        if hasattr(engine.device, "say"):
            engine.device.say = partial(self._waits.emit, wish)
        ready(engine)
        try:
            engine.start()
        except Exception:
            engine.close()
            raise
        self._started.append(engine)
        return engine

    @staticmethod
    def _leave(engine: Any) -> None:
        engine.close()

    def _tell(self, wish: int, words: str) -> None:
        if wish == self._wish:
            self.waiting.emit(words)

    def _deliver(self, wish: int, job: "Future[Engine | None]") -> None:
        self._served = max(self._served, wish)
        error = job.exception()
        if error is not None:
            if wish == self._wish:
                self.failed.emit(_as_device_error(error))
            return
        engine = job.result()
        if engine is None or engine not in self._started:
            return
        self._started.remove(engine)
        if wish != self._wish:
            self._worker.submit(engine.close)
        else:
            self.opened.emit(engine)


def _as_device_error(error: BaseException) -> DeviceError:
    """Return an error that a window can show, whatever it was."""
    if isinstance(error, DeviceError):
        return error
    text = str(error) if isinstance(error, StudioError) else f"The device failed: {error!r}."
    return DeviceError(text)
