"""The projector view: its contents and sizes, its keys, and the settings restored afterwards."""

from itertools import product

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtGui import QFontInfo
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QPushButton, QSplitterHandle

from hapkit_studio.gui.shell.banners import Notice
from hapkit_studio.gui.state.lock import Lock
from hapkit_studio.gui.teach import demos
from hapkit_studio.gui.widgets import strokes
from hapkit_studio.gui.widgets.theme import theme
from tests.gui.shell.test_layout import cut_off
from tests.wide import wide

SIZES = [(1920, 1080), (1280, 720)]
FAULT = Notice(
    "fault",
    1,
    "danger",
    "triangle",
    "Fault: the handle moved too fast, 3.4 m/s (limit 3.0 m/s).",
    "Force is zero.",
)


@pytest.fixture
def window(reset_idle_window):
    """Return this test file's window in its initial state."""
    yield reset_idle_window
    reset_idle_window.demos.end()
    reset_idle_window.projector.end()
    reset_idle_window.showNormal()


@pytest.fixture
def projected(window, monkeypatch):
    """Return a function that presses F11 and resizes the window as a screen of that size would."""
    monkeypatch.setattr(window, "setWindowState", lambda _state: None)

    def project(window, size):
        press(window, Qt.Key.Key_F11)
        window.resize(*size)
        QTest.qWait(1)
        assert window.projector.on
        assert window.body.size().toTuple() == size

    return project


def press(window, key, modifier=Qt.KeyboardModifier.NoModifier):
    window.centre.scene.setFocus()
    QTest.keyClick(window.centre.scene, key, modifier)


def place(window, part):
    return QRect(part.mapTo(window, QPoint()), part.size())


def parts(window):
    """Return the rectangles of the visible parts by name."""
    centre = window.centre
    shown = {
        "header": window.header, "banners": window.banners, "scene": centre.scene_card,
        "time": centre.time_card, "phase": centre.phase_card, "values": centre.values_card,
        "caption": window.caption, "status": window.status,
    }  # fmt: skip
    return {name: place(window, part) for name, part in shown.items() if part.isVisible()}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "key"),
    wide(product(SIZES, ("cat", "mass_spring_damper")), lambda size, key: (size, key) == (SIZES[1], "cat")),
)
def test_the_projected_parts_are_large_and_complete(window, projected, size, key):
    """Sizes are those of the design for 1080 lines, scaled down for fewer lines."""
    share = size[1] / 1080
    window.studio.choose(key)
    projected(window, size)
    found = parts(window)
    assert found.keys() == {"header", "scene", "time", "phase", "values", "status"}
    assert found["scene"].height() == pytest.approx(396 * share, abs=6)
    assert [c.plot_of.key for c in window.centre.time.canvases if c.isVisible()] == ["position", "force"]
    for part in (window.menuBar(), window.gallery, window.body.side, window.centre.toolbar):
        assert not part.isVisible()
    stop = place(window, window.header.stop)
    assert stop.height() == pytest.approx(64 * share, abs=2)
    assert stop.right() > size[0] - 20
    assert stop.top() < 20
    assert theme.name == "contrast"
    assert (strokes.pen(theme.color("position"), 2.0).widthF(), theme.frame) == (2.0 * theme.scale, 2)
    assert theme.scale == pytest.approx(2.0 * share, abs=0.04)
    labels = [part for part in window.findChildren(QLabel) if part.isVisible() and part.text()]
    assert len(labels) > 10
    for part in labels:
        assert QFontInfo(part.font()).pixelSize() >= int(20 * share), part.text()
        wide = part.hasHeightForWidth() or part.width() >= part.sizeHint().width()
        assert wide, part.text()


@pytest.mark.slow
@pytest.mark.parametrize("size", [*SIZES, (960, 540)])
def test_the_buttons_in_the_header_show_all_their_text(window, projected, size):
    projected(window, size)
    assert cut_off(window.header) == []
    window.studio.stop()
    assert cut_off(window.header) == []
    window.studio.release_stop()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "on_projector"), wide(product(SIZES, (True, False)), lambda size, _on: size == SIZES[1])
)
def test_nothing_overlaps_with_a_banner_and_a_caption(window, projected, size, on_projector):
    window.resize(*size)
    if on_projector:
        projected(window, size)
    window.banners.set("fault", FAULT)
    window.demos.play(demos.read(demos.named("buzzing_wall"), window.studio.environments))
    QTest.qWait(1)
    found = parts(window)
    assert {"banners", "caption", "scene", "time"} <= found.keys()
    for name, box in found.items():
        assert window.rect().contains(box), name
        for other in found.keys() - {name}:
            assert not box.intersects(found[other]), (name, other)
    label = window.caption.label
    longest = max((s.caption for d in demos.shipped().values() for s in demos.read(
        d, window.studio.environments).steps), key=len)  # fmt: skip
    label.setText(longest)
    assert label.heightForWidth(label.width()) <= window.caption.height()
    assert found["scene"].height() >= 150 * theme.scale
    window.banners.set("fault", None)


@pytest.mark.slow
def test_leaving_restores_the_settings(window, qtbot):
    window.set_theme("dark")
    window.views.show("stability")
    window.body.open_drawer(False)
    before = window.size()
    press(window, Qt.Key.Key_F11)
    assert (window.views.key, window.isFullScreen()) == ("live", True)
    assert window.settings.value("theme") == "dark"
    window.projector.leave.click()
    window.resize(before)
    assert (theme.mode, theme.frame, window.views.key) == ("dark", 1, "stability")
    assert not window.isFullScreen()
    assert window.menuBar().isVisible()
    assert window.gallery.isVisible()
    assert window.header.tabs.isVisible()
    assert not window.panel_open
    assert not window.centre.values_card.isVisible()
    window.views.show("live")
    assert window.centre.toolbar.isVisible()
    assert all(c.isVisible() for c in window.centre.time.canvases)
    window.set_theme("light")


@pytest.mark.slow
def test_keys_work_as_usual(window, projected):
    projected(window, SIZES[0])
    press(window, Qt.Key.Key_1)
    assert window.studio.environment.key == "spring"
    press(window, Qt.Key.Key_Space)
    assert window.live.paused
    press(window, Qt.Key.Key_Space)
    stiffness, damping = window.studio.values["stiffness"], window.studio.values["damping"]
    for key in (Qt.Key.Key_Plus, Qt.Key.Key_Plus, Qt.Key.Key_Minus):
        press(window, key)
    press(window, Qt.Key.Key_Plus, Qt.KeyboardModifier.ControlModifier)
    steps = [value.quantity.step for value in window.projector.card.values]
    assert window.studio.values["stiffness"] == stiffness + steps[0]
    assert window.studio.values["damping"] == damping + steps[1]
    assert window.projector.card.values[0].figure.text() == f"{stiffness + steps[0]:g}"
    press(window, Qt.Key.Key_Escape)
    assert window.studio.stopped
    press(window, Qt.Key.Key_F11)
    assert not window.projector.on
    press(window, Qt.Key.Key_Plus)
    assert window.studio.values["stiffness"] == stiffness + steps[0]


@pytest.mark.slow
def test_each_environment_remembers_its_two_selected_values(window):
    card, settings = window.projector.card, window.settings
    settings.remove("projected")
    assert card.chosen == ["stiffness", "damping"]
    menu = card.values[1].findChild(QPushButton).menu()
    next(action for action in menu.actions() if action.text() == "Damping acts").trigger()
    assert card.chosen == ["stiffness", "damping_mode"]
    assert card.values[1].figure.text() == "On the way in"
    card.step(1, 1)
    assert card.values[1].figure.text() == "Both ways"
    window.studio.choose("free")
    assert card.values == []
    card.step(0, 1)
    window.studio.choose("wall")
    assert [value.parameter.key for value in card.values] == ["stiffness", "damping_mode"]
    card.choose(0, "damping_mode")
    assert card.chosen == ["damping_mode", "stiffness"]
    settings.remove("projected")


@pytest.mark.slow
def test_a_padlock_is_shown_only_for_a_locked_setting(window, projected):
    window.projector.card.rebuild()
    projected(window, SIZES[0])
    window.studio.permissions.set_lock(Lock(frozenset({("value", "wall", "stiffness")})))
    found = [(value.padlock.isVisible(), value.slider.isEnabled()) for value in window.projector.card.values]
    assert found == [(True, False), (False, True)]
    window.studio.permissions.set_lock(Lock())
    assert not window.projector.card.values[0].padlock.isVisible()
    assert window.projector.card.values[0].slider.isEnabled()


@pytest.mark.slow
def test_changing_the_view_deletes_no_widget_while_qt_styles_it(window, projected):
    """A splitter deletes the handle of a removed part, and Qt would style it afterwards."""
    died = []
    for _ in range(2):
        for handle in window.findChildren(QSplitterHandle):
            handle.destroyed.connect(lambda: died.append(theme.refreshing))
        projected(window, SIZES[0])
        window.projector.toggle()
        window.resize(1440, 900)
    assert not any(died)


@pytest.mark.slow
def test_the_verdict_is_visible(window, projected):
    projected(window, SIZES[1])
    window.stability.judged.emit("Buzzes if you let go", "triangle", "danger")
    label = window.projector.card.verdict.label
    assert label.isVisible()
    assert label.text() == "Buzzes if you let go"
    assert QFontInfo(label.font()).pixelSize() >= 18
