"""Force over velocity.

In this plot, the theory of a purely velocity-dependent law such as friction is a curve.
"""

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
