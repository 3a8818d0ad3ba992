"""What takes its time says how far it is: the bench counts, the verdict's box shows."""

import math

import numpy as np

from hapkit_studio.gui.wizard.position_plot import PositionPlot
from hapkit_studio.gui.wizard.rail import Rail
from hapkit_studio.gui.wizard.verdict_box import LONG, VerdictBox


def test_a_long_run_shows_its_bar_and_a_short_or_endless_one_does_not(qtbot):
    """In the margin below the words: what stands above the box stays where it is."""
    box = VerdictBox()
    qtbot.addWidget(box)
    box.resize(400, 60)
    box.show()
    box.say("Sweeping. Hands off…")
    qtbot.wait(10)
    low, hint = box.minimumHeight(), box.sizeHint()
    box.show_progress(3.0, 12.0)
    assert box.bar.isVisible()
    assert box.bar.value() == 0.25 * box.bar.maximum()
    assert box.minimumHeight() == low
    assert box.sizeHint() == hint
    assert box.rect().contains(box.bar.geometry())
    assert box.bar.geometry().top() > box.words.geometry().bottom()
    box.say("Found.", "Next: hang 50 g on it.", "check", "ok")
    qtbot.wait(10)
    assert box.minimumHeight() == low
    assert box.bar.geometry().top() > box.remedy.geometry().bottom()
    for passed, seconds in ((1.0, 0.9 * LONG), (20.0, math.inf), (0.0, 0.0)):
        box.show_progress(passed, seconds)
        assert not box.bar.isVisible()
        assert box.minimumHeight() == low


def test_the_sweeps_limits_lie_about_its_start(qtbot):
    plot = PositionPlot()
    qtbot.addWidget(plot)
    plot.show_positions(np.array([0.0, 1.0]), np.array([0.007, 0.008]))
    assert plot.start == 0.008
    plot.show_positions(np.array([0.0, 1.0]), np.array([0.008, 0.020]))
    assert plot.start == 0.008
    plot.begin_here()
    assert plot.start == 0.020


def test_the_button_that_lets_a_hand_go_never_covers_the_hand(qtbot):
    rail = Rail()
    qtbot.addWidget(rail)
    rail.show_hand(True)
    for width in (rail.minimumWidth(), 812):
        rail.resize(width, rail.minimumHeight())
        for place in np.linspace(-0.055, 0.055, 23):
            rail.lead(float(place))
            ring, button = rail.hand_place().toAlignedRect(), rail.let_go.geometry()
            assert rail.rect().contains(button)
            assert not button.intersects(ring)
