"""Force over position: the law's static curve, and what was rendered."""

from collections.abc import Mapping

import numpy as np

from hapkit_studio.gui.plots.declared import PhasePlot


def theory(environment, values: Mapping[str, float], position: np.ndarray) -> np.ndarray | None:
    """Return the force at rest (n,) in N; None where the law depends on velocity alone."""
    still = environment.curve(values, position)
    moving = environment.curve(values, position[:1], 0.1)[0]
    return None if not np.ptp(still) and moving != still[0] else still


PLOT = PhasePlot(
    key="force_position",
    title="F–x",
    label="position, mm",
    channel="position",
    unit="mm",
    scale=1e3,
    reach=20.0,
    order=0,
    theory=theory,
)
