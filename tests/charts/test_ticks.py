"""Numbers on the axes of charts have the format of numbers in texts and in the plots of the window."""

import pytest
from matplotlib.figure import Figure

from hapkit_studio.charts import style


def tick_texts(scale, low, high):
    """Return the texts of the major and minor ticks of an axis."""
    axes = Figure().add_subplot(xscale=scale, xlim=(low, high))
    style.style_axes(axes, style.colors(), "", "")
    axes.figure.draw_without_rendering()
    ticks = axes.xaxis.get_ticklabels(), axes.xaxis.get_ticklabels(minor=True)
    return [{text.get_text() for text in texts} for texts in ticks]


@pytest.mark.parametrize(
    ("scale", "low", "high", "expected"),
    [
        ("linear", 0.0, 10_000.0, {"0", "2,000", "10,000"}),
        ("linear", -1.0, 1.0, {"−1.00", "−0.75", "0.00", "0.50"}),
        ("log", 1e-6, 1e4, {"10⁻⁶", "0.01", "1", "100", "10,000"}),
        ("log", 1.0, 1e7, {"1", "1,000", "10⁶"}),
    ],
)
def test_ticks_have_commas_a_true_minus_and_no_power_of_ten_near_1(scale, low, high, expected):
    major, _ = tick_texts(scale, low, high)
    assert expected <= major


def test_the_minor_ticks_of_a_short_logarithmic_axis_are_plain_numbers():
    _, minor = tick_texts("log", 550.0, 900.0)
    assert {"600", "700", "800"} <= minor
