"""Energy given to handle and hand over time, and how much the scene could give."""

from hapkit_studio.gui.live.plots.declared import TimePlot, Trace

PLOT = TimePlot(
    key="energy",
    title="Energy",
    decimals=1,
    reach=2.0,
    share=100,
    order=50,
    traces=(
        Trace(
            "energy_limit",
            "limit",
            "danger",
            dash=(2.0, 4.0),
            help="The most a passive scene can have given: what was stored where the sum began and what the "
            "paddle's own damping took. Above it the loop has made energy",
        ),
        Trace(
            "energy_given",
            "to the hand",
            "energy",
            dash=(9.0, 4.0, 2.0, 4.0),
            help="Force times way since the scene, its values or the loop last changed",
        ),
    ),
    beside=True,
    marker="diamond",
)
