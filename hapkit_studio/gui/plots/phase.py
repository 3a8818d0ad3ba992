"""Force over position or velocity: the last seconds on top of the theory."""

from collections.abc import Mapping

from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.history import History


class ForcePosition(QWidget):
    """The applied force over the handle's position or velocity, older parts paler, theory beneath."""

    def set_history(self, history: History) -> None:
        """Plot another history."""

    def set_environment(self, environment, values: Mapping[str, float], max_force: float) -> None:
        """Recompute theory and limits (N) for another environment or other values."""

    def fit(self) -> None:
        """Narrow the axes to what is shown."""

    def set_paused(self, paused: bool) -> None:
        """Freeze the view; the history goes on filling."""

    def refresh(self) -> None:
        """Draw the newest data; call once per frame."""
