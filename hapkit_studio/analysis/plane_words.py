"""What is written beside a plane: the conditions it holds for, and what its lines mean."""

from hapkit_studio.analysis.plane import Plane
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.dynamics.estimators import parse

_SHORT = {"iir": "IIR", "butterworth": "Butterworth", "foaw": "FOAW", "kalman": "Kalman"}
# Key: name and one line that explains it.
LINES = {
    "exact": ("Exact boundary", "roots of the sampled loop"),
    "measured": ("Measured boundary", "simulated and bisected"),
    "simple": ("Simple rule", "K < (b + B) / (T/2 + td)"),
    "passive": ("Passivity line", "safe in any hand"),
    "coulomb": ("Friction hides steps", "below K = 2 f / Δ"),
    "decays": ("Comes to rest", "let go 3 and 200 steps away"),
    "buzzes": ("Buzzes", "stays in motion, does not grow"),
    "grows": ("Grows", "let go, it moves ever farther"),
}
# Above the exact boundary by more than this share somewhere, the rule promises too much.
_HOPEFUL = 0.05


def estimator_words(setting: Setting) -> str:
    """Name the velocity estimator and its first option: "IIR, 35.5 Hz"."""
    method, options = parse(setting.estimator)
    name = _SHORT.get(method.key, "difference")
    for parameter in method.parameters:
        return f"{name}, {options[parameter.key]:g} {parameter.unit}".rstrip()
    return name


def conditions(setting: Setting, real: bool = False) -> list[tuple[str, str]]:
    """Return what the limits hold for, as pairs of a name and its value; real: friction and steps as well."""
    stiction = [
        ("Dry friction", f"{setting.coulomb:g} N"),
        ("Sensor step", f"{1e6 * setting.quantum:.3g} µm"),
    ]
    pairs = [
        ("Mass", f"{setting.mass:g} kg"),
        ("Viscous damping", f"{setting.viscous:g} N·s/m"),
        *(stiction if real else []),
        ("Rate", f"{setting.rate:,g} Hz"),
        ("Delay", f"{1e3 * setting.delay:.2f} ms"),
        ("Velocity filter", estimator_words(setting)),
        ("Hand", setting.hand if setting.hand == "released" else f"{setting.hand} grip"),
    ]
    return [*pairs, ("Controller", "on")] if setting.controller else pairs


def line(plane: Plane, key: str) -> tuple[str, str]:
    """Return a line's name and what it means, as they are for this plane."""
    name, words = LINES[key]
    if key == "simple" and hopeful(plane):
        return f"{name}, hopeful here", words
    if key == "measured" and plane.points is not None:
        words += ", with friction" if plane.points.real else ""
        name += ", controlled" if plane.points.controller else ""
    return name, words


def hopeful(plane: Plane) -> bool:
    """Say whether the simple rule promises more than the loop keeps, where it can be seen."""
    low = plane.exact < (1.0 - _HOPEFUL) * plane.simple
    return bool((low & (plane.exact < plane.top)).any())
