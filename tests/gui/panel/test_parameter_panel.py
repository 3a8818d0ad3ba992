"""Parameters in the panel: valid input of every kind reaches the loop, invalid input does not."""

import re

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QAbstractSlider, QApplication, QWidget

from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.formatting import unbroken
from hapkit_studio.gui.panel.rows import ChoiceRow, ParameterRow
from hapkit_studio.gui.widgets.parts import SIDE
from hapkit_studio.gui.widgets.text import rich
from hapkit_studio.parameters import Choice


@pytest.fixture
def window(reset_window):
    """Return the window with the running simulated device."""
    return reset_window


def rows(window):
    return window.panel.parameters.rows


def write(row, text):
    row.box.setFocus()
    row.box.selectAll()
    QTest.keyClicks(row.box, text)


def enter(row, text):
    write(row, text)
    QTest.keyClick(row.box, Qt.Key.Key_Return)


def pick(row, text):
    index = row.picker.findText(text)
    row.picker.setCurrentIndex(index)
    row.picker.activated.emit(index)


@pytest.mark.slow
def test_every_parameter_of_every_environment_has_a_row_named_with_value_and_unit(shared_window):
    for key, environment in shared_window.studio.environments.items():
        shared_window.studio.choose(key)
        assert list(rows(shared_window)) == [p.key for p in environment.parameters]
        for row in rows(shared_window).values():
            if isinstance(row, ParameterRow):
                for widget in (row.box, row.slider):
                    name = widget.accessibleName()
                    assert row.parameter.label in name
                    assert row.quantity.unit in name
                    assert row.box.text() in name
                assert unbroken(row.quantity.limits()) in row.box.toolTip()
            else:
                assert row.parameter.label in row.picker.accessibleName()


@pytest.mark.slow
def test_a_typed_number_is_applied_after_enter_or_focus_out(window):
    row, values = rows(window)["stiffness"], lambda: window.studio.engine.values
    write(row, "400")
    assert values()["stiffness"] == 250.0
    QTest.keyClick(row.box, Qt.Key.Key_Return)
    assert values()["stiffness"] == 400.0
    assert row.slider.value() == row.quantity.index(400.0)
    write(row, "120")
    rows(window)["damping"].box.setFocus()
    assert values()["stiffness"] == 120.0
    for text in ("2,5", "2.5"):
        enter(rows(window)["damping"], "0")
        enter(rows(window)["damping"], text)
        assert values()["damping"] == 2.5
    place = rows(window)["position"]
    assert (place.box.text(), place.unit.text()) == ("5.0", "mm")
    enter(place, "-10")
    assert values()["position"] == -0.010


def test_an_invalid_number_stays_in_the_box_and_the_loop_keeps_the_last_valid_one(window):
    row = rows(window)["stiffness"]
    for letters in ("nan", "inf"):
        enter(row, letters)
        assert window.studio.engine.values["stiffness"] == 250.0
    enter(row, "300")
    for text in ("9000", "-1"):
        enter(row, text)
        assert row.box.text().replace("−", "-") == text
        assert row.error.text() == "Stiffness must be between 0 and 5,000 N/m."
        assert row.error.isVisible()
        assert row.box.property("invalid") is True
        assert window.studio.engine.values["stiffness"] == 300.0
    enter(row, "310")
    assert not row.error.isVisible()
    assert window.studio.engine.values["stiffness"] == 310.0
    window.loop.set_folded(False)
    enter(window.loop.rate, "50")
    assert window.loop.rate.error.text() == "Servo rate must be between 100 and 10,000 Hz."
    assert window.studio.engine.loop.rate == 1000.0


def test_after_enter_the_scene_has_the_focus_unless_the_number_was_refused(window):
    row = rows(window)["stiffness"]
    enter(row, "9000")
    assert QApplication.focusWidget() is row.box
    enter(row, "300")
    assert QApplication.focusWidget() is window.centre.scene
    for _ in range(2):
        QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_3)
    assert window.studio.environment.key == "damping"
    assert window.studio.values_of("wall")["stiffness"] == 300.0
    window.views.show("stability")
    enter(window.views.page("stability").side.rows.rows["damping"], "6")
    assert QApplication.focusWidget() is window.centre.scene


@pytest.mark.slow
@pytest.mark.parametrize("part", ["slider", "box"])
def test_keys_change_the_value_in_steps_at_once(window, part):
    row, key = rows(window)["stiffness"], Qt.Key
    widget = getattr(row, part)
    widget.setFocus()
    more, less = (key.Key_Right, key.Key_Left) if part == "slider" else (key.Key_Up, key.Key_Down)
    for pressed, value in (
        (more, 260.0), (less, 240.0), (key.Key_PageUp, 350.0), (key.Key_PageDown, 150.0),
        (key.Key_Home, 0.0), (key.Key_End, 5000.0),
    ):  # fmt: skip
        window.studio.set_value("stiffness", 250.0)
        QTest.keyClick(widget, pressed)
        assert window.studio.engine.values["stiffness"] == value


def test_home_moves_the_cursor_while_a_text_is_being_edited(window):
    row = rows(window)["stiffness"]
    write(row, "77")
    QTest.keyClick(row.box, Qt.Key.Key_Home)
    assert window.studio.engine.values["stiffness"] == 250.0
    assert row.box.lineEdit().cursorPosition() == 0


def test_slider_double_click_and_reset(window):
    row = rows(window)["stiffness"]
    assert not row.reset.isVisible()
    middle = QPoint(row.slider.width() // 2, row.slider.height() // 2)
    QTest.mousePress(row.slider, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, middle)
    value = window.studio.engine.values["stiffness"]
    assert value == pytest.approx(5000.0 / 4, abs=60.0)  # the slider has a square-root scale
    assert row.box.text() == row.quantity.text(value)
    for back in (
        lambda: QTest.mouseClick(row.reset, Qt.MouseButton.LeftButton),
        lambda: QTest.mouseDClick(row.slider, Qt.MouseButton.LeftButton),
    ):
        enter(row, "900")
        assert row.reset.isVisible()
        back()
        assert window.studio.engine.values["stiffness"] == 250.0
        assert not row.reset.isVisible()


def test_a_choice_reaches_the_loop_and_tab_stops_only_at_the_chosen_option(window):
    row = rows(window)["side"]
    assert isinstance(row, ChoiceRow)
    for index in (1, 0):
        QTest.mouseClick(row.picker.button(index), Qt.MouseButton.LeftButton)
        assert window.studio.engine.values["side"] == index
        stops = [bool(b.focusPolicy() & Qt.FocusPolicy.TabFocus) for b in row.picker.buttons]
        assert stops == [index == 0, index == 1]


def test_an_environment_keeps_its_last_values(window):
    enter(rows(window)["stiffness"], "777")
    window.studio.choose("spring")
    assert window.studio.engine.environment.key == "spring"
    window.studio.choose("wall")
    assert rows(window)["stiffness"].box.text() == "777"
    assert window.studio.engine.values["stiffness"] == 777.0


def test_the_loop_unfolds_and_sets_rate_delay_estimator_and_grip(window):
    loop, engine = window.loop, window.studio.engine
    assert loop.folded
    assert not loop.rate.isVisible()
    loop.fold.click()
    assert loop.rate.isVisible()
    assert not loop.model.isVisible()
    loop.more.click()
    assert loop.model.isVisible()
    for key in ESTIMATORS:
        pick(loop.estimator, key.upper() if len(key) <= 4 else key.capitalize())
        assert engine.loop.estimator == key
        shown = [row.parameter for rows in loop.options.values() for row in rows if row.isVisible()]
        assert shown == list(ESTIMATORS[key].parameters)
        assert loop.summary().count(" · ") == 2
    enter(loop.rate, "500")
    enter(loop.delay, "2.5")
    assert (engine.loop.rate, engine.loop.delay) == (500.0, 0.0025)
    pick(loop.estimator, "IIR")
    enter(loop.options["iir"][0], "20")
    assert engine.loop.estimator == ("iir", {"cutoff": 20.0})
    pick(loop.grip, "Firm")
    assert engine.grip == "firm"
    loop.fold.click()
    assert loop.fold.text() == "500 Hz · 2.5 ms · IIR"


@pytest.mark.slow
def test_folds_of_the_loop_are_stored_and_enter_toggles_them(make_window, qtbot):
    first = make_window()
    assert (first.loop.folded, first.loop.more.text()) == (True, "More settings")
    for link in (first.loop.fold, first.loop.more):
        qtbot.keyClick(link, Qt.Key.Key_Return)
    first.close()
    again = make_window()
    assert (again.loop.folded, again.loop.more.text()) == (False, "Fewer settings")
    assert again.loop.rate.isVisible()


def test_the_panel_scrolls_to_the_title_of_another_environment(window):
    window.resize(1280, 720)
    window.studio.choose("friction")
    QApplication.processEvents()
    bar = window.panel.upper.verticalScrollBar()
    bar.setValue(bar.maximum())
    assert bar.value() > 0
    window.studio.choose("texture")
    assert bar.value() == 0


def test_the_first_sentence_is_shown_and_the_whole_explanation_on_request(shared_window):
    studio, title = shared_window.studio, shared_window.panel.title
    for key, environment in studio.environments.items():
        studio.choose(key)
        shown = title.explanation.text()
        assert title.explanation.isVisible()
        assert shown.endswith(".")
        assert rich(environment.explanation).startswith(f"{shown} ")
        assert len(shown) < 140
        title.help.setChecked(True)
        assert title.whole.text() == rich(environment.explanation)
        assert title.card.isVisible()
        assert title.card.height() >= title.card.heightForWidth(title.card.width())
        title.help.setChecked(False)
        assert title.card.isHidden()


def test_neither_x_nor_the_question_mark_moves_a_control(shared_window, qapp):
    window = shared_window

    def places():
        for _ in range(3):
            qapp.processEvents()
        parts = [*window.panel.findChildren(QAbstractButton), *window.panel.findChildren(QAbstractSlider)]
        own = window.panel.two.button
        shown = [part for part in parts if part.isVisible() and part is not own]
        return {part: part.mapTo(window, QPoint()) for part in shown}

    for size in ((1280, 720), (1440, 900)):
        window.resize(*size)
        for key in window.studio.environments:
            window.studio.choose(key)
            before = places()
            window.panel.title.help.setChecked(True)
            assert places() == before, (size, key)
            card = window.panel.title.card
            assert window.rect().contains(card.geometry())
            panel = QRect(window.panel.mapTo(window, QPoint()), window.panel.size())
            assert not card.geometry().intersects(panel)
            if window.panel.parameters.rows:
                window.two.step()
                assert window.panel.two.isVisible()
                assert places() == before, (size, key)
            window.panel.title.help.setChecked(False)
            window.two.forget()


def test_a_parameter_without_effect_is_locked_with_a_reason_and_keeps_its_value(window):
    window.studio.choose("hard_surface")
    enter(rows(window)["frequency"], "77")
    pick(rows(window)["material"], "Aluminium")
    row = rows(window)["frequency"]
    assert not any(rows(window)[key].isEnabled() for key in ("frequency", "amplitude", "decay"))
    assert all(rows(window)[key].isEnabled() for key in ("stiffness", "limit", "material"))
    for widget in (row, row.label, row.box, row.slider):
        assert "The material Aluminium sets the ringing frequency to 300\u00a0Hz." in widget.toolTip()
    assert (row.box.text(), window.studio.values["frequency"]) == ("77", 77.0)
    pick(rows(window)["material"], "Custom")
    assert row.isEnabled()
    assert "Aluminium" not in row.box.toolTip()
    assert row.box.text() == "77"


def test_a_choice_can_be_locked_too(qtbot):
    row = ChoiceRow(Choice("side", "Side", ("right", "left"), help="Where it stands"), "<i>F</i> = 0")
    qtbot.addWidget(row)
    assert row.toolTip() == "<p>Where it stands.</p><p><i>F</i> = 0</p>"
    row.set_locked("Not used by bands")
    assert not row.picker.isEnabled()
    assert row.toolTip().startswith("<p>Not used by bands. Where it stands.</p>")


def test_option_names_and_formula_symbols_are_formatted(shared_window):
    shared_window.studio.choose("wall")
    title = shared_window.panel.title
    assert not title.formula.font().italic()
    assert "in the wall" in re.sub("<i>.*?</i>", "", title.formula.text())
    assert "<i>k d</i>" in title.formula.text()
    shared_window.studio.choose("puck")
    picker = rows(shared_window)["integrator"].picker
    euler = ["Explicit Euler", "Lecture's rule", "Semi-implicit", "Verlet", "RK4", "Implicit Euler"]
    assert [picker.itemText(i) for i in range(picker.count())][:6] == euler


def test_a_choice_with_one_option_has_a_row(qtbot):
    row = ChoiceRow(Choice("kind", "Kind", ("only",)))
    qtbot.addWidget(row)
    assert [button.property("segment") for button in row.picker.buttons] == ["first"]


def shown_rows(window):
    """Return top and bottom of every visible row, and the view's height."""
    upper = window.panel.upper
    rows = [
        r
        for r in upper.body.findChildren(QWidget)
        if isinstance(r, ParameterRow | ChoiceRow) and r.isVisibleTo(upper)
    ]
    tops = [row.mapTo(upper.viewport(), QPoint()).y() for row in rows]
    return [(top, top + row.height()) for top, row in zip(tops, rows, strict=True)], upper.viewport().height()


def uncovered(window):
    """Return the last pixel row of the view that is not covered."""
    upper = window.panel.upper
    return upper._cover.mapTo(upper, QPoint()).y()


@pytest.mark.parametrize("size", [(1280, 720), (1366, 768)])
def test_the_view_ends_between_two_rows_at_every_scroll_position(window, qapp, size):
    window.resize(*size)
    window.loop.set_folded(False)
    qapp.processEvents()
    bar, cut = window.panel.upper.verticalScrollBar(), 0
    for value in range(0, bar.maximum() + 1, 7):
        bar.setValue(value)
        rows, bottom = shown_rows(window)
        end = uncovered(window)
        assert not [row for row in rows if row[0] < end < row[1]]
        assert not [row for row in rows if end < row[1] <= bottom], "a whole row is in sight"
        cut += end < bottom
    assert cut, "nothing had to be covered at any place"


def test_an_unfolded_part_is_scrolled_into_view(window, qapp):
    window.resize(1280, 720)
    qapp.processEvents()
    loop, bar = window.loop, window.panel.upper.verticalScrollBar()
    for link, part in ((loop.fold, loop.controller_hint), (loop.more, loop.model)):
        bar.setValue(0)
        QTest.mouseClick(link, Qt.MouseButton.LeftButton)
        qapp.processEvents()
        bottom = part.mapTo(window.panel.upper, QPoint(0, part.height())).y()
        assert 0 < bottom <= uncovered(window)
    QTest.mouseClick(loop.fold, Qt.MouseButton.LeftButton)
    assert loop.folded


def test_an_unfolded_row_in_a_narrow_panel_is_not_too_wide(make_window, qapp):
    """Before its first layout, a number box must not request the width that it has in a wide panel."""
    window = make_window(size=(1280, 720))
    window.loop.set_folded(False)
    assert window.loop.delay.minimumSizeHint().width() <= window.panel.upper.viewport().width() - 2 * SIDE
