"""Numbers at what moves: taken ten times a second, but never of another sign than the arrow beside them."""

from PySide6.QtCore import QElapsedTimer

from hapkit_studio.gui.scenes.actors import Motion
from hapkit_studio.gui.scenes.arrow import direction, force_words

EACH_MS = 100


class ReadOut:
    """Writes a motion's numbers; a force that comes and goes has one number for each way it acts."""

    def __init__(self) -> None:
        self._clock = QElapsedTimer()
        self._said: dict[int, str] = {}

    def invalidate(self) -> None:
        """Take every number anew at the next look."""
        self._clock.invalidate()

    def look(self, motion: Motion) -> bool:
        """Set the motion's numbers; say whether they are new."""
        due = not self._clock.isValid() or self._clock.elapsed() >= EACH_MS
        if due:
            self._clock.start()
            self._said.clear()
            motion.position_text = motion.position
        motion.force_text = self._said.setdefault(direction(motion.force), force_words(motion.force))
        return due
