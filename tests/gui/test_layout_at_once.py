"""No frame shows parts that overlap; and the whole panel is in sight where there is room."""

import pytest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.gui import breakpoints
from hapkit_studio.gui.panel.limits import Question, answer
from tests.gui.test_layout import place, settle


def test_parts_stand_side_by_side_as_soon_as_the_window_has_another_size(window, qapp):
    settle(qapp, window, (1280, 720))
    for width, height in ((1440, 900), (1280, 720), (1920, 1080)):
        window.resize(width, height)
        parts = [place(part, window) for part in (window.gallery, window.centre, window.panel)]
        assert parts[0].width() in (breakpoints.RAIL, breakpoints.GALLERY)
        assert parts[2].width() in (breakpoints.PANEL, breakpoints.PANEL_NARROW)
        assert parts[0].left() == 0
        assert parts[1].left() == parts[0].right() + 2  # a border of 1 px
        assert parts[2].left() == parts[1].right() + 2
        assert parts[2].right() + 1 == width


def test_a_longer_verdict_squeezes_no_row(window, qapp):
    settle(qapp, window, (1440, 900))
    card, body = window.stability, window.panel.widget()
    for stiffness in (250.0, 4000.0, 250.0):
        card.show_answer(answer(Question(Setting(delay=1e-3, controller=True), stiffness, 0.0, 8.0)))
        assert body.height() >= body.layout().totalHeightForWidth(body.width())
        assert card.height() >= card.heightForWidth(card.width())


@pytest.mark.parametrize(
    ("size", "keys"),
    [
        ((1440, 900), ("wall", "friction", "texture", "mass_spring_damper")),
        ((1920, 1080), ("hard_surface", "puck", "cat")),
    ],
)
def test_the_map_is_in_sight_for_every_environment(window, qapp, size, keys):
    for key in keys:
        window.studio.choose(key)
        window.stability.show_answer(answer(Question(Setting(delay=1e-3), 100.0, 0.0, 8.0)))
        settle(qapp, window, size)
        assert window.stability.map.isVisible()
        assert window.panel.verticalScrollBar().maximum() == 0, key
