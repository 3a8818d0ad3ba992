"""The past in the force–position plot stays in sight while axes widen."""

import numpy as np
import pytest
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QImage, QPainter

from hapkit_studio.gui.live.phase_layers import Layers, Place
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import settle, telemetry

SIZE = 200
FRAME = QRectF(0.0, 0.0, SIZE, SIZE)


def place(reach):
    """Return a frame of 200 × 200 px that shows ±reach both ways, at its middle (0, 0)."""
    return Place(FRAME, SIZE / 2, SIZE / 2 / reach, SIZE / 2, -SIZE / 2 / reach)


def levels(where, seconds=5):
    """Return a curve to and fro across the frame's middle, in its second k at the height k."""
    time = np.arange(0.0, seconds, 0.01)
    across = np.where(time % 2.0 < 1.0, 1.0, -1.0) * (2.0 * (time % 1.0) - 1.0)
    line = [where.left + where.across * across, where.bottom + where.up * np.floor(time)]
    return time, np.array(line)


def rows_seen(layers, where, ratio=1.0):
    """Return at which heights in px something is painted in the frame's middle column."""
    image = QImage(round(SIZE * ratio), round(SIZE * ratio), QImage.Format.Format_RGB32)
    image.setDevicePixelRatio(ratio)
    image.fill(QColor("white"))
    painter = QPainter(image)
    layers.paint_old(painter, where)
    layers.paint_newest(painter, where)
    painter.end()
    column = round(SIZE * ratio / 2)
    dark = np.array([image.pixelColor(column, y).lightness() < 250 for y in range(image.height())])
    edges = np.flatnonzero(np.diff(dark.astype(int), prepend=0, append=0)).reshape(-1, 2)
    return sorted(float(a + b) / 2 / ratio for a, b in edges)


@pytest.mark.parametrize("ratio", [1.0, 1.5])
def test_every_second_lies_where_its_points_are_at_once_and_after(ratio):
    layers, narrow, wide = Layers(), place(6.0), place(12.0)
    nothing = np.empty(0), np.empty((2, 0))
    layers.begin(narrow, ratio, QColor("black"), *levels(narrow))
    for _ in range(6):
        layers.add(*nothing)
    for reach in (8.0, 12.0):
        wide = place(reach)
        layers.begin(wide, ratio, QColor("black"), *levels(wide))
        wanted = sorted(100.0 - 100.0 / reach * k for k in range(5))
        for _ in range(3):
            np.testing.assert_allclose(rows_seen(layers, wide, ratio), wanted, atol=1.1)
            layers.add(*nothing)
    for _ in range(6):
        layers.add(*nothing)
    np.testing.assert_allclose(rows_seen(layers, wide, ratio), wanted, atol=0.6)


def test_what_is_older_than_ten_seconds_goes_although_the_axes_widen():
    layers, where = Layers(), place(15.0)
    layers.begin(where, 1.0, QColor("black"), *levels(where))
    for _ in range(6):
        layers.add(np.empty(0), np.empty((2, 0)))
    assert len(rows_seen(layers, where)) == 5
    later = np.array([13.5, 13.6]), np.array([[90.0, 110.0], [150.0, 150.0]])
    layers.begin(place(16.0), 1.0, QColor("black"), *later)
    assert len(rows_seen(layers, place(16.0))) == 3


def test_a_widening_axis_hides_nothing_of_the_past(phase, history, qapp):
    """A push ever harder, every frame wider: the wall's way in of seconds ago is there in every frame."""
    settle(phase)
    push = telemetry(4000, 14_000)
    push[:, rows.POSITION] = 0.0
    push[:, rows.APPLIED] = np.linspace(0.0, 12.0, 4000)
    widenings = 0
    for part in range(0, 4000, 100):
        history.append(push[part : part + 100])
        before = phase.canvas.view.viewRange()
        phase.canvas.refresh()
        widenings += phase.canvas.view.viewRange() != before
        image = phase.canvas.viewport().grab().toImage()
        x, force = 11.0, -0.4 * 6.0
        place = phase.canvas.pixel(x, force)
        near = [
            image.pixelColor(round(place.x()) + a, round(place.y()) + b) for a in (-1, 0) for b in (-1, 0, 1)
        ]
        assert min(color.lightness() for color in near) < 170
    assert widenings > 5
