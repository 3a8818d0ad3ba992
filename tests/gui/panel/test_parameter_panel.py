"""Parameters at the panel: what is typed, dragged, stepped and reset reaches the loop, nothing bad does."""

import math
import re

import pytest
from PySide6.QtCore import QPoint, QRect, QSize, Qt
from PySide6.QtTest import QTest

from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.gui.panel.rows import ChoiceRow, ParameterRow
from hapkit_studio.parameters import Choice


def rows(window):
    return window.panel.parameters.rows


def enter(row, text):
    row.box.setFocus()
    row.box.selectAll()
    QTest.keyClicks(row.box, text)
    QTest.keyClick(row.box, Qt.Key.Key_Return)


def pick(row, words):
    index = row.picker.findText(words)
    row.picker.setCurrentIndex(index)
    row.picker.activated.emit(index)


def test_every_parameter_of_every_environment_has_a_row_named_with_value_and_unit(idle_window):
    for key, environment in idle_window.studio.environments.items():
        idle_window.studio.choose(key)
        assert list(rows(idle_window)) == [p.key for p in environment.parameters]
        for row in rows(idle_window).values():
            if isinstance(row, ParameterRow):
                for widget in (row.box, row.slider):
                    name = widget.accessibleName()
                    assert row.parameter.label in name
                    assert row.quantity.unit in name
                    assert row.box.text() in name
                assert row.quantity.limits() in row.box.toolTip()
            else:
                assert row.parameter.label in row.picker.accessibleName()


def test_a_number_typed_is_in_force_after_enter_and_not_before(window):
    row = rows(window)["stiffness"]
    row.box.setFocus()
    row.box.selectAll()
    QTest.keyClicks(row.box, "400")
    assert window.studio.engine.values["stiffness"] == 250.0
    QTest.keyClick(row.box, Qt.Key.Key_Return)
    assert window.studio.engine.values["stiffness"] == 400.0
    assert row.slider.value() == row.quantity.index(400.0)


def test_a_number_typed_is_in_force_after_leaving_the_box(window):
    row = rows(window)["stiffness"]
    row.box.setFocus()
    row.box.selectAll()
    QTest.keyClicks(row.box, "120")
    rows(window)["damping"].box.setFocus()
    assert window.studio.engine.values["stiffness"] == 120.0


def test_millimetres_on_the_screen_are_metres_in_the_loop(window):
    row = rows(window)["position"]
    assert (row.box.text(), row.unit.text()) == ("5.0", "mm")
    enter(row, "-10")
    assert window.studio.engine.values["position"] == -0.010


@pytest.mark.parametrize("text", ["2,5", "2.5"])
def test_comma_and_point_are_both_taken(window, text):
    enter(rows(window)["damping"], text)
    assert window.studio.engine.values["damping"] == 2.5


@pytest.mark.parametrize("text", ["9000", "-1"])
def test_out_of_range_stays_in_the_box_and_the_loop_keeps_the_last_good_value(window, text):
    row = rows(window)["stiffness"]
    enter(row, "300")
    enter(row, text)
    assert row.box.text().replace("−", "-") == text
    assert row.error.text() == "Stiffness goes from 0 to 5000 N/m."
    assert row.error.isVisible()
    assert row.box.property("invalid") is True
    assert window.studio.engine.values["stiffness"] == 300.0
    enter(row, "310")
    assert not row.error.isVisible()
    assert window.studio.engine.values["stiffness"] == 310.0


def test_letters_cannot_be_typed_into_a_number(window):
    row = rows(window)["stiffness"]
    enter(row, "nan")
    enter(row, "inf")
    assert math.isfinite(window.studio.engine.values["stiffness"])
    assert window.studio.engine.values["stiffness"] == 250.0


@pytest.mark.parametrize(
    ("key", "value"),
    [
        (Qt.Key.Key_Right, 260.0),
        (Qt.Key.Key_Left, 240.0),
        (Qt.Key.Key_PageUp, 350.0),
        (Qt.Key.Key_PageDown, 150.0),
        (Qt.Key.Key_Home, 0.0),
        (Qt.Key.Key_End, 5000.0),
    ],
)
def test_keys_on_the_slider_go_by_steps_of_ten(window, key, value):
    QTest.keyClick(rows(window)["stiffness"].slider, key)
    assert window.studio.engine.values["stiffness"] == value


@pytest.mark.parametrize(
    ("key", "value"),
    [
        (Qt.Key.Key_Up, 260.0),
        (Qt.Key.Key_Down, 240.0),
        (Qt.Key.Key_PageUp, 350.0),
        (Qt.Key.Key_Home, 0.0),
        (Qt.Key.Key_End, 5000.0),
    ],
)
def test_keys_in_the_box_are_in_force_at_once(window, key, value):
    box = rows(window)["stiffness"].box
    box.setFocus()
    QTest.keyClick(box, key)
    assert window.studio.engine.values["stiffness"] == value


def test_home_moves_the_cursor_while_a_text_is_being_edited(window):
    box = rows(window)["stiffness"].box
    box.setFocus()
    box.selectAll()
    QTest.keyClicks(box, "77")
    QTest.keyClick(box, Qt.Key.Key_Home)
    assert window.studio.engine.values["stiffness"] == 250.0
    assert box.lineEdit().cursorPosition() == 0


def test_dragging_the_slider_is_in_force_at_once_on_its_square_root_scale(window):
    row = rows(window)["stiffness"]
    middle = QPoint(row.slider.width() // 2, row.slider.height() // 2)
    QTest.mousePress(row.slider, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, middle)
    value = window.studio.engine.values["stiffness"]
    assert value == pytest.approx(5000.0 / 4, abs=60.0)
    assert row.box.text() == row.quantity.text(value)


def test_double_click_and_reset_give_the_default_and_reset_shows_only_when_changed(window):
    row = rows(window)["stiffness"]
    assert not row.reset.isVisible()
    enter(row, "900")
    assert row.reset.isVisible()
    QTest.mouseClick(row.reset, Qt.MouseButton.LeftButton)
    assert window.studio.engine.values["stiffness"] == 250.0
    assert not row.reset.isVisible()
    enter(row, "900")
    QTest.mouseDClick(row.slider, Qt.MouseButton.LeftButton)
    assert window.studio.engine.values["stiffness"] == 250.0


@pytest.mark.parametrize(("value", "right"), [(0.0, False), (5000.0, True)])
def test_a_thumb_at_a_limit_shows_its_focus_ring_whole(window, value, right):
    slider, body = rows(window)["stiffness"].slider, window.panel.widget()
    edge = QRect(slider.mapTo(body, QPoint(slider.width() - 1 if right else 0, 0)), QSize(1, slider.height()))
    slider.show_value(value)
    before = body.grab(edge).toImage()
    slider.setFocus(Qt.FocusReason.TabFocusReason)
    assert body.grab(edge).toImage() == before


def test_tab_stops_at_the_chosen_option_alone(window):
    picker = rows(window)["side"].picker
    for index in (1, 0):
        picker.show_index(index)
        stops = [bool(b.focusPolicy() & Qt.FocusPolicy.TabFocus) for b in picker.buttons]
        assert stops == [index == 0, index == 1]


def test_a_choice_reaches_the_loop(window):
    row = rows(window)["damping_mode"]
    assert isinstance(row, ChoiceRow)
    QTest.mouseClick(row.picker.button(1), Qt.MouseButton.LeftButton)
    assert window.studio.engine.values["damping_mode"] == 1.0


def test_an_environment_is_found_again_as_it_was_left(window):
    enter(rows(window)["stiffness"], "777")
    window.studio.choose("spring")
    assert window.studio.engine.environment.key == "spring"
    window.studio.choose("wall")
    assert rows(window)["stiffness"].box.text() == "777"
    assert window.studio.engine.values["stiffness"] == 777.0


@pytest.mark.parametrize("key", ESTIMATORS)
def test_the_loop_panel_offers_every_estimator_with_its_options(window, key):
    loop = window.loop
    pick(loop.estimator, key.upper() if len(key) <= 4 else key.capitalize())
    assert window.studio.engine.loop.estimator == key
    shown = [row.parameter for rows in loop.options.values() for row in rows if row.isVisibleTo(window)]
    assert shown == list(ESTIMATORS[key].parameters)
    assert loop.summary().count(" · ") == 2


def test_the_loop_panel_sets_rate_delay_estimator_and_grip(window):
    loop, engine = window.loop, window.studio.engine
    enter(loop.rate, "500")
    enter(loop.delay, "2.5")
    assert (engine.loop.rate, engine.loop.delay) == (500.0, 0.0025)
    pick(loop.estimator, "IIR")
    enter(loop.options["iir"][0], "20")
    assert engine.loop.estimator == ("iir", {"cutoff": 20.0})
    pick(loop.estimator, "FOAW")
    enter(loop.options["foaw"][1], "1")
    assert engine.loop.estimator == ("foaw", {"noise": 1.0})
    assert not loop.options["iir"][0].isVisible()
    pick(loop.grip, "Firm")
    assert engine.grip == "firm"


def test_the_loop_panel_refuses_what_is_out_of_range(window):
    enter(window.loop.rate, "50")
    assert window.loop.rate.error.text() == "Servo rate goes from 100 to 10000 Hz."
    assert window.studio.engine.loop.rate == 1000.0


def test_a_number_without_effect_is_locked_says_why_and_keeps_its_value(window):
    window.studio.choose("hard_surface")
    enter(rows(window)["frequency"], "77")
    pick(rows(window)["material"], "Aluminium")
    row = rows(window)["frequency"]
    assert not any(rows(window)[key].isEnabled() for key in ("frequency", "amplitude", "decay"))
    assert all(rows(window)[key].isEnabled() for key in ("stiffness", "limit", "material"))
    for widget in (row, row.label, row.box, row.slider):
        assert "Aluminium sets it: 300 Hz." in widget.toolTip()
    assert (row.box.text(), window.studio.values["frequency"]) == ("77", 77.0)
    pick(rows(window)["material"], "Custom")
    assert row.isEnabled()
    assert "Aluminium" not in row.box.toolTip()
    assert row.box.text() == "77"


def test_a_choice_can_be_locked_too(qtbot):
    side = Choice("side", "Side", ("right", "left"), help="Where it stands")
    row = ChoiceRow(side, "<i>F</i> = 0")
    qtbot.addWidget(row)
    assert row.toolTip() == "<p>Where it stands.</p><p><i>F</i> = 0</p>"
    row.set_locked("Not used by bands")
    assert not row.picker.isEnabled()
    assert row.toolTip().startswith("<p>Not used by bands. Where it stands.</p>")
    row.set_locked("")
    assert row.picker.isEnabled()


def test_options_read_as_names_are_written(idle_window):
    def offered(environment, key):
        idle_window.studio.choose(environment)
        picker = rows(idle_window)[key].picker
        return [picker.itemText(i) for i in range(picker.count())]

    euler = ["Explicit Euler", "Lecture's rule", "Semi-implicit", "Verlet", "RK4", "Implicit Euler"]
    assert offered("puck", "integrator")[:6] == euler
    assert offered("friction", "model")[-1] == "LuGre"
    picker = idle_window.loop.estimator.picker
    assert [picker.itemText(i) for i in range(picker.count())] == [
        "Difference", "IIR", "Butterworth", "FOAW", "Kalman",
    ]  # fmt: skip


def test_words_in_a_formula_are_upright_and_symbols_slanted(idle_window):
    title = idle_window.panel.title
    idle_window.studio.choose("wall")
    assert not title.formula.font().italic()
    assert "inside, going in" in re.sub("<i>.*?</i>", "", title.formula.text())
    assert "<i>k d</i>" in title.formula.text()
