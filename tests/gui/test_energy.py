"""Energy to the hand: its plot, breaks where the sum begins anew, the alarm in words, the switch."""

import numpy as np
import pytest
from PySide6.QtGui import QFontMetricsF

from hapkit_studio.gui import notices
from hapkit_studio.gui.banners import BannerStack
from hapkit_studio.gui.live import strokes
from hapkit_studio.gui.live.history import History
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.live.plots.declared import phase_plots
from hapkit_studio.gui.notices import Passivity
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import LIBRARY, RATE, colored, telemetry
from tests.gui.window_support import PATIENCE_MS, SIMULATED

ENERGY = len(phase_plots())


def energies(count, first=0):
    """Return energies that swing to -4 mJ below a limit of 1 mJ, begun anew for a tick at 12 s."""
    tick = first + np.arange(count)
    table = np.column_stack([-2e-3 * (1.0 - np.cos(tick / RATE)), np.full(count, 1e-3)])
    table[tick == 12_000] = np.nan
    return table


@pytest.fixture
def shown(phase):
    """Return the card with the energy of 14 s in it."""
    history = History(seconds=60.0, rate=RATE)
    history.append(telemetry(14_000), energies(14_000))
    phase.set_history(history)
    phase.choose(ENERGY)
    phase.refresh()
    phase.refresh()
    return phase


@pytest.mark.parametrize("width", [0.0005, 0.03, 0.5])
def test_the_history_keeps_energies_and_where_they_begin_anew(width):
    """However coarse the columns are, one of them is missing where the sum begins anew, and only there."""
    history, want = History(seconds=60.0, rate=RATE), energies(14_000)
    history.append(telemetry(14_000), want)
    assert history.last("energy") == want[-1, 0]
    assert history.at(5.0)["energy_limit"] == 1e-3
    window = history.window(np.arange(4.0, 13.9, width))
    gone = np.isnan(window.y["energy"])
    assert 1 <= gone.sum() <= 2
    np.testing.assert_allclose(window.x[gone], 12.0, atol=width)
    assert np.isfinite(window.y["position"]).all()
    steepest = 2e-3 * width
    exact = -2e-3 * (1.0 - np.cos(window.x[~gone]))
    np.testing.assert_allclose(window.y["energy"][~gone], exact, atol=steepest)


def test_the_curve_stands_at_its_value_and_breaks(shown):
    canvas = shown.beside[0].canvases[0]
    image = canvas.viewport().grab().toImage()
    found = colored(image, "energy")
    assert len(found) > 200
    canvas.measure()
    left, across, bottom, up = canvas._map
    time, value = (found[:, 0] + 0.5 - left) / across, (found[:, 1] + 0.5 - bottom) / up
    now = canvas.shown.zero
    want = 1e3 * np.interp(
        time + now, np.arange(14_000) / RATE, -2e-3 * (1.0 - np.cos(np.arange(14_000) / RATE))
    )
    near = np.abs(time) * across > 12.0
    assert np.abs(value - want)[near].max() < 4.0 / abs(up) + 2.0 * 2.0 / across
    gap = np.abs((found[:, 0] - left) - (12.0 - now) * across) < 1.0
    assert not gap.any()
    assert len(colored(image, "danger")) > 20


def test_energy_stays_over_a_change_of_environment_and_force_comes_back(shown):
    pane = shown.beside[0]
    assert pane.isVisible()
    assert not shown.title.isVisible()
    shown.set_environment(LIBRARY["damping"], LIBRARY["damping"].values(), 3.0)
    assert shown.switch.index == ENERGY
    assert pane.isVisible()
    shown.choose(0)
    assert shown.canvas.isVisible()
    assert not pane.isVisible()
    assert shown.title.isVisible()


# --- the alarm


class Excess:
    """An engine that only knows an excess of energy."""

    def __init__(self, joules):
        self.excess = joules, 0.2e-3


def active(on=True):
    row = np.zeros(rows.ROW_WIDTH)
    row[rows.FLAGS] = rows.ACTIVE if on else 0
    return row


@pytest.fixture
def clock(monkeypatch):
    """Return what the alarm takes for the time, to be set."""
    now = [100.0]
    monkeypatch.setattr(notices.time, "monotonic", lambda: now[0])
    return now


@pytest.fixture
def alarm(qtbot, clock):
    """Return an alarm of its own, with studio and banners."""
    studio, banners = Studio(list), BannerStack()
    qtbot.addWidget(banners)
    return Passivity(studio, Live(studio), banners), studio, banners


def strike(alarm, joules):
    """Raise the alarm with an excess."""
    watch, studio, _ = alarm
    studio.device.engine = Excess(joules)
    watch.on_row(active(), False)
    studio.device.engine = None


def test_the_alarm_says_how_much_and_what_to_do(alarm):
    _, studio, banners = alarm
    strike(alarm, 0.8e-3)
    notice = banners.get("energy")
    assert notice.title == "Gives energy: 0.80 mJ more than it took."
    assert notice.text == "Lower stiffness, or switch on the passivity controller."
    assert notice.tone == "warn"
    notice.buttons[0][1]()
    assert studio.loop.controller
    assert banners.get("energy") is None


def test_the_alarm_stands_still_and_long_enough_to_be_read(alarm, clock):
    watch, _, banners = alarm
    strike(alarm, 0.8e-3)
    first = banners.get("energy")
    strike(alarm, 1.1e-3)
    assert banners.get("energy") is first
    strike(alarm, 8e-3)
    assert banners.get("energy").title == "Gives energy: 8.0 mJ more than it took."
    watch.on_row(active(False), False)
    clock[0] += 0.99 * notices.HOLD_S
    watch.look()
    assert banners.get("energy") is not None
    clock[0] += 0.02 * notices.HOLD_S
    watch.look()
    assert banners.get("energy") is None


def test_no_alarm_while_the_controller_copes(alarm):
    _, studio, banners = alarm
    studio.set_loop(controller=True)
    strike(alarm, 0.5e-3)
    assert banners.get("energy") is None
    studio.choose("cat")  # a scene that drives
    strike(alarm, 5e-3)
    assert banners.get("energy") is None
    studio.choose("wall")
    strike(alarm, 2e-3)
    notice = banners.get("energy")
    assert notice.text == "The passivity controller damps as much as it may. Lower stiffness."
    assert not notice.buttons


def test_a_scene_that_drives_says_so_instead(idle_window):
    words = idle_window.stability.drives
    idle_window.studio.choose("cat")
    assert words.text() == "The purr and the paw give energy by themselves."
    assert words.isVisibleTo(idle_window)
    idle_window.studio.choose("wall")
    assert not words.isVisibleTo(idle_window)


# --- the switch, live


def test_the_switch_goes_through_to_the_loop_and_over_a_change_of_device(window, qtbot):
    box = window.loop.controller
    assert not box.isChecked()
    box.click()
    assert window.studio.loop.controller
    assert window.studio.engine.loop.controller
    window.studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    assert window.studio.engine.loop.controller
    assert box.isChecked()


def test_a_buzzing_spring_alarms_and_the_controller_calms_it(window, qtbot):
    studio = window.studio
    studio.choose("spring")
    studio.set_value("stiffness", 1900.0)
    studio.set_loop(delay=1e-3)

    def swing():
        window.live.tick()
        return np.ptp(window.live.history.between(window.live.history.now - 0.3, np.inf).y["position"])

    studio.move_hand(0.015)
    qtbot.waitUntil(lambda: swing() > 1e-3, timeout=PATIENCE_MS)
    studio.move_hand(None)
    qtbot.waitUntil(lambda: swing() > 5e-3 and window.banners.get("energy") is not None, timeout=PATIENCE_MS)
    window.banners.get("energy").buttons[0][1]()
    qtbot.waitUntil(lambda: swing() < 1e-3, timeout=PATIENCE_MS)
    assert studio.engine.excess[0] < 3.0 * studio.engine.excess[1]


def test_a_dense_line_is_drawn_whole():
    """A dash-dot line that swings often over few pixels would be a scribble."""
    x = np.linspace(0.0, 200.0, 401)
    calm, wild = np.zeros(401), 40.0 * np.sin(2.0 * np.pi * x / 10.0)
    dash = (9.0, 4.0, 2.0, 4.0)
    drawn = strokes.patterned(x, calm, dash)
    assert np.ptp(drawn[:, (0, 2)], axis=1).sum() == pytest.approx(200.0 * 11.0 / 19.0, rel=0.05)
    whole = strokes.patterned(x, wild, dash)
    np.testing.assert_array_equal(whole, strokes.joined(x, wild))


def test_the_energy_has_its_unit(shown):
    header, canvas = shown.beside[0].headers[0], shown.beside[0].canvases[0]
    for joules, words in ((0.0123456, "+12.3 mJ"), (float("nan"), "– mJ")):
        header.show_value(joules)
        assert header.value.text() == words
    assert canvas.left.tickStrings([-1.0, 0.0, 1.0], 1.0, 1.0) == ["−1", "0", "1 mJ"]
    text = QFontMetricsF(theme.font("tick")).horizontalAdvance("1,000 mJ")
    assert text <= canvas.left.width()
