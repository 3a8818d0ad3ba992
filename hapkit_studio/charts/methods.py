"""How each method is drawn, in every chart the same: a marker and a colour's name, never colour alone.

Markers: star, diamond, square, pentagon, circle, down, plus, up, cross. Colours are tokens of the palette.
"""

from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.stick_slip import MODELS

_OTHERS = (
    ("circle", "velocity"),
    ("square", "position"),
    ("diamond", "asked"),
    ("pentagon", "energy"),
    ("star", "ink"),
    ("down", "hold"),
    ("plus", "lecture"),
    ("up", "applied"),
    ("cross", "ok"),
    ("circle", "danger"),
)
_INTEGRATORS = {
    "explicit_euler": ("up", "applied"),
    "lecture": ("plus", "lecture"),
    "semi_implicit": ("circle", "velocity"),
    "verlet": ("square", "position"),
    "rk4": ("diamond", "asked"),
    "implicit_euler": ("down", "hold"),
    "trapezoid": ("pentagon", "energy"),
    "exact": ("star", "ink"),
}
_SERVO = {"prompt": ("circle", "velocity"), "late": ("down", "hold")}


def look(method: str) -> tuple[str, str]:
    """Return the marker and the colour's token of a method."""
    if method in _INTEGRATORS | _SERVO:
        return (_INTEGRATORS | _SERVO)[method]
    for family in (tuple(ESTIMATORS), tuple(MODELS)):
        if method in family:
            return _OTHERS[family.index(method) % len(_OTHERS)]
    return _OTHERS[0]
