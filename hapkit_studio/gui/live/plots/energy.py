"""Energy over time: the energy given to the hand, and the most that a passive scene could have given."""

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
            help="Limit: the most energy that a passive scene could have given you. Above this line, the "
            "loop has added energy",
        ),
        Trace(
            "energy_given",
            "to the hand",
            "energy",
            dash=(9.0, 4.0, 2.0, 4.0),
            help="Energy to the hand: the energy that the scene has given since the last change of a "
            "setting (force times distance)",
        ),
    ),
    beside=True,
    marker="diamond",
)
