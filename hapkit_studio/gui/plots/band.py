"""The theory beneath the data: a band with kerbs, and the ranges in which it has something to show."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainter, QPen, QPolygonF

from hapkit_studio.gui.theme import theme

_FAR = 1e4  # px
_LEAST_FORCE = 0.5  # N
_OVER_LIMIT = 1.35  # of the force limit: what lies beyond is not worth showing
_MARGIN = 0.12
_BENT = 1e-6  # of the force's span: a bend smaller than this is rounding
_TURNS = 5  # to each side: the end of a well at the centre, then two wells more
_BEYOND = 1.1  # a bend wants to be inside the frame, not on it

Mapping = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Band:
    """The law's force in N, one row a branch (m, n), over x (n,) in the plot's unit; NaN: no curve there."""

    x: np.ndarray
    force: np.ndarray

    def forces(self, reach: float, max_force: float) -> tuple[float, float]:
        """Return the forces in N to show within ±reach, with a margin, under a force limit in N."""
        seen = self.force[:, np.abs(self.x) <= reach]
        seen = seen[np.isfinite(seen)]
        low, high = seen.min(initial=-_LEAST_FORCE), seen.max(initial=_LEAST_FORCE)
        most = _OVER_LIMIT * max_force
        low, high = max(low, -most), min(high, most)
        margin = _MARGIN * (high - low)
        return low - margin, high + margin

    def reach(self, least: float, most: float, max_force: float) -> float:
        """Return how far to each side, least to most, the plot opens, rounded up to quarters of the least.

        Up to the last bend that the motor can render, or, where the curve goes up and down, a few turns.
        """
        sides = [(side, row) for row in self.force for side in (1.0, -1.0)]
        far = max((self._last(row, side, most, max_force) for side, row in sides), default=0.0)
        part = least / 4.0
        return min(max(math.ceil(_BEYOND * far / part - 1e-9) * part, least), most)

    def _last(self, row: np.ndarray, side: float, most: float, max_force: float) -> float:
        """Return how far out one branch is of interest to one side; 0 where it is straight."""
        out = np.argsort(side * self.x)
        out = out[(side * self.x[out] >= 0.0) & (side * self.x[out] <= most)]
        distance, force = np.abs(self.x[out]), row[out]
        least = _BENT * np.fmax.reduce(np.abs(force), initial=0.0)
        rise = np.diff(force)
        rise[np.abs(rise) <= least] = 0.0
        shown = np.abs(force) < _OVER_LIMIT * max_force
        bent = np.abs(np.diff(rise)) > least
        bends = np.flatnonzero(bent & shown[:-2] & shown[2:]) + 1
        if not len(bends):
            return 0.0
        going = np.flatnonzero(np.nan_to_num(rise))
        turns = going[1:][rise[going[1:]] * rise[going[:-1]] < 0.0][:_TURNS]
        last = min(bends[-1], turns[-1]) if len(turns) == _TURNS else bends[-1]
        return float(distance[last])

    def paint(self, painter: QPainter, to_pixels: Mapping) -> None:
        """Paint the kerbs of all branches, then the band."""
        lines = [line for force in self.force for line in self._unbroken(force, to_pixels)]
        for token, width in (("edge", 8.8), ("theory", 6.4)):
            painter.setPen(QPen(theme.color(token), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
            for line in lines:
                painter.drawPolyline(line)

    def _unbroken(self, force: np.ndarray, to_pixels: Mapping) -> list[QPolygonF]:
        """Return a branch as lines in pixels, cut where it has no value."""
        across, up = to_pixels(self.x, force)
        cuts = np.flatnonzero(np.diff(np.isfinite(force))) + 1
        pieces = zip(np.split(across, cuts), np.split(np.clip(up, -_FAR, _FAR), cuts), strict=True)
        return [QPolygonF(list(map(QPointF, a, b))) for a, b in pieces if np.isfinite(b[0])]
