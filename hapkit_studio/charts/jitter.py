"""What a loop's jitter costs: the stiffness up to which motions die out over how late the forces come."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from hapkit_studio.analysis.stability.kb_plane import conditions
from hapkit_studio.charts import style

if TYPE_CHECKING:
    from hapkit_studio.analysis.stability.irregular import Cost

_SIZE = (792, 504)
_LEAST = 0.02  # of a limit: less than that around the lines would be all noise
_KEY = (
    "Across: the mean by which forces come later than the delay, the recorded lateness from none to double. "
    "Each force as late as one of the recorded samples, drawn anew; none later than the next sample."
)


def jitter_figure(cost: "Cost", path: str | Path) -> None:
    """Write what a recorded lateness costs, theory and measurement, and the conditions."""
    pairs = [("Virtual damping", f"{cost.damping:g} N·s/m"), *conditions(cost.setting)]
    title = f"The recorded jitter costs {cost.words}."
    caption = f"{_KEY}\n{style.unbroken([' '.join(pair) for pair in pairs])}"
    style.save(lambda figure, c: draw(figure, c, cost), path, _SIZE, title, caption)


def draw(figure: Any, c: style.Colors, cost: "Cost") -> None:
    """Draw the limits over the mean lateness; the recorded one is marked with its cost."""
    axes, late = figure.add_subplot(), 1e3 * cost.late
    style.style_axes(axes, c, "forces late by, in the mean, ms", "stiffness, N/m")
    steady, here, limit = cost.limits[0], late[cost.here], cost.limits[cost.here]
    axes.set_xlim(0.0, 1.04 * max(float(late[-1]), 1e-6))
    least, most = min(*cost.limits, *cost.measured), max(*cost.limits, *cost.measured)
    apart = 0.3 * (most - least) + _LEAST * most
    axes.set_ylim(max(least - apart, 0.0), most + apart)
    axes.yaxis.set_major_formatter("{x:,.0f}")
    axes.axhline(steady, color=c.ink2, linewidth=2, linestyle=style.DASH, label="Every force on time")
    axes.plot(late, cost.limits, color=c.ink, linewidth=3, label="Mean square dies out below, theory")
    axes.plot(
        late, cost.measured, "o", markersize=8, color=c.position, markerfacecolor=c.plot, markeredgewidth=2,
        zorder=5, clip_on=False, label="Measured, 300 motions a point",
    )  # fmt: skip
    axes.plot(
        [here], [limit], "o", markersize=15, color=c.accent, clip_on=False, zorder=4, label="This recording"
    )
    axes.annotate(
        "", (here, limit), (here, steady), zorder=3,
        arrowprops={"arrowstyle": "-|>", "color": c.accent, "linewidth": 2.2, "mutation_scale": 18},
    )  # fmt: skip
    style.legend(axes, c)
    figure.draw_without_rendering()
    words = f"costs {cost.words.split(':')[0]}"
    style.write_labels(axes, c, [style.Label(here, limit, words, c.accent, bold=True)])
