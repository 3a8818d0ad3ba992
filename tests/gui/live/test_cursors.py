"""Cursors snap to samples and follow the mouse; their values agree with the signal's formula."""

import math

import numpy as np
import pytest
from PySide6.QtCore import QCoreApplication, QPoint, Qt

from hapkit_studio.analysis.oscillation import Oscillation
from hapkit_studio.gui.live.cursors import CursorCard
from hapkit_studio.gui.live.phase_plot import ForcePosition
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import telemetry

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def card(qtbot, plots):
    card = CursorCard(plots.cursors)
    qtbot.addWidget(card)
    return card


def shown(card):
    card.refresh()
    head, *rows = card.table.texts()
    return {row[0]: dict(zip(head[1:], row[1:], strict=True)) for row in rows}


def test_new_cursors_are_on_samples_in_the_time_window(plots):
    plots.cursors.show(True)
    a, b = plots.cursors.times
    assert plots.view.zero - plots.view.span < a < b < plots.view.zero
    assert a * 1000.0 == pytest.approx(round(a * 1000.0), abs=1e-6)  # one sample per millisecond


def test_a_dragged_cursor_snaps_to_a_sample(plots, qtbot):
    plots.cursors.show(True)
    plots.refresh()
    canvas = plots.canvases[1]
    canvas.measure()
    x = round(canvas.pixel(plots.shown.cursors[0], 0.0).x())
    view = canvas.viewport()
    qtbot.mousePress(view, LEFT, pos=QPoint(x, 30))
    qtbot.mouseMove(view, QPoint(x + 60, 30))
    qtbot.mouseRelease(view, LEFT, pos=QPoint(x + 60, 30))
    wanted = plots.shown.zero + canvas.to_x(x + 60)
    assert 0.0 < wanted - plots.cursors.times[0] <= 0.001 + 1e-9
    before = plots.cursors.times
    qtbot.mousePress(view, LEFT, pos=QPoint(x + 200, 30))  # the mouse is far from both cursors
    qtbot.mouseMove(view, QPoint(x + 100, 30))
    qtbot.mouseRelease(view, LEFT, pos=QPoint(x + 100, 30))
    assert plots.cursors.times == before


def test_the_table_shows_the_values_at_both_cursors_and_their_difference(plots, card):
    plots.cursors.show(True)
    plots.cursors.move(0, 10.5005)
    plots.cursors.move(1, 11.0005)
    row = shown(card)["x, mm"]
    at = [15.0 * math.sin(3.0 * t) for t in (10.5, 11.0)]
    minus = str.maketrans("−+", "- ")
    values = [float(row[key].translate(minus)) for key in ("A", "B", "B − A")]
    assert values == pytest.approx([*at, at[1] - at[0]], abs=0.006)
    assert shown(card)["t, s"]["B − A"] == "+0.500"
    assert card.period.text() == "1/Δt  2 Hz"


def test_the_slope_in_the_wall_is_its_stiffness_and_the_range_shows_extremes(plots, card):
    # the handle is in the wall from 12.68 to 13.49 s; at the beginning of this interval, no force is clamped
    plots.cursors.show(True)
    plots.cursors.move(0, 12.7005)
    plots.cursors.move(1, 12.8005)
    card.refresh()
    slope, _, half, _ = card.slope.text().replace("−", "-").split()
    assert float(slope) == pytest.approx(-400.0, abs=0.1)
    assert float(half) == 0.1  # this is the smallest interval that is shown
    lines = []
    card.fitted.connect(lines.append)
    plots.cursors.move(1, 12.8105)
    card.refresh()
    assert lines[-1].y == pytest.approx(-400.0 * (lines[-1].x - 0.005), abs=1e-6)
    card.switch.button(2).click()
    span = np.sin(3.0 * np.arange(12_700, 12_811) / 1000.0) * 15.0
    assert shown(card)["x, mm"]["maximum"] == f"{span.max():.2f}"
    assert shown(card)["x, mm"]["minimum"] == f"{span.min():.2f}"


def test_in_a_low_card_either_the_plot_or_the_table_is_shown(qtbot, plots):
    """A window of 1280 × 720 with a banner leaves 296 px for the card, too little for plot and table."""
    phase = ForcePosition(plots.cursors)
    qtbot.addWidget(phase)
    phase.show()
    plots.cursors.show(True)
    plots.cursors.move(0, 10.5005)
    plots.cursors.move(1, 11.0005)
    phase.cursors.refresh()

    def seen(height, *chosen):
        phase.resize(320, height)
        for index in chosen:
            phase.cursors.switch.button(index).click()
        QCoreApplication.processEvents()
        return phase.canvas.isVisible(), phase.cursors.table.isVisible()

    assert seen(296) == (True, False)
    assert phase.canvas.measure().height() > 120
    assert seen(296, 1) == (False, True)
    assert seen(520) == (True, True)
    assert phase.canvas.measure().height() > 120
    assert seen(520, 0) == (True, False)
    x = [15.0 * math.sin(3.0 * t) for t in (10.5, 11.0)]
    text = f"A {x[0]:.2f}   B {x[1]:.2f}   B − A {x[1] - x[0]:+.2f}".replace("-", "−")
    plots.show_oscillation(Oscillation(1.2e-3, 31.0))
    assert plots.headers[0].remark.text() == text
    plots.cursors.show(False)
    assert plots.headers[0].remark.text() == ""


def test_cursors_stay_on_their_samples_with_new_data_and_while_paused(plots, history):
    plots.cursors.show(True)
    before = plots.cursors.times
    plots.view.set_paused(True)
    history.append(telemetry(3000, start=14_000))
    plots.refresh()
    plots.view.set_paused(False)
    plots.refresh()
    assert plots.cursors.times == before
    assert plots.shown.cursors[0] + plots.shown.zero == pytest.approx(before[0])


def test_cursors_disappear_with_their_samples(plots, card, history):
    plots.cursors.show(True)
    history.append(telemetry(60_000, start=14_000))
    card.refresh()
    assert not plots.cursors.on
    assert card.isHidden()


def read(plots, card, first, last):
    """Move the cursors to two times in s; return the slope as text."""
    plots.cursors.show(True)
    plots.cursors.move(0, first)
    plots.cursors.move(1, last)
    card.refresh()
    return card.slope.text()


def test_only_samples_with_an_unclamped_force_count_for_the_slope(plots, card, history):
    """The handle oscillates by 15 mm around 0, and a wall of 400 N/m is at 5 mm.

    The force reaches the clamp of 3 N at a depth of 7.5 mm.
    """
    assert read(plots, card, 8.0, 13.0) == "−400.0 ± 0.1 N/m"
    slope, *_ = np.polyfit(*(history.between(8.0, 13.0).y[name] for name in ("position", "applied_force")), 1)
    assert slope > -120.0  # slope of a line through all samples


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        (7.9, "−400.0"),
        (8.04, "no slope: settings changed"),
        (12.9, "no slope: settings changed"),
        (13.1, "−400.0"),
    ],
)
def test_there_is_no_slope_across_a_change_of_settings_or_its_fading(plots, card, history, changed, text):
    history.changes.append(changed)
    assert read(plots, card, 8.05, 13.0).startswith(text)


@pytest.mark.parametrize(("bend", "straight"), [(0.54, True), (0.556, False)])
def test_a_residual_above_a_twentieth_of_the_force_is_no_line(plots, card, history, bend, straight):
    """The force is F = −(z + c z²) N, where c is ``bend``, and z goes from 0 to 1 over 10 mm.

    The RMS of F is √(1/3 + c/2 + c²/5); the residual of the best line has an RMS of c/√180.
    """
    z = np.linspace(0.0, 1.0, 2001)
    assert (bend / math.sqrt(180.0) < 0.05 * math.sqrt(1 / 3 + bend / 2 + bend**2 / 5)) == straight
    rest = telemetry(2001, start=14_000)
    rest[:, rows.POSITION] = 0.01 * z
    rest[:, rows.FORCE] = rest[:, rows.APPLIED_FORCE] = -(z + bend * z**2)
    history.append(rest)
    assert (read(plots, card, 14.0005, 16.0005) == "no slope: not a straight line") != straight


def test_without_an_applied_force_there_is_no_slope(plots, card, history):
    free = telemetry(1000, start=14_000)
    free[:, rows.APPLIED_FORCE] = 0.0  # the motor is stopped: a force is requested, but not applied
    history.append(free)
    assert read(plots, card, 14.0005, 14.9) == "no slope: no force there"
    still = telemetry(1000, start=15_000)
    still[:, rows.POSITION], still[:, rows.FORCE], still[:, rows.APPLIED_FORCE] = 0.010, -2.0, -2.0
    history.append(still)
    assert read(plots, card, 15.0005, 15.9) == "no slope: too little motion"
