"""The energy given to the hand: its plot with gaps where the sum restarts, its alarm, and a switch."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint
from PySide6.QtGui import QFontMetricsF

from hapkit_studio.gui.live import energy
from hapkit_studio.gui.live.energy import EnergyWatch
from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.live.plots.declared import phase_plots
from hapkit_studio.gui.shell.status_bar import StatusBar
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets import strokes
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import LIBRARY, RATE, colored, telemetry
from tests.gui.window_support import PATIENCE_MS, SIMULATED

ENERGY = len(phase_plots())


def with_energies(count, first=0, lost=1):
    """Return rows whose energy oscillates between 0 and −4 mJ and restarts at 12 s; its limit is 1 mJ."""
    table = telemetry(count, first)
    tick = table[:, rows.TICK]
    table[:, rows.ENERGY_GIVEN] = -2e-3 * (1.0 - np.cos(tick / RATE))
    table[:, rows.ENERGY_LIMIT] = 1e-3
    restarted = (tick >= 12_000) & (tick < 12_000 + lost)
    table[restarted, rows.ENERGY_GIVEN] = table[restarted, rows.ENERGY_LIMIT] = np.nan
    return table


@pytest.fixture
def shown(phase):
    """Return the card with 14 s of energy."""
    history = LiveHistory(seconds=60.0, rate=RATE)
    history.append(with_energies(14_000, lost=150))  # the gap is at least 3 px wide
    phase.view.set_history(history)
    phase.choose(ENERGY)
    phase.refresh()
    phase.refresh()
    return phase


@pytest.mark.parametrize("width", [0.0005, 0.03, 0.5])
def test_the_history_shows_a_gap_where_the_energy_restarts(width):
    """At every width, exactly one column is missing, namely where the sum restarts."""
    history, want = LiveHistory(seconds=60.0, rate=RATE), with_energies(14_000)
    history.append(want)
    assert history.latest()["energy_given"] == want[-1, rows.ENERGY_GIVEN]
    assert history.at(5.0)["energy_limit"] == 1e-3
    window = history.window(np.arange(4.0, 13.9, width))
    gone = np.isnan(window.y["energy_given"])
    assert 1 <= gone.sum() <= 2
    np.testing.assert_allclose(window.x[gone], 12.0, atol=width)
    assert np.isfinite(window.y["position"]).all()
    steepest = 2e-3 * width
    exact = -2e-3 * (1.0 - np.cos(window.x[~gone]))
    np.testing.assert_allclose(window.y["energy_given"][~gone], exact, atol=steepest)


def test_the_curve_is_drawn_at_its_values_with_a_gap(shown):
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
    gap = np.abs((found[:, 0] - left) - (12.075 - now) * across) < 1.0
    assert not gap.any()
    assert len(colored(image, "danger")) > 20


def test_energy_stays_selected_for_another_environment_and_force_can_be_selected_again(shown):
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
    """An engine with an excess energy; amounts below 0.2 mJ are not significant."""

    def __init__(self, joules):
        self.excess = joules, 0.2e-3


class Alarm:
    """An energy watch with its studio, on a clock that the test sets."""

    def __init__(self, qtbot, monkeypatch):
        self.now, self.calm = 100.0, False
        monkeypatch.setattr(energy.time, "monotonic", lambda: self.now)
        self.studio, self.status = Studio(list), StatusBar()
        qtbot.addWidget(self.status)
        self.watch = EnergyWatch(self.studio, Live(self.studio), lambda: self.calm, self.status.show_energy)
        self.status.energy.link.clicked.connect(lambda: self.studio.set_loop(controller=True))

    def strike(self, *joules):
        """Feed the watch with these excess energies in J, one per frame."""
        for excess in joules:
            self.studio.device.engine = Excess(excess)
            self.watch.on_row(None, False)
        self.studio.device.engine = None

    @property
    def shown(self):
        """Return the message and its token; None without a message."""
        field = self.status.energy
        return None if field.isHidden() else (field.label.text(), field.sign.token)


@pytest.fixture
def alarm(qtbot, monkeypatch):
    made = Alarm(qtbot, monkeypatch)
    made.strike(0.0)
    return made


GAVE = "The scene gave you 0.80 mJ of extra energy"


@pytest.mark.parametrize(("excess", "says"), [(0.198e-3, False), (0.202e-3, True)])
def test_an_insignificant_excess_shows_no_message(alarm, excess, says):
    alarm.strike(excess)
    assert (alarm.shown is not None) == says


def test_the_alarm_states_the_energy_and_a_remedy(alarm):
    alarm.strike(0.8e-3)
    assert alarm.shown == (GAVE, "warn")
    assert alarm.status.energy.toolTip() == "Lower the stiffness, or switch on the passivity controller."
    alarm.status.energy.link.click()
    assert alarm.studio.loop.controller
    assert alarm.shown is None


def test_a_stable_scene_raises_no_alarm(alarm):
    alarm.calm = True
    alarm.strike(0.8e-3)
    assert alarm.shown is None


def test_the_message_stays_for_a_while_after_the_last_excess(alarm):
    alarm.strike(0.8e-3, 1.1e-3)
    assert alarm.shown == (GAVE, "warn")
    alarm.strike(8e-3)
    assert alarm.shown[0] == "The scene gave you 8.0 mJ of extra energy"
    for share, there in ((0.99, True), (0.02, False)):
        alarm.now += share * energy.SHOWN_S
        alarm.strike(8e-3)
        alarm.watch.refresh()
        assert (alarm.shown is not None) == there
    alarm.strike(8.8e-3)
    assert alarm.shown == (GAVE, "warn"), "what the next bounce gives, not both"


def test_an_excess_before_a_change_is_not_reported_again(alarm):
    alarm.strike(8e-3)
    alarm.studio.set_loop(delay=1e-3)
    alarm.strike(8e-3)
    assert alarm.shown is None


def test_no_alarm_while_the_controller_dissipates_the_excess(alarm):
    alarm.studio.set_loop(controller=True)
    alarm.strike(0.0, 0.59e-3)
    assert alarm.shown is None
    alarm.studio.choose("cat")  # the cat moves the handle by itself
    alarm.strike(0.0, 5e-3)
    assert alarm.shown is None
    alarm.studio.choose("wall")
    alarm.strike(0.0, 2e-3)
    assert alarm.shown[1] == "warn"
    assert alarm.status.energy.toolTip().startswith(
        "The passivity controller already damps as much as it can."
    )
    assert alarm.status.energy.link.isHidden()


@pytest.mark.slow
def test_a_scene_that_moves_the_handle_says_so_instead(reset_window):
    label = reset_window.stability.drives
    reset_window.studio.choose("cat")
    assert label.text() == "The purr and the paw move the handle by themselves."
    assert label.isVisibleTo(reset_window)
    reset_window.studio.choose("wall")
    assert not label.isVisibleTo(reset_window)


# --- the switch in the running window


@pytest.mark.slow
def test_a_buzzing_spring_raises_the_alarm_and_the_controller_calms_it(reset_window, qtbot):
    window, studio = reset_window, reset_window.studio
    studio.choose("spring")
    studio.set_value("stiffness", 1900.0)
    studio.set_loop(delay=1e-3)

    def swing():
        window.live.tick()
        return np.ptp(window.live.history.between(window.live.history.now - 0.3, np.inf).y["position"])

    place = window.centre.scene.mapTo(window, QPoint())
    # at 50 mm, the hand's force exceeds the motor's limit; a smaller force could be held by friction
    studio.move_hand(0.05)
    qtbot.waitUntil(
        lambda: swing() > 0 and window.live.history.latest()["position"] > 5e-3, timeout=PATIENCE_MS
    )
    studio.move_hand(None)
    field = window.status.energy
    qtbot.waitUntil(lambda: swing() > 5e-3 and field.link.isVisible(), timeout=PATIENCE_MS)
    assert window.centre.scene.mapTo(window, QPoint()) == place, "the scene stays under the pointer"
    field.link.click()
    qtbot.waitUntil(lambda: swing() < 1e-3, timeout=PATIENCE_MS)
    assert studio.engine.excess[0] < 3.0 * studio.engine.excess[1]
    studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: studio.engine is not None, timeout=PATIENCE_MS)
    assert window.loop.controller.isChecked()
    assert studio.engine.loop.controller


def test_a_dense_line_is_drawn_solid():
    """A dash-dot line that oscillates often within a few pixels would look like a scribble."""
    x = np.linspace(0.0, 200.0, 401)
    calm, wild = np.zeros(401), 40.0 * np.sin(2.0 * np.pi * x / 10.0)
    dash = (9.0, 4.0, 2.0, 4.0)
    drawn = strokes.patterned(x, calm, dash)
    assert np.ptp(drawn[:, (0, 2)], axis=1).sum() == pytest.approx(200.0 * 11.0 / 19.0, rel=0.05)
    whole = strokes.patterned(x, wild, dash)
    np.testing.assert_array_equal(whole, strokes.joined(x, wild))


def test_the_energy_has_its_unit(shown):
    header, canvas = shown.beside[0].headers[0], shown.beside[0].canvases[0]
    for joules, message in ((0.0123456, "+12.3 mJ"), (float("nan"), "– mJ")):
        header.show_value(joules)
        assert header.value.text() == message
    assert canvas.left.tickStrings([-1.0, 0.0, 1.0], 1.0, 1.0) == ["−1", "0", "1 mJ"]
    text = QFontMetricsF(theme.font("tick")).horizontalAdvance("1,000 mJ")
    assert text <= canvas.left.width()
