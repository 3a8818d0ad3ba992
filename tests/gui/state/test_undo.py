"""Undo and redo: one step for each change of settings by the user, named after the changed settings."""

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.state.undo import settings_of
from tests.gui.window_support import put_back

CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
UNDO, REDO, REDO_TOO = (Qt.Key.Key_Z, CTRL), (Qt.Key.Key_Z, CTRL | SHIFT), (Qt.Key.Key_Y, CTRL)


@pytest.fixture
def window(reset_window):
    """Return this test file's window with an empty undo history."""
    reset_window.history.forget()
    yield reset_window
    put_back(reset_window)


def press(window, key):
    QTest.keyClick(window.focusWidget() or window, *key)


def type_stiffness(window, text, end=Qt.Key.Key_Return):
    box = window.panel.parameters.rows["stiffness"].box
    box.setFocus()
    box.selectAll()
    QTest.keyClicks(box, text)
    QTest.keyClick(box, end)


CHANGES = {
    "value": lambda s: s.set_value("stiffness", 700.0),
    "values": lambda s: s.set_values({"stiffness": 700.0, "damping": 3.0, "side": 1.0}),
    "environment": lambda s: s.choose("spring"),
    "rate": lambda s: s.set_loop(rate=2000.0),
    "delay": lambda s: s.set_loop(delay=0.002),
    "estimator": lambda s: s.set_loop(estimator=("iir", {"cutoff": 50.0})),
    "controller": lambda s: s.set_loop(controller=True),
    "model": lambda s: s.set_loop(model="everything"),
    "grip": lambda s: s.set_loop(hand="firm"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CHANGES)
def test_every_setting_is_undone_and_redone_in_window_and_engine(window, name):
    studio, stack = window.studio, window.history.stack
    before = settings_of(studio)
    CHANGES[name](studio)
    after = settings_of(studio)
    assert stack.count() == 1
    for key, there in ((UNDO, before), (REDO, after), (UNDO, before), (REDO_TOO, after)):
        window.centre.scene.setFocus()
        press(window, key)
        assert settings_of(studio) == there
        engine = studio.engine
        assert engine.environment.key == studio.environment.key
        assert engine.values == studio.values
        assert (engine.loop.rate, engine.loop.delay) == (studio.loop.rate, studio.loop.delay)
        assert (engine.grip, engine.loop.model) == (studio.grip, studio.loop.model)
    assert stack.count() == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda s: s.set_value("stiffness", 1500.0), "stiffness 250 → 1,500 N/m"),
        (lambda s: s.set_value("position", -0.0125), "position 5.0 → −12.5 mm"),
        (lambda s: s.set_value("damping_mode", 1.0), "damping acts On the way in → Both ways"),
        (lambda s: s.set_values({"stiffness": 1.0, "damping": 1.0}), "2 settings"),
        (lambda s: s.choose("spring"), "Wall → Spring"),
        (lambda s: s.set_loop(estimator=("iir", {"cutoff": 50.0})), "velocity Kalman → IIR"),
        (lambda s: s.set_loop(delay=0.002), "added delay 0.0 → 2.0 ms"),
        (lambda s: s.set_loop(controller=True), "passivity controller off → on"),
        (lambda s: s.set_loop(hand="firm"), "grip Medium → Firm"),
    ],
)
def test_the_menu_names_the_change_to_undo(window, change, text):
    qt = window.actions_by_key.qt
    assert (qt["edit.undo"].text(), qt["edit.undo"].isEnabled()) == ("Undo", False)
    change(window.studio)
    assert (qt["edit.undo"].text(), qt["edit.undo"].isEnabled()) == (f"Undo {text}", True)
    window.actions_by_key.run("edit.undo")
    assert (qt["edit.redo"].text(), qt["edit.redo"].isEnabled()) == (f"Redo {text}", True)


def test_a_drag_is_one_step_and_a_drag_back_to_its_start_is_none(window):
    studio, stack = window.studio, window.history.stack
    row = window.panel.parameters.rows["damping"]
    studio.set_value("damping", row.quantity.value(0.5))
    window.history.forget()
    slider, seen = row.slider, set()
    thumb, y = round(slider._place(slider._exact)), slider.height() // 2

    def drag(*places):
        QTest.mousePress(slider, Qt.MouseButton.LeftButton, pos=QPoint(thumb, y))
        for x in places:
            QTest.mouseMove(slider, QPoint(x, y))
            seen.add(studio.values["damping"])
        QTest.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=QPoint(places[-1], y))

    start = studio.values["damping"]
    drag(thumb + 10, thumb + 25, thumb + 40)
    assert len(seen) == 3
    assert stack.count() == 1
    far = studio.values["damping"]
    stack.undo()
    assert studio.values["damping"] == start
    stack.redo()
    assert studio.values["damping"] == far
    stack.undo()
    thumb = round(slider._place(slider._exact))
    QTest.mousePress(slider, Qt.MouseButton.LeftButton, pos=QPoint(thumb, y))
    QTest.mouseMove(slider, QPoint(thumb + 30, y))
    studio.set_value("damping", start)  # a pixel is too coarse for the exact value
    QTest.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=QPoint(thumb, y))
    assert not stack.canUndo()


def test_each_key_and_each_typed_number_is_a_step(window):
    studio, stack = window.studio, window.history.stack
    type_stiffness(window, "300")
    type_stiffness(window, "500")
    assert stack.undoText() == "stiffness 300 → 500 N/m"
    slider = window.panel.parameters.rows["stiffness"].slider
    for _ in range(3):
        QTest.keyClick(slider, Qt.Key.Key_Right)
    assert stack.count() == 5
    for expected in (520.0, 510.0, 500.0, 300.0, 250.0):
        press(window, UNDO)
        assert studio.values["stiffness"] == expected


def test_a_number_being_typed_has_its_own_undo(window):
    """After the number was accepted, Ctrl+Z in the box undoes the setting."""
    type_stiffness(window, "300")
    box = window.panel.parameters.rows["stiffness"].box
    box.setFocus()
    box.selectAll()
    QTest.keyClicks(box, "45")
    press(window, UNDO)
    assert window.studio.values["stiffness"] == 300.0
    box.show_value(300.0)
    press(window, UNDO)
    assert window.studio.values["stiffness"] == 250.0


def test_resetting_to_the_defaults_is_one_step(window):
    studio = window.studio
    studio.set_values({"stiffness": 900.0, "damping": 4.0})
    left = dict(studio.values)
    window.history.gesture += 1
    window.actions_by_key.run("environment.reset")
    assert window.history.stack.undoText() == "2 settings"
    window.history.stack.undo()
    assert studio.values == left


def test_undo_restores_only_the_settings_that_the_step_changed(window):
    studio = window.studio
    studio.set_value("stiffness", 900.0)
    with studio.temporarily():
        studio.set_loop(hand="firm")
    assert window.history.stack.count() == 1
    window.history.stack.undo()
    assert (studio.values["stiffness"], studio.grip) == (250.0, "firm")


def test_stop_fault_and_refused_value_are_no_steps(window):
    studio = window.studio
    studio.stop()
    studio.zero_here()
    with pytest.raises(ParameterError):
        studio.set_value("stiffness", 5001.0)
    assert window.history.stack.count() == 0
    studio.set_value("stiffness", 900.0)
    window.history.stack.undo()
    assert studio.stopped
    assert studio.engine.stopped


def test_a_step_that_cannot_be_undone_gives_a_one_line_message_and_changes_nothing(window):
    studio, stack = window.studio, window.history.stack
    spring = studio.environments["spring"]
    studio.choose("spring")
    studio.set_values({"stiffness": 20.0})
    window.history.gesture += 1
    studio.choose("wall")
    values = studio.values_of("spring")
    studio.drop("spring")
    try:
        studio.choose("damping")
        assert stack.undoText() == f"spring → {studio.environment.title}"
        window.history.undo()
        assert studio.environment.key == "damping"
        (banner,) = window.banners.banners
        assert banner.text.text().endswith("The environment spring is no longer installed.")
        assert stack.count() == 1
    finally:
        studio.library.put(spring)
        studio.set_values_of("spring", values)


def test_settings_restored_at_the_start_are_no_step(start_window):
    first = start_window()
    first.studio.set_value("stiffness", 640.0)
    first.close()
    again = start_window()
    assert again.studio.values["stiffness"] == 640.0
    assert not again.history.stack.canUndo()
    again.studio.set_value("stiffness", 700.0)
    again.history.undo()
    assert again.studio.values["stiffness"] == 640.0
