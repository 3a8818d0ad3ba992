"""How each method is drawn, in every chart the same: a marker and a colour's name, never colour alone.

Markers are matplotlib's, colours tokens of the palette.
"""

from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.stick_slip import MODELS

_OTHERS = (
    ("o", "velocity"),
    ("s", "position"),
    ("D", "asked"),
    ("p", "energy"),
    ("*", "ink"),
    ("v", "hold"),
    ("P", "lecture"),
    ("^", "applied"),
    ("X", "ok"),
    ("o", "danger"),
)
_INTEGRATORS = {
    "explicit_euler": ("^", "applied"),
    "lecture": ("P", "lecture"),
    "semi_implicit": ("o", "velocity"),
    "verlet": ("s", "position"),
    "rk4": ("D", "asked"),
    "implicit_euler": ("v", "hold"),
    "trapezoid": ("p", "energy"),
    "exact": ("*", "ink"),
}
_SERVO = {"prompt": ("o", "velocity"), "late": ("v", "hold")}


def look(method: str) -> tuple[str, str]:
    """Return the marker and the colour's token of a method."""
    if method in _INTEGRATORS | _SERVO:
        return (_INTEGRATORS | _SERVO)[method]
    for family in (tuple(ESTIMATORS), tuple(MODELS)):
        if method in family:
            return _OTHERS[family.index(method) % len(_OTHERS)]
    return _OTHERS[0]
