"""The state of the E-stop, and of a motor that stays off until the user presses *Render*."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from hapkit_studio.gui.state.device_link import DeviceLink

if TYPE_CHECKING:
    from hapkit_studio.haptics.engine import Engine


class StopState(QObject):
    """Keeps the E-stop latched when the device changes.

    If ``restored`` is True, the current settings come from an earlier run of the program; the motor then
    stays off until the user presses *Render*.
    """

    changed = Signal()

    def __init__(self, parent: QObject):
        super().__init__(parent)
        self.device: DeviceLink | None = None
        self.stopped = self.restored = False

    @property
    def _engine(self) -> "Engine | None":
        return None if self.device is None else self.device.engine

    def stop(self) -> None:
        """Set the force to zero at the next tick; it stays zero until the E-stop is released."""
        if self._engine is not None:
            self._engine.stop()
        if not self.stopped:
            self.stopped = True
            self.changed.emit()

    def release(self) -> None:
        """Release the E-stop; the force fades in."""
        self.restored &= not self.waiting
        self.stopped = False
        if self._engine is not None:
            self._engine.release_stop()
        self.changed.emit()

    @property
    def waiting(self) -> bool:
        """Return whether a motor stays off until the user presses *Render*."""
        return self.stopped and self._engine is not None and self.waits(self._engine)

    def wait_for_render(self) -> None:
        """Stop a motor until the user presses *Render*."""
        self.restored = True
        if self._engine is not None and self.waits(self._engine):
            self.stop()

    def waits(self, engine: "Engine") -> bool:
        """Return whether an engine's motor must stay off until the user presses *Render*."""
        return self.restored and engine.device.motor

    def stop_if_needed(self, engine: "Engine") -> None:
        """If an engine is stopped or waits for *Render*, keep its force at zero from its first tick on."""
        if self.stopped or self.waits(engine):
            engine.stop()
