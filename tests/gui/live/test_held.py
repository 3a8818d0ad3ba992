"""All plots show held traces, several at once; traces are named after settings, hidden and removed."""

import numpy as np
import pytest
from PySide6.QtCore import Qt

from hapkit_studio.gui.live.held import LINE_STYLES, HeldList, HeldTraces, settings_name
from tests.gui.live.plot_support import LIBRARY, canvas_of, colored, telemetry


@pytest.fixture
def held(plots, phase):
    held = HeldTraces()
    for shown in (plots, phase.canvas):
        held.changed.connect(shown.set_held)
    return held


@pytest.mark.parametrize("zero", [None, 11.0])
def test_a_held_trace_keeps_its_position_while_time_passes(plots, held, history, zero):
    """A trace held around an event is shifted to the left; otherwise most of it would be outside the plot."""
    trace = held.hold(history, (4.0, history.now), "Wall", zero=zero)
    # the tolerance is less than a thousandth of the 10 s shown
    assert trace.time[-1] == pytest.approx(14.0 - (zero or 14.0), abs=0.005)
    assert trace.values["position"][-1] == pytest.approx(history.latest()["position"], abs=0.005 * 0.045)
    history.append(telemetry(4000, start=14_000))
    plots.refresh()
    canvas = canvas_of(plots, "position")
    picture = canvas.grab().toImage()
    canvas.measure()
    # the trace was held at 14 s
    expected = canvas.pixel(-2.0, 1e3 * 0.015 * np.sin(3.0 * 12.0))
    ratio = picture.devicePixelRatio()
    pixels = colored(picture, "hold") / ratio
    assert np.min(np.hypot(*(pixels - [expected.x(), expected.y()]).T)) < 5.0


def test_a_shifted_trace_is_also_in_the_force_plot(held, history, phase):
    past = held.hold(history, (11.0, 12.0), "on the computer", 1.5)
    assert past.time[[0, -1]] == pytest.approx([12.5, 13.5], abs=2e-3)
    assert past.values["position"] == pytest.approx(0.015 * np.sin(3.0 * (past.time - 1.5)), abs=1e-4)
    history.end_environment()  # otherwise the live curve would cover the held trace
    for seen in (True, False):
        phase.refresh()
        assert bool(len(colored(phase.canvas.viewport().grab().toImage(), "hold"))) == seen
        held.drop(past)
    held.drop(past)


def test_traces_have_distinct_styles_and_the_oldest_is_replaced(held, history):
    for number in range(len(LINE_STYLES) + 1):
        held.hold(history, (9.0, 14.0), f"Number {number}")
    assert sorted(t.name for t in held.traces.values()) == [
        f"Number {n}" for n in range(1, len(LINE_STYLES) + 1)
    ]
    assert len({t.style for t in held.traces.values()}) == len(LINE_STYLES)


def test_a_trace_is_hidden_and_removed_in_the_list(held, history, plots, qtbot):
    listed = HeldList(held)
    qtbot.addWidget(listed)
    held.hold(history, (9.0, 14.0), "One")
    held.hold(history, (9.0, 14.0), "Two")
    assert [row.box.text() for row in listed.rows.values()] == ["One", "Two"]
    listed.rows[0].box.setChecked(False)
    assert [trace.name for trace in plots.shown.held] == ["Two"]
    listed.rows[0].box.setChecked(True)
    qtbot.mouseClick(listed.rows[1].away, Qt.MouseButton.LeftButton)
    assert [trace.name for trace in plots.shown.held] == ["One"]
    held.remove(0)
    assert listed.isHidden()


def test_a_trace_is_named_by_its_settings():
    wall = LIBRARY["wall"]
    assert settings_name(wall, wall.values()) == "Wall, k 250 N/m"
    assert settings_name(wall, wall.values({"damping": 2.0})) == "Wall, k 250 N/m, b 2 N·s/m"
    assert settings_name(LIBRARY["free"], {}) == "Free"


def test_traces_of_the_same_settings_are_numbered(held, history):
    for _ in range(3):
        held.hold(history, (0.0, 1.0), "Wall")
    held.remove(1)
    held.hold(history, (0.0, 1.0), "Wall")
    assert sorted(trace.name for trace in held.traces.values()) == ["Wall", "Wall (2)", "Wall (3)"]


def test_without_data_nothing_is_held(held, history):
    history.clear()
    assert not held.hold(history, (9.0, 14.0), "One")
    assert held.traces == {}


def test_a_trace_is_held_as_felt_with_the_delay_of_its_loop(held, history, phase):
    """Each force is drawn over the positions at which it acted.

    It acts for one sample period, and begins one loop delay after its sample.
    """
    held.delay = 5e-3
    past = held.hold(history, (11.0, 13.0), "late")
    places, force = past.felt
    samples = history.between(11.0, 13.0)
    assert force[2000:2010:2] == pytest.approx(samples.y["applied_force"][1000:1005])
    assert places[2000:2010:2] == pytest.approx(0.015 * np.sin(3.0 * (samples.x[1000:1005] + 5e-3)), abs=1e-7)
    assert places[2001:2010:2] == pytest.approx(places[2002:2011:2])
    held.delay = None
    assert held.hold(history, (11.0, 13.0), "unknown").felt is None
