"""The live time plots: position, velocity and force over one time axis."""

from collections.abc import Mapping

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.history import History


class TimePlots(QWidget):
    """Three linked plots of a history's last seconds; frozen and free to pan and zoom while paused."""

    span_changed = Signal(float)
    paused_changed = Signal(bool)

    def set_history(self, history: History) -> None:
        """Plot another history."""

    def set_environment(self, environment, values: Mapping[str, float], max_force: float) -> None:
        """Take over what is drawn besides data: contact shading, the wall's line, the force limit in N."""

    def set_span(self, seconds: float) -> None:
        """Show the last 1 to 60 seconds."""

    def set_paused(self, paused: bool) -> None:
        """Freeze the view; the history goes on filling."""

    def set_stale(self, stale: bool) -> None:
        """Paint frozen and paler while the device is gone."""

    def fit(self) -> None:
        """Narrow the value axes to what is shown."""

    def refresh(self) -> None:
        """Draw the newest data; call once per frame."""
