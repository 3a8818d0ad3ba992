"""Which environments can be had at once, while the laws of the others are still being compiled elsewhere."""

from collections.abc import Collection, Mapping, Sequence
from subprocess import Popen

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError

LOOK_MS = 100
# What a row says instead of its summary.
WORDS = {
    "preparing": "Preparing…",
    "next": "Preparing, comes next…",
    "broken": "Its law cannot be compiled",
}


class Readiness(QObject):
    """Knows each environment's state: "ready", "preparing", "next" (it is wished for) or "broken".

    Nothing is looked at once everything is ready. Where the programs that compile have ended, or died, and a
    law is not there, it is compiled in the window when it is chosen: late rather than never.
    ``changed``: a state; ``arrived(key)``: the newest wish can be had.
    """

    changed = Signal()
    arrived = Signal(str)

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self._waiting: dict[str, Environment] = {}
        self._late: dict[str, Environment] = {}
        self._broken: set[str] = set()
        self._programs: Sequence[Popen] | None = None
        self.wish: str | None = None
        self._watch = QTimer(self, interval=LOOK_MS)
        self._watch.timeout.connect(self.look)

    @property
    def waiting(self) -> tuple[str, ...]:
        """Return the keys of what is still being compiled."""
        return tuple(self._waiting)

    def state(self, key: str) -> str:
        """Return how an environment stands."""
        if key in self._broken:
            return "broken"
        if key in self._waiting:
            return "next" if key == self.wish else "preparing"
        return "ready"

    def expect(self, library: Mapping[str, Environment], soon: Collection[str]) -> None:
        """Wait from now on for what is not compiled, but for those that the loop begins with."""
        self._waiting = {k: e for k, e in library.items() if k not in soon and not e.force.is_compiled()}
        if self._waiting:
            self._watch.start()
            self.changed.emit()

    def follow(self, programs: Sequence[Popen]) -> None:
        """Wait for these programs, which compile what is expected, and no longer."""
        self._programs = programs
        self.look()

    def ask(self, key: str) -> bool:
        """Return whether an environment can be had now; if not, it is the wish instead of an older one."""
        if key in self._late:
            self._compile_here(key)
        ready = self.state(key) == "ready"
        if not ready or self.wish is not None:
            self.wish = key if key in self._waiting else None
            self.changed.emit()
        return ready

    def forget(self) -> None:
        """Forget the wish: something else was put in force."""
        if self.wish is not None:
            self.wish = None
            self.changed.emit()

    def end(self) -> None:
        """Wait for nothing any more."""
        self._watch.stop()

    def look(self) -> None:
        """Look what has been compiled; hand over the wish if it has."""
        done = self._programs is not None and all(p.poll() is not None for p in self._programs)
        ready = [key for key, e in self._waiting.items() if e.force.is_compiled()]
        for key in ready:
            del self._waiting[key]
        if done:
            self._late, self._waiting = self._waiting, {}
        if not self._waiting:
            self._watch.stop()
        if ready or done:
            self.changed.emit()
        if self.wish is not None and self.wish not in self._waiting:
            self.arrived.emit(self.wish)

    def _compile_here(self, key: str) -> None:
        environment = self._late.pop(key)
        try:
            environment.force.compiled()
        except LawError:
            self._broken.add(key)
