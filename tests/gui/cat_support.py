"""A scene that shows the cat, in any state, and what its pictures are searched by."""

import itertools

import numpy as np
from PySide6.QtCore import QRect

from hapkit_studio.environments import discover
from hapkit_studio.gui.scenes import SceneView, cat_body
from hapkit_studio.gui.scenes.stage import Stage

CAT = discover()["cat"]
SIZES = [(880, 236), (640, 150), (880, 272), (1100, 330), (560, 272)]
MOODS = {
    "at rest": {},
    "content": {"contentment": 0.2},
    "purring": {"contentment": 0.6},
    "annoyed": {"contentment": -0.6},
    "swat": {"contentment": -0.55, "swat": 0.15, "push": 1.0},
    "sulking": {"contentment": -0.4, "sulk": 3.0},
}


def state(position=0.0, bend=0.0, **given):
    """Return a row's state: bend in m is how far the hand has bent the hair."""
    known = {"anchor": position - bend, "push": 1.0, "started": 1.0} | given
    values = np.zeros(16)
    for name, value in known.items():
        values[CAT.state_names.index(name)] = value
    return values


def cat_view() -> SceneView:
    """Return a scene that shows the cat at its defaults."""
    view = SceneView()
    view.resize(880, 236)
    view.set_environment(CAT, CAT.values())
    view._hint = False
    view.show()
    return view


def show(view, position=0.0, force=0.0, hand=None, bend=0.0, **given):
    view._words.invalidate()
    view.update_state(position, force, force, hand, False, False, state(position, bend, **given))
    return view.grab().toImage()


def box(view, left, right, low, high):
    """Return the pixels from left to right mm and low to high share of the cat's height."""
    stage = Stage(view.width(), view.height())
    top, bottom = cat_body.y(stage, high), cat_body.y(stage, low)
    return QRect(int(stage.x(left)), int(top), int(stage.x(right) - stage.x(left)), int(bottom - top))


def count(image, area, wanted):
    """Return how many pixels of an area have a colour."""
    places = itertools.product(range(area.left(), area.right()), range(area.top(), area.bottom()))
    return sum(image.pixelColor(x, y) == wanted for x, y in places)
