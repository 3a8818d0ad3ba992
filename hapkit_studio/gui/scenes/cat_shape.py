"""The cat's outline: where its back, its head and the pad on them are, in shares of the stage's height."""

from functools import cache

import numpy as np

from hapkit_studio.gui.scenes.cat_mood import Mood
from hapkit_studio.gui.scenes.stage import Stage

HEAD = -38.5, 0.62  # mm along the rail, share of the height: the middle of the face
_KNOTS = np.array([-40.0, -33.0, -29.0, -24.0, -18.0, -10.0, 0.0, 10.0, 18.0, 26.0, 32.0, 36.5])  # mm
_HEIGHTS = np.array([0.36, 0.55, 0.66, 0.735, 0.78, 0.78, 0.755, 0.76, 0.785, 0.755, 0.60, 0.33])
_DIP, _DIP_WIDTH = 0.055, 3.6  # share, mm: fur pressed down by the pad
BACK = np.linspace(-40.0, 36.5, 81)  # mm
_SCALE = np.linspace(-60.0, 60.0, 1201)  # mm
_HEAD_TOP, _HEAD_WIDTH = 0.90, 7.2  # share, mm: what a pad on the head goes over


@cache
def _curve() -> np.ndarray:
    """Return the back's height over _SCALE: cubics through the knots, sloped as their neighbours lie."""
    x = _SCALE
    slopes = np.gradient(_HEIGHTS, _KNOTS)
    i = np.clip(np.searchsorted(_KNOTS, x) - 1, 0, _KNOTS.size - 2)
    width = _KNOTS[i + 1] - _KNOTS[i]
    t = np.clip((x - _KNOTS[i]) / width, 0.0, 1.0)
    y = (1 + 2 * t) * (1 - t) ** 2 * _HEIGHTS[i] + t * (1 - t) ** 2 * width * slopes[i]
    return y + t * t * (3 - 2 * t) * _HEIGHTS[i + 1] + t * t * (t - 1) * width * slopes[i + 1]


def back(mm: np.ndarray | float) -> np.ndarray:
    """Return the resting back's height at places in mm."""
    return np.interp(mm, _SCALE, _curve())


def top(mm: np.ndarray | float, mood: Mood, pad: float) -> np.ndarray:
    """Return the back's height at places in mm: it breathes, and gives way under a pad at pad mm."""
    return back(mm) * mood.chest - _DIP * np.exp(-(((mm - pad) / _DIP_WIDTH) ** 2))


def pad_height(mm: float, mood: Mood) -> float:
    """Return the height that a pad rests at: on the back, over the head, down where the cat ends."""
    body = float(top(mm, mood, mm))
    if mm > _KNOTS[-1]:
        body *= float(np.exp(-(((mm - _KNOTS[-1]) / 4.0) ** 2)))
    head = _HEAD_TOP * float(np.exp(-(((mm - HEAD[0]) / _HEAD_WIDTH) ** 4)))
    if mm < _KNOTS[0]:
        body *= float(np.exp(-(((mm - _KNOTS[0]) / 4.0) ** 2)))
    return max(body, head)


def y(stage: Stage, share: float) -> float:
    """Return the row in px of a share of the cat's height."""
    return stage.rail - 2.0 * stage.u - share * stage.band


def scale(stage: Stage) -> float:
    """Return the px of one unit of head, paw or hair: as the stage is high, but never too wide for it."""
    return min(stage.band / 78.0, 0.4 * stage.per_mm)
