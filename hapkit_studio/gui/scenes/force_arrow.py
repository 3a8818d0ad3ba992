"""The force arrow beside the knob, with a number at its tip."""

import numpy as np
from PySide6.QtCore import QElapsedTimer, QRectF
from PySide6.QtGui import QPen

from hapkit_studio.gui.scenes.base import RING, Motion, apart, knob, ring_alone, ring_place
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import number, theme

LEAST_ARROW = 16.0
_DECIMALS = 2  # decimals of a force in N
HEAD, HEAD_HALF, SHAFT_HALF = 12.0, 8.0, 2.6
EACH_MS = 100
_SEEN = 0.02, 0.1  # N, mm: a shown number that differs by more than this from the drawing is updated at once


def direction(force: float) -> int:
    """Return the sign of a force; 0 if the force is displayed as zero."""
    return int(np.sign(round(force, _DECIMALS)))


def force(stage: Stage, motion: Motion, per_newton: float) -> None:
    """Draw the force as an arrow from the knob with a number at its tip.

    A bar shows that the force is clamped.
    """
    u, y, x = stage.u, stage.knob_middle, stage.x(motion.position)
    base, half = y + 4.8 * u, stage.knob_width / 2
    stage.occupied.append(knob(stage, motion.position).adjusted(-2, 0, 2, 0))
    d = direction(motion.force)
    if motion.stopped or d == 0:
        places = [(x - half - 13 * u, base, -1), (x + half + 13 * u, base, 1)]
        text = "0.00 N" if motion.stopped else motion.force_text
        stage.write(text, places, "applied", 13, 700, must=True, wipe=True)
        return
    start, tip = _arrow_ends(stage, motion, per_newton)
    _arrow(stage, start, tip, y, d)
    if motion.hand is not None and apart(stage, motion):
        ring = ring_place(stage, motion.hand)
        if 0.0 < d * (ring - start) < d * (tip - start) - (HEAD + RING) * u:
            ring_alone(stage, ring)  # draw the hand's ring over the arrow's shaft, but not over its head
    if motion.clamped:
        stage.line(tip + d * 5 * u, y - 11 * u, tip + d * 5 * u, y + 11 * u, stage.pen("applied", 3.2))
        tip += d * 7 * u
    stage.occupied.append(QRectF(min(start, tip), y - 9 * u, abs(tip - start), 18 * u))
    places = [
        (tip + d * 7 * u, base, d),
        (x - d * (half + 10 * u), base, -d),
        (x - d * (half + 26 * u), base, -d),
    ]
    if motion.hand is not None:
        places.append((ring_place(stage, motion.hand) - d * 15 * u, base, -d))
    stage.write(motion.force_text, places, "applied", 13, 700, must=True, wipe=True)


def _arrow_ends(stage: Stage, motion: Motion, per_newton: float) -> tuple[float, float]:
    """Return the pixel columns of the arrow's start and tip; near the edge the arrow overlaps the knob."""
    u, d, x = stage.u, direction(motion.force), stage.x(motion.position)
    start = stage.knob_width / 2 + 7 * u
    room = (stage.width - x if d > 0 else x) - (16 if motion.clamped else 6) * u
    tip = min(start + max(LEAST_ARROW, abs(motion.force) * per_newton) * u, room)
    return x + d * min(start, tip - LEAST_ARROW * u), x + d * tip


def _arrow(stage: Stage, start: float, tip: float, y: float, d: int) -> None:
    u = stage.u
    neck = tip - d * HEAD * u
    above = [(start, -SHAFT_HALF), (neck, -SHAFT_HALF), (neck, -HEAD_HALF)]
    outline = [*above, (tip, 0.0), *((a, -b) for a, b in reversed(above))]
    stage.use(QPen(theme.color("scene"), 1.2 * u), "applied")
    stage.polygon((a, y + b * u) for a, b in outline)


def force_label(newtons: float) -> str:
    """Format a force for the arrow's tip."""
    return f"{number(newtons, _DECIMALS, sign=True)} N"


class ReadOut:
    """Updates the shown numbers ten times per second, and at once if the drawing would contradict them."""

    def __init__(self) -> None:
        self._clock = QElapsedTimer()
        self._force = 0.0

    def invalidate(self) -> None:
        """Request an update of all numbers at the next refresh."""
        self._clock.invalidate()

    def refresh(self, motion: Motion) -> bool:
        """Copy the drawn row into the shown numbers if an update is due; return whether it was due."""
        due = not self._clock.isValid() or self._clock.elapsed() >= EACH_MS or self._contradicts(motion)
        if due:
            self._clock.start()
            self._force, motion.position_text = motion.force, motion.position
            motion.force_text = force_label(motion.force)
        return due

    def _contradicts(self, motion: Motion) -> bool:
        apart = abs(motion.force - self._force), abs(motion.position - motion.position_text)
        turned = direction(motion.force) != direction(self._force)
        return turned or apart[0] > _SEEN[0] or apart[1] > _SEEN[1]
