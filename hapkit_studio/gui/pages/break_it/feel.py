"""Puts a failure into the live scene and restores all settings afterwards."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.state.undo import ENVIRONMENT, Snapshot, put, settings_of

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures.base import Live


class Feel(QObject):
    """Stores the settings from before the first failure was put into the scene, and restores them.

    If the user chooses another scene, other values or another loop, the failure is no longer in the scene,
    and ``felt`` is "". The previous settings can still be restored, except a scene that the user has
    replaced. ``refused``: the loop rejected the failure's settings after its environment had been compiled.
    """

    changed = Signal()
    refused = Signal(str)

    def __init__(self, studio: Studio, parent: QObject | None = None):
        super().__init__(parent)
        self._studio = studio
        self.live: Live | None = None
        self.key = ""
        self._before: Snapshot = {}
        self._waiting = self._busy = False
        self._put: tuple[dict[str, float], LoopSettings] | None = None
        studio.environment_changed.connect(self._arrive)
        studio.settings_changed.connect(self._refresh)

    @property
    def on(self) -> bool:
        """Return whether there are settings to restore."""
        return bool(self._before)

    @property
    def felt(self) -> str:
        """Return the key of the failure that is in the scene unchanged; "" for none."""
        live, studio = self.live, self._studio
        if live is None or studio.environment.key != live.environment:
            return ""
        return self.key if self._put == (studio.values_of(live.environment), studio.loop) else ""

    def put(self, key: str, live: "Live") -> None:
        """Put a failure into the scene; raise ParameterError and restore everything if it is refused."""
        studio = self._studio
        now = settings_of(studio).items()
        ours = {at: what for at, what in now if at[0] != "value" or at[1] == live.environment}
        self._before = ours | self._before
        self.live, self.key, self._busy, self._put = live, key, True, None
        try:
            studio.set_values_of(live.environment, live.values)
            studio.choose(live.environment)
            self._waiting = True
            self._go_on()
        except ParameterError:
            self.take_back()
            raise
        finally:
            self._busy = False
        self.changed.emit()

    def take_back(self) -> None:
        """Restore the settings from before the first failure."""
        before, self._before = self._before, {}
        if not before:
            return
        self._waiting, self.live, self.key, self._put = False, None, "", None
        if before[ENVIRONMENT] not in self._studio.environments:
            del before[ENVIRONMENT]  # the user's own environment was deleted meanwhile
        with self._studio.temporarily():  # settings that were locked meanwhile are restored, too
            put(self._studio, before)
        self.changed.emit()

    def _arrive(self) -> None:
        try:
            self._go_on()
        except ParameterError as error:
            self.take_back()
            self.refused.emit(str(error))

    def _go_on(self) -> None:
        """Set loop and grip as soon as the environment runs; do nothing while it is still being compiled."""
        live = self.live
        if not self._waiting or live is None or self._studio.environment.key != live.environment:
            return
        self._waiting = False
        self._studio.set_loop(**live.loop, hand=live.grip)
        self._put = self._studio.values_of(live.environment), self._studio.loop

    def _refresh(self) -> None:
        """React to the user's changes; an environment that the user chose stays after *Feel it* ends."""
        if not self._before or self._busy or self._waiting or self.live is None:
            return
        if self._studio.environment.key != self.live.environment:
            self._before[ENVIRONMENT] = self._studio.environment.key
        self.changed.emit()
