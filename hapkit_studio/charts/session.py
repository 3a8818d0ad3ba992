"""Overview of a session: position over the whole time, and its markers."""

from typing import Any

from hapkit_studio.charts.style import Colors, style_axes


def draw(figure: Any, c: Colors, trace: Any, markers: tuple[tuple[float, str], ...]) -> None:
    """Draw the positions as a band, and a line per marker.

    ``trace`` (3, n) of an Overview contains times, minima and maxima.
    """
    axes = figure.add_subplot()
    time, least, greatest = trace
    axes.fill_between(time, 1e3 * least, 1e3 * greatest, step="post", color=c.position, linewidth=1.5)
    axes.vlines(
        [when for when, _ in markers], 0.0, 1.0, transform=axes.get_xaxis_transform(), color=c.ink2,
        linewidth=1.2, linestyles=[(0.0, (3.0, 2.0))],
    )  # fmt: skip
    style_axes(axes, c, "time, s", "position, mm")
    axes.margins(x=0.0)
