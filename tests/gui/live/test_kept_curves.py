"""All plots show kept curves, several at once; curves are named after settings, hidden and removed."""

import numpy as np
import pytest
from PySide6.QtCore import Qt

from hapkit_studio.gui.live.kept_curves import LINE_STYLES, KeptCurveList, KeptCurves, settings_name
from tests.gui.live.plot_support import LIBRARY, canvas_of, colored, telemetry


@pytest.fixture
def kept(plots, phase):
    kept = KeptCurves()
    for shown in (plots, phase.canvas):
        kept.changed.connect(shown.set_kept_curves)
    return kept


@pytest.mark.parametrize("zero", [None, 11.0])
def test_a_kept_curve_keeps_its_position_while_time_passes(plots, kept, history, zero):
    """A curve kept around an event is shifted to the left; otherwise most of it would be outside the plot."""
    curve = kept.keep(history, (4.0, history.now), "Wall", zero=zero)
    # the tolerance is less than a thousandth of the 10 s shown
    assert curve.time[-1] == pytest.approx(14.0 - (zero or 14.0), abs=0.005)
    assert curve.values["position"][-1] == pytest.approx(history.latest()["position"], abs=0.005 * 0.045)
    history.append(telemetry(4000, start=14_000))
    plots.refresh()
    canvas = canvas_of(plots, "position")
    picture = canvas.grab().toImage()
    canvas.measure()
    # the curve was kept at 14 s
    expected = canvas.pixel(-2.0, 1e3 * 0.015 * np.sin(3.0 * 12.0))
    ratio = picture.devicePixelRatio()
    pixels = colored(picture, "hold") / ratio
    assert np.min(np.hypot(*(pixels - [expected.x(), expected.y()]).T)) < 5.0


def test_a_shifted_curve_is_also_in_the_force_plot(kept, history, phase):
    curve = kept.keep(history, (11.0, 12.0), "on the computer", 1.5)
    assert curve.time[[0, -1]] == pytest.approx([12.5, 13.5], abs=2e-3)
    assert curve.values["position"] == pytest.approx(0.015 * np.sin(3.0 * (curve.time - 1.5)), abs=1e-4)
    history.end_environment()  # otherwise the live curve would cover the kept curve
    for seen in (True, False):
        phase.refresh()
        assert bool(len(colored(phase.canvas.viewport().grab().toImage(), "hold"))) == seen
        kept.drop(curve)
    kept.drop(curve)


def test_curves_have_distinct_styles_and_the_oldest_is_replaced(kept, history):
    for number in range(len(LINE_STYLES) + 1):
        kept.keep(history, (9.0, 14.0), f"Number {number}")
    assert sorted(t.name for t in kept.curves.values()) == [
        f"Number {n}" for n in range(1, len(LINE_STYLES) + 1)
    ]
    assert len({t.style for t in kept.curves.values()}) == len(LINE_STYLES)


def test_a_curve_is_hidden_and_removed_in_the_list(kept, history, plots, qtbot):
    listed = KeptCurveList(kept)
    qtbot.addWidget(listed)
    kept.keep(history, (9.0, 14.0), "One")
    kept.keep(history, (9.0, 14.0), "Two")
    assert [row.box.text() for row in listed.rows.values()] == ["One", "Two"]
    listed.rows[0].box.setChecked(False)
    assert [curve.name for curve in plots.shown.kept_curves] == ["Two"]
    listed.rows[0].box.setChecked(True)
    qtbot.mouseClick(listed.rows[1].away, Qt.MouseButton.LeftButton)
    assert [curve.name for curve in plots.shown.kept_curves] == ["One"]
    kept.remove(0)
    assert listed.isHidden()


def test_a_curve_is_named_by_its_settings():
    wall = LIBRARY["wall"]
    assert settings_name(wall, wall.values()) == "Wall, k 250 N/m"
    assert settings_name(wall, wall.values({"damping": 2.0})) == "Wall, k 250 N/m, b 2 N·s/m"
    both = wall.values({"damping_mode": 1.0})
    assert settings_name(wall, both) == "Wall, k 250 N/m, Damping acts both ways"
    assert settings_name(LIBRARY["free"], {}) == "Free"


def test_curves_of_the_same_settings_are_numbered(kept, history):
    for _ in range(3):
        kept.keep(history, (0.0, 1.0), "Wall")
    kept.remove(1)
    kept.keep(history, (0.0, 1.0), "Wall")
    assert sorted(curve.name for curve in kept.curves.values()) == ["Wall", "Wall (2)", "Wall (3)"]


def test_without_data_nothing_is_kept(kept, history):
    history.clear()
    assert not kept.keep(history, (9.0, 14.0), "One")
    assert kept.curves == {}


def test_a_curve_is_kept_as_felt_with_the_delay_of_its_loop(kept, history, phase):
    """Each force is drawn over the positions at which it acted.

    It acts for one sample period, and begins one loop delay after its sample.
    """
    kept.delay = 5e-3
    curve = kept.keep(history, (11.0, 13.0), "late")
    places, force = curve.felt
    samples = history.between(11.0, 13.0)
    assert force[2000:2010:2] == pytest.approx(samples.y["applied_force"][1000:1005])
    assert places[2000:2010:2] == pytest.approx(0.015 * np.sin(3.0 * (samples.x[1000:1005] + 5e-3)), abs=1e-7)
    assert places[2001:2010:2] == pytest.approx(places[2002:2011:2])
    kept.delay = None
    assert kept.keep(history, (11.0, 13.0), "unknown").felt is None
