"""A drawing in the window has theme colours, is drawn only while visible, and handles the mouse."""

import subprocess
import sys

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from hapkit_studio.gui.pages.drawing import Drawing
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import table
from tests.gui.pages.drawing_support import click, drawn, point, spot


@pytest.fixture
def drawing(qtbot):
    """Return a visible drawing with one animated point and with axes from 0 to 10 and from 0 to 100."""
    made = Drawing("Chart of up over across")
    qtbot.addWidget(made)
    made.resize(640, 420)
    made.limits, made.count = [100.0], 0

    def paint(figure, colors):
        made.count += 1
        axes = figure.add_subplot()
        axes.set_xlim(0.0, 10.0)
        axes.set_ylim(0.0, made.limits[0])
        return axes.plot([5.0], [50.0], "o", color=colors.danger, markersize=20)

    made.show_drawing(paint)
    made.show()
    drawn(made)
    return made


def seen(drawing, x, y):
    """Return the colour on the screen at a point."""
    place = spot(drawing, x, y)
    return drawing.canvas.grab().toImage().pixelColor(place).name().upper()


@pytest.mark.slow
def test_matplotlib_is_imported_with_the_first_view():
    code = "import sys, hapkit_studio.gui.shell.window, hapkit_studio.gui.pages as t; t.discover()"
    code += "; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


@pytest.mark.slow
def test_the_drawing_has_the_theme_colours(drawing):
    for mode in ("light", "dark", "contrast"):
        theme.set_mode(mode)
        drawn(drawing)
        assert seen(drawing, 5.0, 50.0) == table(mode)["danger"]
        assert drawing.canvas.grab().toImage().pixelColor(1, 1) == theme.color("surface")


@pytest.mark.slow
def test_an_outdated_drawing_is_paler(drawing):
    drawing.fade()
    drawn(drawing)
    assert seen(drawing, 5.0, 50.0) not in (table("light")["danger"], table("light")["plot"])


@pytest.mark.slow
def test_a_hidden_drawing_is_not_drawn(drawing, qapp, capfd):
    drawing.hide()
    before = drawing.count
    theme.set_mode("dark")
    qapp.processEvents()
    drawing.canvas.draw()
    assert drawing.count == before
    assert "Error" not in capfd.readouterr().err, "what moved is not drawn either"
    drawing.show()
    qapp.processEvents()
    assert drawing.count == before + 1


@pytest.mark.slow
def test_only_animated_artists_are_redrawn(drawing):
    before = drawing.count
    drawing.moving[0].set_data([2.0], [20.0])
    drawing.follow()
    assert drawing.count == before
    picture = drawing.canvas.grab().toImage()
    axes = drawing.figure.axes[0]
    x, y = axes.transData.transform((2.0, 20.0)) / drawing.canvas.device_pixel_ratio
    at = QPoint(round(x), round(drawing.canvas.height() - y))
    assert picture.pixelColor(at) == theme.color("danger")


def test_a_click_is_emitted_in_axis_units(drawing):
    heard = []
    drawing.clicked.connect(lambda x, y: heard.append((x, y)))
    click(drawing, 5.0, 50.0)
    assert heard == [pytest.approx((5.0, 50.0), rel=0.02)]
    click(drawing, 11.0, 50.0)
    click(drawing, 5.0, 50.0, Qt.MouseButton.RightButton)
    assert len(heard) == 1


def test_a_drag_continues_in_the_axes_of_its_press_and_ends_at_their_edge(drawing):
    heard = []
    drawing.dragged.connect(lambda x, y: heard.append((x, y)))
    begin, end = spot(drawing, 5.0, 50.0), spot(drawing, 5.0, 60.0)
    QTest.mousePress(drawing.canvas, Qt.MouseButton.LeftButton, pos=begin)
    drawing.limits[0] = 500.0
    drawing.resize(640, 366)
    drawn(drawing)
    QTest.mouseMove(drawing.canvas, end)
    assert heard[-1] == pytest.approx((5.0, 60.0), rel=0.02)
    QTest.mouseMove(drawing.canvas, QPoint(end.x(), -900))
    assert heard[-1] == pytest.approx((5.0, 100.0), rel=0.02)
    QTest.mouseRelease(drawing.canvas, Qt.MouseButton.LeftButton, pos=end)
    QTest.mouseMove(drawing.canvas, begin)
    assert heard[-1] == pytest.approx((5.0, 100.0), rel=0.02)


def test_the_point_within_reach_is_found(drawing):
    heard = []
    drawing.pointed.connect(
        lambda event: heard.append(event and drawing.near(event, [1.0, 5.0], [10.0, 50.0]))
    )
    point(drawing, 5.0, 50.0)
    assert heard[-1] == 1
    point(drawing, 8.0, 90.0)
    assert heard[-1] is None
