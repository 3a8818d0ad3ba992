"""Force over time. The applied force is drawn over the requested one, which is hidden if both are equal."""

from hapkit_studio.gui.live.plots.declared import TimePlot, Trace

_ASKED = "Asked force: the force that the law asks for. An arrow marks values beyond the plot"
PLOT = TimePlot(
    key="force",
    title="Force",
    decimals=2,
    reach=1.2,
    share=43,
    order=2,
    traces=(
        Trace("force", "asked", "asked", dashed=True, help=_ASKED),
        Trace(
            "applied_force",
            "applied",
            "applied",
            help="Applied force: what is sent to the motor, after the force limit. "
            "The Hapkit has no force sensor",
        ),
    ),
    limits=True,
)
