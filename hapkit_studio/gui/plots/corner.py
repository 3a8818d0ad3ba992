"""The corner of a frame in which words cover the least of what is drawn."""

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF

_MARGIN = 6.0
"""px that words keep from the frame."""


def freest(box: QRectF, size: QSizeF, across: np.ndarray, down: np.ndarray) -> QRectF:
    """Return where words of a size in px stand: in the corner with the fewest points (n,) in px."""
    left, top = box.left() + _MARGIN, box.top() + _MARGIN
    right = max(box.right() - _MARGIN - size.width(), left)
    bottom = box.bottom() - _MARGIN - size.height()
    corners = [QRectF(QPointF(x, y), size) for y in (top, bottom) for x in (right, left)]
    return min(corners, key=lambda corner: _inside(corner, across, down))


def _inside(corner: QRectF, across: np.ndarray, down: np.ndarray) -> int:
    near = corner.adjusted(-_MARGIN, -_MARGIN, _MARGIN, _MARGIN)
    beside = (near.left() <= across) & (across <= near.right())
    return int(np.count_nonzero(beside & (near.top() <= down) & (down <= near.bottom())))
