"""Force over position: the law's static curve with all branches, and the applied force."""

from hapkit_studio.analysis import theory
from hapkit_studio.gui.live.plots.declared import PhasePlot

PLOT = PhasePlot(
    key="force_position",
    title="F–x",
    channel="position",
    reach=20.0,
    most=45.0,
    order=0,
    theory=theory.over_position,
)
