"""A page's own side: no name of a section stands over nothing."""

from PySide6.QtWidgets import QLabel

from hapkit_studio.gui.pages.base import Pairs, SidePanel


def test_a_section_of_pairs_is_named_while_there_are_pairs(qtbot):
    side, pairs = SidePanel("Title"), Pairs()
    qtbot.addWidget(side)
    pairs.stand_under(side.section("Conditions"))
    side.add(pairs)
    side.show()
    heading = next(label for label in side.findChildren(QLabel) if label.text() == "Conditions")
    for shown in ([], [("Rate", "1 kHz")], []):
        pairs.show_pairs(shown)
        assert heading.isVisible() == bool(shown)


def test_nothing_measured_has_no_conditions(idle_window):
    idle_window.views.show("zwidth")
    side = idle_window.views.page("zwidth").side
    seen = [label.text() for label in side.findChildren(QLabel) if label.isVisible()]
    assert "Read the chart" in seen
    assert "Conditions" not in seen
