"""The thread that owns the board while the wizard has it: jobs one at a time, samples between them."""

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from hapkit_studio.devices.board_runner import BoardRunner
from hapkit_studio.errors import DeviceError, PortBusyError, StudioError

if TYPE_CHECKING:
    from hapkit_studio.protocol.messages import Sample

PATIENCE = 5.0
"""s for the studio's own loop to let go of the port."""
JOIN_SECONDS = 5.0
SPARE = 0.05

Job = Callable[[Any], object]


class Desk(QObject):
    """Opens a device in its own thread; ``start`` hands it a job on what ``prepared`` made of the bench.

    Signals arrive in the window's thread. ``failed``: the board is gone, nothing will run any more.
    """

    opened = Signal(object)
    done = Signal(object)
    refused = Signal(str)
    failed = Signal(str)
    _came = Signal(str, object, object)

    def __init__(
        self, make: Callable[[], Any], prepared: Callable[[BoardRunner], Any], parent: QObject | None = None
    ):
        super().__init__(parent)
        self._make, self._prepared = make, prepared
        self.bench: BoardRunner | None = None
        self.subject: Any = None
        self.busy = True
        self._job: Job | None = None
        self._after: Callable[[Any], object] | None = None
        self._quit = threading.Event()
        self._came.connect(self._tell)
        self._thread = self._made()

    def _made(self) -> threading.Thread:
        return threading.Thread(target=self._own, name="wizard", daemon=True)

    def begin(self) -> None:
        """Open the device."""
        self._thread.start()

    def again(self) -> None:
        """Open the device anew after it failed; nothing of the time before is kept."""
        self._thread.join(JOIN_SECONDS)
        if self._thread.is_alive() or self._quit.is_set():
            return
        self.bench = self.subject = self._job = self._after = None
        self.busy = True
        self._thread = self._made()
        self._thread.start()

    def start(self, job: Job, after: Callable[[Any], object]) -> bool:
        """Run a job on the subject, then ``after(result)`` here; False where one runs or no board is."""
        if self.busy or self.bench is None:
            return False
        self.busy = True
        self._after = after
        self._job = job
        return True

    def stop(self) -> None:
        """E-stop: at the next sample."""
        if self.bench is not None:
            self.bench.stop()

    def release(self) -> None:
        """End the E-stop."""
        if self.bench is not None:
            self.bench.release()

    @property
    def hand_is_ours(self) -> bool:
        """Say whether the board has a hand that the window moves."""
        return self.bench is not None and bool(getattr(self.bench.board, "hand", None) is True)

    def lead(self, place: float | None) -> None:
        """Hold the virtual board's hand at a place in m; None lets go."""
        if self.bench is not None and self.hand_is_ours:
            self.bench.board.move_hand(place)

    def samples(self) -> "list[Sample]":
        """Return the samples of the last ten seconds, oldest first."""
        return list(self.bench.recent) if self.bench is not None else []

    def end(self) -> None:
        """Motor off, let go of the board, wait for that; may be called twice."""
        self._quit.set()
        if self.bench is not None:
            self.bench.stop()
        if self._thread.is_alive():
            self._thread.join(JOIN_SECONDS)

    # in the thread

    def _own(self) -> None:
        bench = None
        try:
            bench = self._open()
            self.subject = self._prepared(bench)
            self.bench = bench
            self._came.emit("opened", self.subject, None)
            while not self._quit.is_set():
                self._turn(bench)
        except DeviceError as error:
            self._came.emit("failed", str(error), None)
        finally:
            if bench is not None:
                bench.close()

    def _open(self) -> BoardRunner:
        """Return an open bench; the loop may need a moment to let go of the port. Raise DeviceError."""
        deadline = time.monotonic() + PATIENCE
        while True:
            bench = BoardRunner(self._make())
            try:
                bench.open()
                return bench
            except PortBusyError:
                if time.monotonic() > deadline or self._quit.is_set():
                    raise
                time.sleep(SPARE)

    def _turn(self, bench: BoardRunner) -> None:
        """Watch until there is a job, then do it; the motor is off in between."""
        bench.idle(until=lambda: self._job is not None or self._quit.is_set())
        job, self._job = self._job, None
        if job is None:
            return
        try:
            self._came.emit("done", job(self.subject), None)
        except StudioError as error:
            self._came.emit("refused", str(error), None)

    def _tell(self, kind: str, what: Any, _none: object) -> None:
        self.busy = kind == "failed"
        after, self._after = self._after, None
        if kind == "done" and after is not None:
            after(what)
        getattr(self, kind).emit(what)
