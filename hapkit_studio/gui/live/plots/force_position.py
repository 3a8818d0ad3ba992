"""Force over position: the law's static curve, every branch of it, and what was rendered."""

from collections.abc import Mapping

import numpy as np

from hapkit_studio.gui.live.plots.declared import PhasePlot


def theory(environment, values: Mapping[str, float], position: np.ndarray) -> np.ndarray | None:
    """Return the force at rest in N, (branches, n); None where the law depends on velocity alone."""
    if environment.over_position is not None:
        force = np.atleast_2d(environment.over_position(values, position))
        return force if np.isfinite(force).any() else None
    if environment.over_velocity is not None:
        return None
    still = environment.curve(values, position)
    moving = environment.curve(values, position[:1], 0.1)[0]
    return None if not np.ptp(still) and moving != still[0] else still[np.newaxis]


PLOT = PhasePlot(
    key="force_position",
    title="F–x",
    label="position, mm",
    channel="position",
    unit="mm",
    scale=1e3,
    reach=20.0,
    most=45.0,
    order=0,
    theory=theory,
)
