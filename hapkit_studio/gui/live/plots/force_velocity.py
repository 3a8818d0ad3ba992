"""Force over velocity: for friction and for laws of velocity alone the theory is a curve here."""

from collections.abc import Mapping

import numpy as np

from hapkit_studio.gui.live.plots.declared import PhasePlot


def theory(environment, values: Mapping[str, float], velocity: np.ndarray) -> np.ndarray | None:
    """Return the force over velocity in N, (branches, n); None where it depends on position."""
    if environment.over_velocity is not None:
        force = np.atleast_2d(environment.over_velocity(values, velocity))
        return force if np.isfinite(force).any() else None
    if environment.over_position is not None:
        return None
    places = np.linspace(-0.05, 0.05, 21)
    if np.ptp(environment.curve(values, places)):
        return None
    origin = np.zeros(1)
    return np.array([[environment.curve(values, origin, v)[0] for v in velocity]])


PLOT = PhasePlot(
    key="force_velocity",
    title="F–v",
    label="velocity, mm/s",
    channel="velocity",
    unit="mm/s",
    scale=1e3,
    reach=200.0,
    most=200.0,
    order=1,
    theory=theory,
)
