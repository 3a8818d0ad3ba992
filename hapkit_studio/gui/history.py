"""The last minute of telemetry, kept so that any stretch is drawn in time proportional to its width."""

import numpy as np


class History:
    """Ring of the channels the plots show; ``append`` takes telemetry rows as the reader gives them."""

    def __init__(self, seconds: float = 60.0, rate: float = 10000.0):
        """Make room for this many seconds at this rate in Hz."""

    def append(self, rows: np.ndarray) -> None:
        """Take (n, 32) telemetry rows, oldest first."""

    def clear(self) -> None:
        """Forget everything."""
