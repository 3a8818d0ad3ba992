"""The scene: the handle on its rail, the environment around it, and the mouse as the hand."""

from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget


class SceneView(QWidget):
    """Paints one environment at the measured position; the pointer or the arrow keys are the hand."""

    hand_moved = Signal(float)
    hand_released = Signal()

    def set_environment(self, environment, values: Mapping[str, float]) -> None:
        """Show another environment."""

    def set_values(self, values: Mapping[str, float]) -> None:
        """Take over changed parameters."""

    def update_state(
        self,
        position: float,
        applied: float,
        asked: float,
        hand_target: float | None,
        clamped: bool,
        stopped: bool,
        state: np.ndarray,
    ) -> None:
        """Show the newest row: position in m, forces in N, hand_target in m or None if released."""

    def set_hand_enabled(self, enabled: bool) -> None:
        """Say whether pointer and keys are the hand (simulated) or a person's is (real board)."""

    def set_preparing(self, preparing: bool, fraction: float | None = None) -> None:
        """Show words and a bar in the scene's place; fraction 0..1, None if unknown."""
