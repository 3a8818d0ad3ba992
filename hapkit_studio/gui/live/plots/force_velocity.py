"""Force over velocity: here the theory of friction and of purely velocity-dependent laws is a curve."""

from hapkit_studio.analysis import theory
from hapkit_studio.gui.live.plots.declared import PhasePlot

PLOT = PhasePlot(
    key="force_velocity",
    title="F–v",
    channel="velocity",
    reach=200.0,
    most=200.0,
    order=1,
    theory=theory.over_velocity,
)
