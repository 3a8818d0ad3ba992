"""Helpers that show a scene in a given state of the law and return its pixels as arrays."""

import numpy as np
import pytest
from PySide6.QtGui import QColor, QImage

from hapkit_studio.environments import discover
from hapkit_studio.gui.scenes import SceneView
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.parameters import Choice

LIBRARY = discover()
SIZES = ((500, 150), (880, 236), (1100, 330))
each_size = pytest.mark.parametrize("size", [SIZES[0], pytest.param(SIZES[-1], marks=pytest.mark.slow)])


def scene_of(qtbot, key, size=(880, 236), given=None):
    """Return an environment's scene without the first-drag hint, and a stage of the same geometry."""
    view = SceneView()
    qtbot.addWidget(view)
    view.resize(*size)
    view._hint = False
    view.set_environment(LIBRARY[key], LIBRARY[key].values(given or {}))
    view.show()
    return view, Stage(*size, widest=view._scene.widest)


def state_of(key, **numbers):
    """Return a law's state (n,), zero except for the named numbers."""
    state = np.zeros(len(LIBRARY[key].state_names))
    for name, number in numbers.items():
        state[LIBRARY[key].state_names.index(name)] = number
    return state


def paint(view, position, state=(), applied=0.0, hand=None, stopped=False):
    """Paint the view with the handle at a position in m and return the picture."""
    view._read_out.invalidate()
    view.update_state(position, applied, applied, hand, False, stopped, np.asarray(state, dtype=float))
    return view.grab()


def shot(view, *row, **given):
    """Paint the view and return its colours (height, width, 3)."""
    image = paint(view, *row, **given).toImage().convertToFormat(QImage.Format.Format_RGB32)
    flat = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), image.width(), 4)
    return flat[:, :, 2::-1].astype(np.int32)


def has(picture, token, near=24):
    """Return a mask (height, width) of the pixels with a token's colour, without blended edges."""
    color = QColor(theme.tokens[token])
    parts = zip((0, 1, 2), (color.red(), color.green(), color.blue()), strict=True)
    red, green, blue = (np.abs(picture[:, :, part] - wanted) <= near for part, wanted in parts)
    return red & green & blue


def corners(environment):
    """Return sets of values: the defaults, one parameter at a limit or option, all parameters at limits."""
    ends = {
        p.key: [float(i) for i in range(len(p.options))] if isinstance(p, Choice) else [p.low, p.high]
        for p in environment.parameters
    }
    alone = [{key: value} for key, values in ends.items() for value in values]
    together = [{key: values[end] for key, values in ends.items()} for end in (0, -1)]
    every = [environment.values() | given for given in ({}, *alone, *together)]
    return [values for values in every if not environment.check(values)]
