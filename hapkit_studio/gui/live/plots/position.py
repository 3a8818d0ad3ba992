"""Position over time, with the surface and the object that the handle moves."""

from hapkit_studio.gui.live.plots.declared import TimePlot, Trace

PLOT = TimePlot(
    key="position",
    title="Position",
    decimals=2,
    reach=12.0,
    share=30,
    order=0,
    traces=(
        Trace("object", "", "objline", dash=(6.0, 4.0), help="Position of the object in this scene"),
        Trace(
            "position",
            "position",
            "position",
            help="Position measured by the sensor, in steps of one sensor count",
        ),
    ),
    surface=True,
    folds=20,
)
