"""From the ring to the window: the display equals the loop's rows; late reads and clamping are shown."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QFrame

from hapkit_studio.analysis.oscillation import Oscillation
from hapkit_studio.formatting import number
from hapkit_studio.gui.shell import status_bar
from hapkit_studio.gui.shell.status_bar import StatusBar, late
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.priority import Priority
from hapkit_studio.haptics.signals import COLUMN
from tests.gui.live.plot_support import telemetry
from tests.gui.window_support import PATIENCE_MS

LINK = SimpleNamespace(lost_frames=2, clock_jumps=0)


def health(**changes):
    given = {
        "rate": 999.96,
        "lateness_us": {"p50": 30.0, "p99": 90.0, "p99.9": 150.0, "max": 4000.0},
        "missed": 0,
        "link": SimpleNamespace(lost_frames=0, clock_jumps=0),
        "missed_lately": 0,
        "priority": Priority("Real-time priority (level 80 of 99)", True, ""),
    }
    return SimpleNamespace(**(given | changes))


@pytest.fixture
def window(reset_window):
    """Return a window with a running simulated device."""
    return reset_window


@pytest.fixture
def bar(qtbot):
    widget = StatusBar()
    qtbot.addWidget(widget)
    widget.resize(1440, 30)
    widget.show()
    return widget


def test_links_and_clamp_light_of_the_status_bar_do_not_move(bar, qapp):
    def places():
        qapp.processEvents()
        parts = bar.clamp, bar.energy.link, bar.record.link, bar.priority.link
        return [part.mapTo(bar, QPoint()).x() for part in parts]

    bar.show_energy("The scene gave you 0.41 mJ of extra energy", remedy=True)
    bar.show_record("Recording", written=True)
    bar.show_figures(True)
    found = []
    for lateness, missed, clamped, given, kept in (
        (80.0, 0, False, "0.41", "Last 9 s kept"),
        (12_340.0, 5000, True, "12", "Wall 12:10, 1.2 MB"),
        (630.0, 0, False, "4.1", "Last 10 min kept"),
    ):
        us = dict.fromkeys(("p50", "p99", "p99.9", "max"), lateness)
        normal = Priority("Normal priority")
        bar.show_health(health(lateness_us=us, missed_lately=missed, priority=normal), 1000.0)
        bar._clamped_until = 0.0
        bar.show_clamp(clamped, 3.0)
        bar.show_margin("Stable" if clamped else "Stable, 36 × below the limit", "check", "ok")
        bar.show_energy(f"The scene gave you {given} mJ of extra energy", remedy=True)
        bar.show_record(kept, written=True)
        found.append(places())
    assert found == found[:1] * 3


def test_the_history_equals_the_ring_and_a_hidden_window_only_drains_it(window, qtbot):
    reader = window.studio.engine.reader()
    window.live._follow()
    window.studio.engine.move_hand(0.015)
    seen = []

    def enough():
        window.live.tick()
        new = reader.read()
        if len(new):
            seen.append(new)
        return sum(map(len, seen)) > 400

    qtbot.waitUntil(enough, timeout=PATIENCE_MS)
    window.live.tick()
    ring = np.concatenate(seen)
    kept = window.live.history.between(ring[0, rows.HOST_TIME], ring[-1, rows.HOST_TIME])
    assert len(kept.x) > 300
    ring = ring[np.isin(ring[:, rows.HOST_TIME], kept.x)]
    assert np.array_equal(ring[:, rows.HOST_TIME], kept.x)
    for name, column in ((name, COLUMN[name]) for name in ("position", "velocity", "force", "applied_force")):
        assert np.array_equal(kept.y[name], ring[:, column])
    window.live.lost = 12
    window.record_display.show_state()
    assert window.status.record.label.text() == "12 samples were lost"
    frames = []
    window.live.frame.connect(lambda *_: frames.append(1))
    window.live.set_hidden(True)
    length = len(window.live.history)

    def drained():
        window.live.tick()
        return len(window.live.history) > length + 50

    qtbot.waitUntil(drained, timeout=PATIENCE_MS)
    assert frames == []
    window.live.set_hidden(False)


def test_release_here_releases_a_handle_that_is_being_dragged(window, qtbot):
    scene, button = window.centre.scene, window.centre.toolbar.release
    assert button.isVisible()
    qtbot.mousePress(scene, Qt.MouseButton.LeftButton, pos=QPoint(scene.width() // 3, 100))
    reader = window.studio.engine.reader()

    def target():
        return reader.read()[-1:, rows.HAND_TARGET]

    qtbot.waitUntil(lambda: np.isfinite(target()).any())
    for let_go in (lambda: qtbot.keyClick(scene, Qt.Key.Key_L), button.click):
        let_go()
        qtbot.waitUntil(lambda: np.isnan(target()).any())
        assert window.studio.engine._content.target is None
        with qtbot.assertNotEmitted(scene.hand_moved):
            qtbot.mouseMove(scene, QPoint(scene.width() // 4, 100))
        qtbot.mouseRelease(scene, Qt.MouseButton.LeftButton)
        qtbot.mousePress(scene, Qt.MouseButton.LeftButton, pos=QPoint(scene.width() // 3, 100))
        qtbot.waitUntil(lambda: np.isfinite(target()).any())
    qtbot.mouseRelease(scene, Qt.MouseButton.LeftButton)


def test_an_oscillation_is_shown_beside_the_position_while_it_lasts(window):
    remark, table = window.centre.time.headers[0].remark, telemetry(3000)
    table[1000:2000, rows.POSITION] = 1.2e-3 * np.sin(np.arange(1000) * 2e-3 * np.pi * 31.0)
    table[2000:, rows.POSITION] = 0.0
    for part, text in (
        (table[:1000], ""),
        (table[1000:2000], "oscillates by ±1.2 mm at 31 Hz"),
        (table[2000:], ""),
    ):
        window.live.history.append(part)
        window.display.show_health(window.studio.engine.health())
        assert remark.text() == remark.toolTip() == text


def test_the_oscillation_text_is_shortened_and_never_cut(plots):
    plots.show_oscillation(Oscillation(1.2e-3, 31.0))
    remark, seen = plots.headers[0].remark, []
    for wide in range(260, 0, -1):
        remark.resize(wide, 20)
        assert remark.fontMetrics().horizontalAdvance(remark.text()) <= wide
        seen += [remark.text()] if remark.text() not in seen else []
    assert seen == ["oscillates by ±1.2 mm at 31 Hz", "±1.2 mm, 31 Hz", "31 Hz", ""]
    remark.resize(260, 20)
    plots.show_oscillation(Oscillation(1.2e-3, math.nan))
    assert remark.text() == "oscillates by ±1.2 mm"


def test_while_paused_everything_shows_one_sample_except_the_force_in_the_status_bar(window, qtbot):
    live, studio, scene, bar = window.live, window.studio, window.centre.scene, window.status

    def pushed(force):
        live.tick()
        return live.last is not None and live.last[rows.APPLIED_FORCE] < -force

    studio.move_hand(0.012)
    qtbot.waitUntil(lambda: pushed(0.5))
    live.set_paused(True)
    row = live.last.copy()

    def shown_values():
        shown = {header.plot.key: header.value.text() for header in window.centre.time.headers}
        return (
            shown["position"],
            shown["velocity"],
            shown["force"],
            scene._motion.force_text,
            scene._motion.position_text,
            scene.accessibleDescription(),
        )

    standing, picture = shown_values(), scene.grab().toImage()
    assert standing[0] == f"{number(1e3 * row[rows.POSITION], 2, sign=True)} mm"
    assert standing[2] == standing[3] == f"{number(row[rows.APPLIED_FORCE], 2, sign=True)} N"
    assert standing[4] == pytest.approx(1e3 * row[rows.POSITION])
    studio.move_hand(0.0)
    studio.set_value("position", -0.02)

    def clamp_says_it():
        window.display.show_health(studio.engine.health())
        live.tick()
        text = bar.clamp.label.text()
        return re.fullmatch(r"Force −[2-3]\.\d N, limit 3\.0 N|Force cut to 3\.0 N", text) is not None

    qtbot.waitUntil(clamp_says_it)  # the force changes continuously, because the handle moves into the wall
    assert shown_values() == standing
    assert scene.grab().toImage() == picture
    studio.stop()
    assert window.banners.get("stop") is not None
    studio.release_stop()
    qtbot.mousePress(scene, Qt.MouseButton.LeftButton, pos=QPoint(scene.width() // 3, 100))
    qtbot.mouseRelease(scene, Qt.MouseButton.LeftButton)
    assert not live.paused
    assert scene._values["position"] == -0.02
    live.set_paused(True)
    studio.choose("spring")
    assert not live.paused


def test_the_divider_separates_the_forces_of_two_environments(window, qtbot):
    """Rows before the divider follow the wall's law.

    Rows after the change of environment follow the spring's law.
    """
    live, studio = window.live, window.studio
    qtbot.waitUntil(lambda: studio.engine.settled)
    live.tick()
    live.history.clear()
    studio.move_hand(0.012)

    def kept(start=-np.inf):
        live.tick()
        return live.history.between(start, np.inf)

    qtbot.waitUntil(lambda: len(kept().x) and kept().y["force"][-1] < -0.5)
    studio.choose("spring")
    ((time, text),) = live.history.dividers
    assert text == "Spring"
    # wait until the new environment is active
    qtbot.waitUntil(lambda: len(kept().x) and live.history.now > live.history.begin + 0.1)
    before, after = live.history.between(-np.inf, time + 1e-6), kept(live.history.begin)
    assert live.history.begin > time
    depth = np.maximum(before.y["position"] - 0.005, 0.0)
    assert before.y["force"] == pytest.approx(-250.0 * depth, abs=1e-9)
    stiffness, centre = (studio.values[key] for key in ("stiffness", "center"))
    assert after.y["force"] == pytest.approx(-stiffness * (after.y["position"] - centre), abs=1e-9)
    window.display.keep_curves()  # this trace is named after the spring, and has no sample of the wall
    ((place, curve),) = window.centre.kept_curves.curves.items()
    window.centre.kept_curves.remove(place)
    assert live.history.now + curve.time[0] == pytest.approx(live.history.begin, abs=2e-3)


def test_the_loop_state_opens_its_figures_also_with_enter(bar, qtbot):
    bar.show_health(health(), nominal=1000.0, compute=3.14e-6)
    link, figures = bar.loop.link, (bar.rate, bar.late, bar.missed, bar.priority)
    assert (link.text(), bar.loop.sign.name) == ("Loop on time", "check")
    assert not any(field.isVisible() for field in figures)
    link.setFocus()
    qtbot.keyClick(link, Qt.Key.Key_Return)
    assert all(field.isVisible() for field in figures)
    assert [field.label.text() for field in (*figures, bar.compute)] == [
        "1,000 Hz", "Lateness: below 0.09 ms for 99 % of the ticks, at most 4.00 ms", "Missed ticks: 0",
        "Real-time priority (level 80 of 99)",
        "Computing the force took 3.1 µs",
    ]  # fmt: skip
    assert bar.priority.link.isHidden()
    assert link.nextInFocusChain() is bar.priority.link
    qtbot.keyClick(link, Qt.Key.Key_Return)
    assert bar.figures.isHidden()
    bar.show_figures(True)
    bar.show_nothing("No device")
    assert bar.loop.label.text() == "No device"
    assert bar.loop.link.isHidden()
    assert bar.figures.isHidden()


def test_the_loop_is_late_after_recent_missed_ticks_or_at_a_wrong_rate(bar):
    for changes, word in (
        ({"missed": 900}, "Loop on time"),  # these samples were missed long ago
        ({"missed_lately": 10}, "Loop on time"),  # this is one thousandth of 10,000 samples in 10 s
        ({"missed_lately": 11}, "Loop late"),
        ({"rate": 0.981 * 1000.0}, "Loop on time"),  # the rate may deviate by 2 %
        ({"rate": 0.979 * 1000.0}, "Loop late"),
        ({"rate": 0.0}, "Loop on time"),  # the rate is not measured yet
    ):
        bar.show_health(health(**changes), nominal=1000.0)
        assert bar.loop.link.text() == word, changes


def test_a_refused_priority_shows_the_lateness_and_a_remedy(bar, qtbot):
    refused = Priority("Normal priority", False, "Do this.")
    assert [late(us) for us in (90.0, 9949.0, 29_500.0)] == ["0.09 ms", "9.95 ms", "29.5 ms"]
    bar.show_health(health(priority=refused, missed=3, missed_lately=1, link=LINK))
    assert bar.priority.label.text() == "Normal priority, forces up to 4.00 ms late."
    assert bar.missed.label.text() == "Missed ticks: 5"
    bar.show_figures(True)
    assert bar.jumps.isHidden()
    bar.show_health(health(link=SimpleNamespace(lost_frames=0, clock_jumps=3)))
    assert (bar.jumps.isVisible(), bar.jumps.label.text()) == (
        True,
        "The board's clock jumped 3 times (corrected)",
    )
    with qtbot.waitSignal(bar.how_to_fix, timeout=PATIENCE_MS):
        bar.priority.link.click()


def test_the_clamp_light_stays_on_for_half_a_second(bar, monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(status_bar.time, "monotonic", lambda: clock[0])
    bar.show_clamp(False, 3.0)
    assert bar.clamp.label.text() == "Force below limit of 3.0 N"
    bar.show_clamp(True, 3.0)
    clock[0] += 0.49
    bar.show_clamp(False, 3.0)
    assert bar.clamp.label.text() == "Force cut to 3.0 N"
    clock[0] += 0.02
    bar.show_clamp(False, 3.0)
    assert bar.clamp.label.text() == "Force below limit of 3.0 N"
    bar.show_clamp(False, 3.0, -1.26)
    assert bar.clamp.label.text() == "Force −1.3 N, limit 3.0 N"


def test_fields_are_hidden_completely_and_the_clamp_light_never(bar, qapp):
    refused = health(priority=Priority("Normal priority", False, ""))
    for width in range(1400, 420, -70):
        bar.resize(width, 30)
        bar.show_health(refused)
        qapp.processEvents()
        assert bar.clamp.isVisible()
        assert bar.clamp.geometry().right() <= width
        for field in bar.findChildren(status_bar.Field):
            if field.isVisible():
                assert field.width() >= field.sizeHint().width()
        rules = [line for line in bar.findChildren(QFrame) if line.property("rule") and line.isVisible()]
        shown = [field.label for field in (bar.loop, bar.clamp, bar.margin) if field.isVisible()]
        assert len(rules) == len(shown) - 1
        assert max(part.mapTo(bar, QPoint()).x() for part in rules) < shown[-1].mapTo(bar, QPoint()).x()


def test_the_arrow_shows_clamping_of_its_row_and_the_light_of_the_whole_frame(window):
    row = telemetry(1)[0]
    for flags, barred in ((0, False), (rows.CLAMPED, True)):
        row[rows.FLAGS] = flags
        window.display.show_frame(row, True)
        assert window.centre.scene._motion.clamped == barred
        assert window.status.clamp.label.text() == "Force cut to 3.0 N"
