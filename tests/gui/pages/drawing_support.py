"""Support for tests of drawings: draw at once, point, click and drag in the units of the axes."""

from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest


def drawn(drawing):
    """Draw at once if necessary; return the axes."""
    if drawing._old or drawing._ground is None:
        drawing.redraw()
        drawing.canvas.draw()
    return drawing.figure.axes


def spot(drawing, x, y, axes=0) -> QPoint:
    """Return the pixel position of a point on the canvas."""
    ratio = drawing.canvas.device_pixel_ratio
    across, up = drawn(drawing)[axes].transData.transform((x, y)) / ratio
    return QPoint(round(across), round(drawing.canvas.height() - up))


def point(drawing, x, y, axes=0):
    """Move the pointer to a point from a nearby position."""
    place = spot(drawing, x, y, axes)
    QTest.mouseMove(drawing.canvas, place + QPoint(3, 3))
    QTest.mouseMove(drawing.canvas, place)


def leave(drawing):
    """Move the pointer out of the axes."""
    QTest.mouseMove(drawing.canvas, QPoint(1, 1))


def click(drawing, x, y, button=Qt.MouseButton.LeftButton, axes=0):
    """Click a point."""
    QTest.mouseClick(drawing.canvas, button, pos=spot(drawing, x, y, axes))


def texts(drawing) -> list[str]:
    """Return all drawn texts, including legends and ticks."""
    from matplotlib.text import Text

    drawn(drawing)
    return [text.get_text() for text in drawing.figure.findobj(Text) if text.get_visible()]


def outside(drawing) -> list[str]:
    """Return the axes and texts that extend beyond the figure."""
    from matplotlib.text import Text

    drawn(drawing)
    frame = drawing.figure.bbox.padded(1.0)
    ticks = {label for axes in drawing.figure.axes for axis in (axes.xaxis, axes.yaxis)
             for label in axis.findobj(Text)}  # fmt: skip
    texts = [
        t for t in drawing.figure.findobj(Text) if t.get_text().strip() and t not in ticks and not hidden(t)
    ]
    boxes = [(t.get_text(), t.get_window_extent()) for t in texts]
    boxes += [(f"axes {i}", axes.get_tightbbox()) for i, axes in enumerate(drawing.figure.axes)]
    return [name for name, box in boxes if not _inside(frame, box)]


def hidden(text) -> bool:
    """Return whether a text belongs to a hidden legend."""
    legends = [axes.get_legend() for axes in text.figure.axes]
    return any(legend and not legend.get_visible() and text in legend.get_texts() for legend in legends)


def _inside(frame, box) -> bool:
    return frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1
