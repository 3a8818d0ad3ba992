"""Velocity over time, as the loop's estimator computes it."""

from hapkit_studio.gui.live.plots.declared import TimePlot, Trace

PLOT = TimePlot(
    key="velocity",
    title="Velocity",
    decimals=0,
    reach=120.0,
    share=27,
    order=1,
    traces=(
        Trace(
            "velocity",
            "velocity",
            "velocity",
            help="Velocity estimated from the measured position, not smoothed",
        ),
    ),
    folds=10,
)
