"""Force over time: asked below applied, so that one line means: you got what you asked for."""

from hapkit_studio.gui.live.plots.declared import TimePlot, Trace

_ASKED = "What the environment's law asked for; an arrow where it leaves the plot, beyond twice the limit"
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
            help="commanded after the clamp; the Hapkit has no force sensor",
        ),
    ),
    limits=True,
)
