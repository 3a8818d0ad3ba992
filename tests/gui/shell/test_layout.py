"""Layout: no text is cut off, nothing overlaps, and parts shrink in the order of the design."""

import os
import subprocess
import sys

import pytest
from PySide6.QtCore import QCoreApplication, QPoint, QRect, Qt
from PySide6.QtGui import QFontInfo
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QLabel,
    QLineEdit,
    QMenu,
    QPushButton,
    QTabBar,
    QToolButton,
    QWidget,
)

from hapkit_studio import environments
from hapkit_studio.analysis.stability.verdict import VerdictInput
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.gui import pages
from hapkit_studio.gui.panel.limits import CardRequest, answer
from hapkit_studio.gui.panel.rows import ParameterRow
from hapkit_studio.gui.shell.banners import Notice
from hapkit_studio.gui.shell.gallery import GalleryRow
from hapkit_studio.gui.widgets import breakpoints
from tests.gui.window_support import delete_deferred
from tests.wide import wide

SIZES = [
    (1280, 720),
    (1366, 768),
    (1440, 900),
    (1920, 1080),
    (2560, 1440),
    (1024, 640),
    (960, 600),
    (800, 560),
    (960, 500),  # 1920 × 1080 at 200 %, minus a title bar of 40 px
    (853, 493),  # 1280 × 800 at 150 %
    (640, 360),  # 1280 × 800 at 200 %
]
WORST = "Hapkit on ttyUSB0 is disconnected."
LINE = "Force is zero. Nothing is lost. Trying to reconnect every second."


@pytest.fixture
def window(reset_window):
    """Return this test file's window with a running simulated device."""
    return reset_window


def lose_device(window) -> None:
    """Show the longest of the usual banners."""
    buttons = (("Use simulated Hapkit", window.studio.device.open_simulated),)
    window.banners.set("device", Notice("device", 2, "warn", "unplugged", WORST, LINE, buttons))


def place(widget: QWidget, window: QWidget) -> QRect:
    return QRect(widget.mapTo(window, QPoint(0, 0)), widget.size())


def cut_off(window: QWidget) -> list[str]:
    """Return the visible widgets that are smaller than their text needs."""
    for _ in range(3):
        QCoreApplication.processEvents()
    found = []
    for widget in window.findChildren(QWidget):
        if not widget.isVisibleTo(window) or widget.window() is not window.window():
            continue
        if isinstance(widget, QLabel) and widget.text():
            needed = widget.sizeHint()
            if widget.wordWrap():
                tall = widget.heightForWidth(widget.width()) > widget.height()
                if tall or widget.minimumSizeHint().width() > widget.width():
                    found.append(f"label {widget.text()!r}: {widget.size()}")
            elif needed.width() > widget.width() or needed.height() > widget.height():
                found.append(f"label {widget.text()!r}: {needed} in {widget.size()}")
        elif isinstance(widget.parent(), QTabBar | QLineEdit):
            continue  # arrows and the button that clears a field have a fixed picture
        elif isinstance(widget, QPushButton | QToolButton | GalleryRow):
            needed = widget.sizeHint()
            if needed.width() > widget.width() or needed.height() > widget.height():
                found.append(
                    f"button {widget.accessibleName() or widget.text()!r}: {needed} in {widget.size()}"
                )
    return found


def overlapping(window) -> list[str]:
    """Return the parts of the window that overlap or extend over its edge."""
    centre = window.centre
    parts = {
        "header": window.header, "gallery": window.gallery, "scene": centre.scene_card,
        "time": centre.time_card, "phase": centre.phase_card, "panel": window.panel, "status": window.status,
    }  # fmt: skip
    parts |= {f"banner {i}": banner for i, banner in enumerate(window.banners.banners)}
    shown = {name: place(w, window) for name, w in parts.items() if w.isVisible()}
    inside = centre.stack.isAncestorOf(centre.phase_card)
    found = [f"{name} leaves the window" for name, box in shown.items() if not window.rect().contains(box)]
    for name, box in shown.items():
        for other, second in shown.items():
            if (
                name < other
                and box.intersects(second)
                and not (inside and {name, other} == {"phase", "time"})
            ):
                found.append(f"{name} over {other}")
    return found


def settle(qapp, window, size):
    """Resize, wait for the stability result, and update every layout."""
    window.stability.ask()
    window.stability.wait()
    resize(qapp, window, size)


def resize(qapp, window, size):
    """Resize and let every layout follow."""
    delete_deferred()
    window.resize(*size)
    for _ in range(3):
        qapp.processEvents()


@pytest.mark.slow
@pytest.mark.parametrize("quick", wide([True, False], lambda quick: quick))
def test_nothing_is_cut_off_or_overlaps(window, qapp, quick):
    for number, key in enumerate(window.studio.environments):
        if quick != (key in ("wall", "texture", "cat")):
            continue
        window.studio.choose(key)
        settle(qapp, window, SIZES[0])
        for size in SIZES if key == "wall" else (SIZES[0], SIZES[number % len(SIZES)]):
            resize(qapp, window, size)
            assert cut_off(window) == [], (key, size)
            assert overlapping(window) == [], (key, size)
            small = min(breakpoints.scale(*size), 1.0)
            assert window.centre.scene.height() >= int(150 * small)
            assert window.header.stop.width() >= 120 * small
            # the limit is 95 % of the scaled height, because the button's border is not scaled
            assert window.header.stop.height() >= 0.95 * 40 * breakpoints.scale(*size)
            assert window.header.devices.isVisible()
            assert window.status.clamp.isVisible()
            assert every_view_is_offered(window)


def every_view_is_offered(window):
    """Return whether each view's tab is fully visible or listed in the menu at the end of the tab bar."""
    tabs = window.header.tabs
    seen = [index for index in range(tabs.count()) if tabs.isTabVisible(index)]
    in_menu = [tabs.tabText(index) for index in range(tabs.count()) if index not in seen]
    end = tabs.more.geometry().right() if in_menu else tabs.tabRect(seen[-1]).right()
    assert tabs.more.isVisible() == bool(in_menu)
    assert in_menu == [action.text() for action in tabs.menu.actions()]
    assert {0, tabs.currentIndex()} <= set(seen)
    return tabs.tabRect(0).left() >= 0 and end <= tabs.width()


@pytest.mark.slow
def test_every_view_can_be_opened_next_to_a_law_tab(window, qapp):
    tabs = window.header.tabs
    for size in ((1920, 1080), (1280, 720), (1024, 640)):
        settle(qapp, window, size)
        for law in (True, False):
            window.editor.shown.emit(law)
            qapp.processEvents()
            assert (window.views.key == "law") == law
            assert every_view_is_offered(window)
            if law:
                window.views.show("live")
                qapp.processEvents()
                assert tabs.isTabVisible(tabs.count() - 1)
                assert every_view_is_offered(window)


SHIPPED = 8
"""Views besides Live that fit at 1280 pixels; a further one moves behind More while recording."""
VIEWS = ("Live", "Stability", "Speed and accuracy", "Break it", "Bode", "Z-width", "Identify", "Sessions")


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1280, 720), (1439, 720), (1440, 900)])
def test_eight_views_and_an_open_law_are_visible_in_order(window, qapp, size):
    tabs = window.header.tabs
    titles = [tabs.tabText(index) for index in range(tabs.count())]
    assert [title for title in titles if title in VIEWS] == list(VIEWS)
    window.editor.shown.emit(True)
    resize(qapp, window, size)
    assert tabs.tabText(tabs.count() - 1) == "Law"
    tabs.setCurrentIndex(titles.index("Speed and accuracy"))  # the widest tab, with its title in bold
    window.views.page("break_it").marked.emit("Something acts on the scene")
    assert tabs.tabText(titles.index("Break it")) == "Break it ●"
    assert tabs.more.isHidden() or len(titles) > len(VIEWS)
    assert every_view_is_offered(window)
    QTest.keyClick(window, Qt.Key.Key_9, Qt.KeyboardModifier.ControlModifier)
    assert window.views.key == "law"
    window.views.page("break_it").marked.emit("")
    window.editor.shown.emit(False)


def test_every_view_keeps_its_tab_at_1280_while_paused_and_recording(window, qapp):
    settle(qapp, window, (1280, 720))
    header = window.header
    assert header.tabs.more.isHidden()
    header.show_paused(True)
    header.show_recording("10:05")
    qapp.processEvents()
    assert header.tabs.more.isHidden() or len(pages.discover()) > SHIPPED
    assert every_view_is_offered(window)
    header.show_paused(False)
    header.show_recording("")


def test_a_view_opened_from_the_menu_is_shown_with_its_tab(window, qapp):
    settle(qapp, window, (1024, 640))
    last = window.header.tabs.menu.actions()[-1]
    key, view = list(pages.discover().items())[-1]
    assert last.text() == view.title
    last.trigger()
    qapp.processEvents()
    assert window.views.key == key
    assert every_view_is_offered(window)


@pytest.mark.parametrize("size", [(1280, 720), (1440, 1200)])
def test_value_boxes_are_aligned_when_changed_or_scrolled(window, qapp, size):
    def columns():
        settle(qapp, window, size)
        rows = [*window.panel.parameters.rows.values(), window.loop.rate, window.loop.delay]
        boxes = [place(row.box, window) for row in rows if isinstance(row, ParameterRow) and row.isVisible()]
        return {(box.left(), box.right()) for box in boxes}

    before = columns()
    assert len(before) == 1
    window.studio.set_value("stiffness", 900.0)
    window.studio.set_loop(delay=0.002)
    window.panel.title.help.setChecked(True)
    window.loop.set_folded(False)
    assert columns() == before


def lines(label: QLabel) -> int:
    """Return how many lines a label's text takes."""
    one = label.heightForWidth(10_000)
    return 1 + round((label.heightForWidth(label.width()) - one) / (0.75 * one))


@pytest.mark.slow
@pytest.mark.parametrize(
    "size", wide([((1280, 720),), ((1440, 900),), ((960, 600),)], lambda size: size == (1280, 720))
)
def test_rows_are_clear_of_the_scroll_bar_and_aligned_with_short_labels(window, qapp, size):
    panel = window.panel
    for key in window.studio.environments:
        window.studio.choose(key)
        resize(qapp, window, size)
        window.actions_by_key.run("view.panel") if not window.panel_open else None
        settle(qapp, window, size)
        assert panel.upper.widget().width() <= panel.upper.viewport().width(), key
        shown = list(panel.parameters.rows.values())
        assert all(lines(row.label) <= 2 for row in shown), key
        numbers = [row for row in shown if isinstance(row, ParameterRow)]
        boxes = {(row.box.x(), row.box.width()) for row in numbers}
        assert not any(row.box.geometry().intersects(row.slider.geometry()) for row in numbers), key
        assert len(boxes) <= 1, key
        assert lines(panel.title.title) == 1, key
        assert lines(panel.title.formula) <= 2, key


@pytest.mark.parametrize(
    "size",
    wide(
        [((1280, 720),), ((1920, 1080),), ((960, 600),), ((800, 560),)], lambda size: size[0] in (1280, 800)
    ),
)
def test_a_banner_moves_the_content_down_by_its_height(window, qapp, size):
    settle(qapp, window, size)
    before, high = place(window.centre, window).top(), int(54 * breakpoints.scale(*size))
    lose_device(window)
    settle(qapp, window, size)
    assert place(window.centre, window).top() == before + high
    window.studio.stop()
    settle(qapp, window, size)
    assert place(window.centre, window).top() == before + 2 * high
    assert not window.panel_open or place(window.panel, window).top() == before
    assert cut_off(window) == []
    assert overlapping(window) == []
    assert window.centre.scene.height() >= 150


@pytest.mark.slow
def test_the_verdict_is_visible_below_two_banners_with_everything_unfolded(window, qapp):
    """The verdict is also visible if the parts above it need more space and must be scrolled.

    These parts are parameters, warnings, explanation and loop.
    """
    lose_device(window)
    window.studio.stop()
    panel, card = window.panel, window.stability
    long = answer(asked("wall", LoopSettings(delay=1e-3, hand="medium"), 4000.0))
    for key in window.studio.environments:
        window.studio.choose(key)
        for opened in (False, True):
            panel.title.help.setChecked(opened)
            window.loop.set_folded(not opened)
            resize(qapp, window, (1280, 720))
            card.show_answer(long)
            inside, shown = place(panel, window), place(card, window)
            assert inside.contains(shown), (key, opened)
            assert card.height() >= card.heightForWidth(card.width()), (key, opened)
            assert place(panel.upper, window).bottom() < shown.top()
            hidden, bar = panel.upper.body.height() - panel.upper.height(), panel.upper.verticalScrollBar()
            assert bar.maximum() == max(hidden, 0), (key, opened)
    assert bar.maximum() > 0


@pytest.mark.parametrize("size", [(1280, 720), (960, 600), (800, 560)])
def test_the_layout_fits_with_refused_values_priority_and_a_banner(window, qapp, size):
    window.body.open_drawer(True)
    lose_device(window)
    for row in window.panel.parameters.rows.values():
        if isinstance(row, ParameterRow):
            row.show_error(row.quantity.limits())
    window.live.refresh()
    assert not window.studio.engine.health().priority.realtime
    settle(qapp, window, size)
    assert size[0] >= breakpoints.BANNERS_BESIDE_PANEL or window.banners.banners[0].width() == size[0]
    assert cut_off(window) == []
    assert overlapping(window) == []


def test_gallery_scene_and_panel_shrink_in_smaller_windows(window, qapp):
    def seen(width, height):
        settle(qapp, window, (width, height))
        return window.gallery.width(), window.panel.width(), window.centre.scene.height()

    wide = seen(1440, 900)
    window.studio.choose("cat")
    assert seen(1440, 900) > wide  # the cat's scene is taller; the widths are unchanged
    window.studio.choose("wall")
    assert seen(1440, 900) == wide
    small = seen(1280, 720)
    assert all(below < above for below, above in zip(small, wide, strict=True))
    assert not window.header.pause.cap.isVisible()
    assert seen(1000, 620)[0] == small[0]
    assert not window.panel_open
    assert window.header.panel.isVisible()
    window.actions_by_key.run("view.panel")
    assert seen(1000, 620)[:2] == small[:2]
    assert window.panel_open
    assert window.centre.toolbar.views.isVisible()
    assert window.header.stop.cap.isVisible()


def test_key_caps_give_way_before_a_tab_moves_into_the_menu(window, qapp):
    """A window of 1440 px has space for the key caps; with more views, a wider one is needed."""
    header = window.header
    settle(qapp, window, (1280, 720))
    width = 1440
    settle(qapp, window, (width, 900))
    while not header.pause.cap.isVisible():
        width += 20
        settle(qapp, window, (width, 900))
    assert not header.tabs.more.isVisible()
    window.actions_by_key.run("session.pause")
    settle(qapp, window, (width, 900))
    assert not header.tabs.more.isVisible()
    law = header.tabs.addTab("Law")
    settle(qapp, window, (width, 900))
    assert not header.pause.cap.isVisible()
    assert not header.tabs.more.isVisible()
    header.tabs.removeTab(law)
    window.actions_by_key.run("session.pause")
    settle(qapp, window, (width, 900))
    assert header.pause.cap.isVisible()


def test_the_menu_of_views_fits_beside_the_longest_tab(window, qapp):
    """At 1280 × 800 with a scale of 2, only the longest tab and the menu fit."""
    tabs = window.header.tabs
    window.views.show("accuracy")
    settle(qapp, window, (640, 400))
    shown = [index for index in range(tabs.count()) if tabs.isTabVisible(index)]
    assert shown == [tabs.currentIndex()]
    assert tabs.rect().contains(tabs.more.geometry())
    window.views.show("live")


def test_a_pages_side_column_shrinks_like_the_panel(window, qapp):
    for size in ((1440, 900), (1280, 720)):
        settle(qapp, window, size)
        width = window.panel.width()
        box = window.panel.parameters.rows["stiffness"].box.width()
        window.views.show("stability")
        side = window.views.page("stability").side
        assert side.width() == width
        assert side.rows.rows["stiffness"].box.width() == box
        window.views.show("live")
        assert window.panel.width() == width


@pytest.mark.parametrize(
    ("size", "grown"),
    [((1280, 720), 1.0), ((1600, 1200), 1.0), ((1919, 1080), 1.1), ((1920, 1080), 1.2), ((2560, 1440), 1.6),
     ((3440, 1440), 1.6), ((9000, 9000), 2.5)],
)  # fmt: skip
def test_above_1600_by_900_everything_grows_with_the_window(size, grown):
    assert breakpoints.scale(*size) == grown


@pytest.mark.slow
@pytest.mark.parametrize("key", ["wall", "cat"])
def test_scene_text_and_plots_grow_together_in_a_large_window(window, qapp, key):
    window.studio.choose(key)

    def sizes():
        centre = window.centre
        stage, box = centre.scene._layout(), next(iter(window.panel.parameters.rows.values())).box
        drawn = 100.0 * stage.per_mm, stage.height, stage.u, stage.font(12.0, 500)[0].pixelSize()
        plots = centre.time.canvases[0].left.width(), centre.phase.width(), centre.time.height()
        labels = window.panel.title.title, centre.time.headers[0].value, box, window.header.tabs
        parts = window.panel, box, window.header.stop, window.gallery, window.header
        type_sizes = [QFontInfo(part.font()).pixelSize() for part in labels]
        return [*drawn, *plots, *type_sizes, *(part.width() for part in parts), window.header.height()]

    resize(qapp, window, (1600, 900))
    usual = sizes()
    for size in ((1920, 1080), (2560, 1440)):
        resize(qapp, window, size)
        for grown, before in zip(sizes(), usual, strict=True):
            assert grown / before == pytest.approx(size[0] / 1600, rel=0.08)  # font sizes are whole pixels


def drag(qtbot, splitter, by):
    """Drag a splitter's handle by a number of pixels."""
    handle = splitter.handle(1)
    at = handle.rect().center()
    qtbot.mousePress(handle, Qt.MouseButton.LeftButton, pos=at)
    qtbot.mouseMove(handle, at + by)
    qtbot.mouseRelease(handle, Qt.MouseButton.LeftButton, pos=at + by)


@pytest.mark.slow
def test_dragged_splitters_keep_their_position_and_are_restored(make_window, qapp, qtbot):
    def sizes(window):
        centre = window.centre
        return window.gallery.width(), window.panel.width(), centre.scene.height(), centre.phase.width()

    first = make_window(size=(1920, 1080))
    drag(qtbot, first.body.borders, QPoint(-60, 0))
    drag(qtbot, first.centre.rows, QPoint(0, 40))
    drag(qtbot, first.centre.columns, QPoint(-50, 0))
    dragged = sizes(first)
    assert abs(dragged[1] - (1.2 * 300 + 60)) <= 3
    resize(qapp, first, (1600, 1000))
    resize(qapp, first, (1920, 1080))
    assert sizes(first) == dragged
    first.close()
    again = make_window(size=(1920, 1080))
    assert sizes(again) == dragged


def test_every_menu_fits_below_the_menu_bar_on_a_screen_of_720_px(window, qapp):
    settle(qapp, window, (1280, 720))
    for menu in window.menuBar().findChildren(QMenu):
        menu.aboutToShow.emit()
        menu.ensurePolished()
        menu.sizeHint()
        high = sum(menu.actionGeometry(action).height() for action in menu.actions() if action.isVisible())
        assert high <= 720 - 40 - window.menuBar().height() - 10, (menu.title(), high)


def test_every_control_has_a_name_and_a_minimum_size(window, qapp):
    settle(qapp, window, (1280, 720))
    for button in window.findChildren(QAbstractButton):
        if button.isVisible() and button.focusPolicy():
            name = button.accessibleName() or button.text()
            assert name, button
            assert min(button.width(), button.height()) >= 24, name


SCALED = """
import sys
from PySide6.QtWidgets import QApplication
app = QApplication([])
from hapkit_studio.gui.widgets import style
from hapkit_studio.gui.shell.actions import new_window
from hapkit_studio.gui.state.studio import Studio
from tests.gui.shell.test_layout import cut_off, overlapping, resize, settle
from tests.gui.window_support import SIMULATED, build_engine
style.apply(app)
window = new_window(Studio(lambda: [SIMULATED], build_engine))
window.show()
found = []
for key in ("wall", "friction", "mass_spring_damper", "hard_surface"):
    window.studio.choose(key)
    settle(app, window, (1280, 720))
    found += cut_off(window) + overlapping(window)
    resize(app, window, (960, 540))
    found += cut_off(window) + overlapping(window)
print(window.devicePixelRatioF(), found)
window.close()
sys.exit(bool(found))
"""


@pytest.mark.slow
@pytest.mark.parametrize("scale", ["1.25", "1.5", "2"])
def test_nothing_is_cut_off_on_a_scaled_screen(scale):
    environment = os.environ | {"QT_SCALE_FACTOR": scale, "QT_QPA_PLATFORM": "offscreen"}
    done = subprocess.run(
        [sys.executable, "-c", SCALED],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith(str(float(scale)))


def test_tab_moves_the_focus_through_header_gallery_scene_and_panel(window):
    window.studio.choose("spring")
    window.studio.choose("wall")
    chain, widget = [], window.header
    while widget not in chain:
        chain.append(widget)
        widget = widget.nextInFocusChain()
    rows = window.panel.parameters.rows
    stops = [
        window.header.devices, window.header.stop, window.gallery.rows["wall"], window.centre.scene,
        window.centre.toolbar.span, window.panel.title.help, *rows["stiffness"].tab_stops(),
        *rows["damping_mode"].tab_stops(), window.loop.rate.box, window.loop.grip.picker,
    ]  # fmt: skip
    places = [chain.index(stop) for stop in stops]
    assert places == sorted(places)


@pytest.mark.slow
def test_parts_are_placed_immediately_after_a_resize(window, qapp):
    settle(qapp, window, (1280, 720))
    for width, height in ((1440, 900), (1280, 720), (1920, 1080)):
        window.resize(width, height)
        parts = [place(part, window) for part in (window.gallery, window.centre, window.panel)]
        grown = breakpoints.scale(width, height)
        assert parts[0].width() in [int(grown * usual) for usual in (64, 228)]
        assert parts[2].width() in [int(grown * usual) for usual in (272, 300)]
        assert parts[0].left() == 0
        assert parts[1].left() == parts[0].right() + 2  # the border is 1 px wide
        assert parts[2].left() == parts[1].right() + 2
        assert parts[2].right() + 1 == width


def asked(key, setting, stiffness):
    environment = environments.named(key)
    return CardRequest(VerdictInput(environment, environment.values({"stiffness": stiffness}), setting), 8.0)


@pytest.mark.slow
def test_a_longer_verdict_shrinks_no_row_and_the_map_is_visible_for_every_environment(window, qapp):
    settle(qapp, window, (1440, 900))
    card, body = window.stability, window.panel.upper.widget()
    short, long, mapped = (
        answer(asked("wall", LoopSettings(delay=1e-3, hand="medium"), k)) for k in (250.0, 4000.0, 100.0)
    )
    for found in (short, long, short):
        card.show_answer(found)
        assert body.height() >= body.layout().totalHeightForWidth(body.width())
        assert card.height() >= card.heightForWidth(card.width())
    for size, keys in (
        ((1440, 900), ("wall", "friction", "texture", "mass_spring_damper")),
        ((1920, 1080), ("hard_surface", "puck", "cat")),
    ):
        for key in keys:
            window.studio.choose(key)
            resize(qapp, window, size)
            card.show_answer(mapped)
            assert place(card.map, window).bottom() < place(window.panel, window).bottom(), key


@pytest.mark.parametrize("size", [(1280, 720), (1440, 900)])
def test_a_stable_walls_verdict_needs_two_lines_for_each_hand(window, qapp, size):
    settle(qapp, window, size)
    shown = [line.label for line in window.stability.verdict.lines if line.isVisible()]
    heights = [label.heightForWidth(label.width()) / label.heightForWidth(10_000) for label in shown]
    assert heights == [2, 2], [label.text() for label in shown]


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1280, 720), (1440, 900)])
def test_the_buttons_above_the_plots_show_their_text(window, qapp, size):
    resize(qapp, window, size)
    bar = window.centre.toolbar
    assert all(button.text() for button in (bar.cursors, bar.keep, bar.release, bar.fit))
