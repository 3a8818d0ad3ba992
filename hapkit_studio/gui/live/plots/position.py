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
        Trace("object", "", "objline", dash=(6.0, 4.0), help="Where the object of this scene is"),
        Trace(
            "position", "position", "position", help="Measured by the sensor, in steps of one sensor count"
        ),
    ),
    surface=True,
    folds=20,
)
