"""A mass on a rubbing surface, drawn by a spring whose end moves: friction models show what they are."""

import numpy as np

from hapkit_studio.dynamics import sliding
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Parameter, resolve

_HUGE = 1e12
_TINY = 1e-12
_MOST_STEPS = 100_000_000

_NUMBERS = {
    p.key: p
    for p in (
        Parameter("mass", "Mass", "kg", 1.0, _TINY, _HUGE),
        Parameter("spring", "Spring", "N/m", 0.0, 0.0, _HUGE),
        Parameter("static", "Static friction", "N", 0.0, 0.0, _HUGE),
        Parameter("kinetic", "Kinetic friction", "N", 0.0, 0.0, _HUGE),
        Parameter("viscous", "Viscous friction", "N·s/m", 0.0, 0.0, _HUGE),
        Parameter("speed", "Speed", "m/s", 0.0, -_HUGE, _HUGE),
        Parameter("dt", "dt", "s", 1e-3, 1e-9, 1e3),
        Parameter("seconds", "Seconds", "s", 1.0, 0.0, 1e9),
        Parameter("x0", "x0", "m", 0.0, -_HUGE, _HUGE),
        Parameter("v0", "v0", "m/s", 0.0, -_HUGE, _HUGE),
    )
}


def _speed(key: str, label: str, default: float) -> Parameter:
    return Parameter(key, label, "m/s", default, _TINY, _HUGE)


def _stiffness(default: float) -> Parameter:
    return Parameter("stiffness", "Stiffness", "N/m", default, _TINY, _HUGE)


def _damping(default: float) -> Parameter:
    return Parameter("damping", "Damping", "N·s/m", default, 0.0, _HUGE)


# What each model takes besides its levels, in the order of ``sliding``.
MODELS: dict[str, tuple[int, tuple[Parameter, ...]]] = {
    "coulomb": (sliding.COULOMB, ()),
    "smoothed": (
        sliding.SMOOTHED,
        (
            _speed("smoothing", "Smoothing", 0.01),
            _speed("stribeck_velocity", "Stribeck velocity", 0.03),
        ),
    ),
    "karnopp": (sliding.KARNOPP, ()),
    "karnopp_band": (sliding.KARNOPP_BAND, (_speed("band", "Band", 0.005),)),
    "stribeck": (sliding.STRIBECK, (_speed("stribeck_velocity", "Stribeck velocity", 0.02),)),
    "projection": (sliding.PROJECTION, ()),
    "tether": (sliding.TETHER, (_stiffness(2e4), _damping(20.0))),
    "lugre": (
        sliding.LUGRE,
        (_stiffness(1e4), _damping(45.0), _speed("stribeck_velocity", "Stribeck velocity", 0.005)),
    ),
    "dahl": (sliding.DAHL, (_stiffness(1e4),)),
    "hayward_armstrong": (sliding.HAYWARD_ARMSTRONG, (_stiffness(5e3),)),
}


def _checked(model: object, given: dict[str, object], options: dict[str, object]):
    """Return (code, numbers by name, options in order); raise ParameterError."""
    if not isinstance(model, str) or model not in MODELS:
        raise ParameterError(f"The friction model is one of {', '.join(MODELS)}, not {model!r}.")
    code, declared = MODELS[model]
    number = {key: _NUMBERS[key].check(value) for key, value in given.items()}
    if number["static"] < number["kinetic"]:
        raise ParameterError(
            f"Static friction is at least the kinetic one: {number['kinetic']:g} N or more, "
            f"not {number['static']:g} N."
        )
    chosen = resolve(declared, options, f"The friction model {model}")
    return code, number, np.array([*chosen, 0.0])


def slide(
    model, applied, *, mass, static, kinetic, viscous=0.0, spring=0.0, x0=0.0, v0=0.0, dt=1e-3, **options
):
    """Return (t, x, v), each (n,), of a mass under applied forces (n,) in N, a fixed spring and friction.

    Row k is at t = k dt, row 0 the start; applied[k] acts from there to the next row. Models and their
    options are in MODELS. Raise ParameterError.
    """
    given = {"mass": mass, "static": static, "kinetic": kinetic, "viscous": viscous, "spring": spring}
    code, number, chosen = _checked(model, given | {"x0": x0, "v0": v0, "dt": dt}, options)
    try:
        forces = np.ascontiguousarray(applied, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError("The applied forces must be numbers of N; they are not.") from None
    if forces.ndim != 1 or not np.isfinite(forces).all():
        raise ParameterError("The applied forces must be one row of finite numbers of N.")
    x, v = np.full(forces.size, number["x0"]), np.full(forces.size, number["v0"])
    levels = [number[key] for key in ("mass", "spring", "viscous", "static", "kinetic")]
    if forces.size:
        sliding.run(code, forces, *levels, chosen, number["dt"], np.zeros(sliding.MEMORY), x, v)
    return np.arange(forces.size) * number["dt"], x, v


def stick_slip(
    model, *, mass, spring, static, kinetic, viscous=0.0, speed, dt, seconds, **options
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return (t, x, v, force), each (n,): a resting mass drawn by a spring, slack at first, at `speed` m/s.

    force is the spring's on the mass in N. mass kg, spring N/m, static and kinetic friction N, viscous
    N·s/m, dt and seconds s; row k is at t = k dt, n = round(seconds / dt) + 1. Models and their options are
    in MODELS. Raise ParameterError.
    """
    given = {"mass": mass, "static": static, "kinetic": kinetic, "viscous": viscous, "spring": spring}
    _, number, _ = _checked(model, given | {"speed": speed, "dt": dt, "seconds": seconds}, options)
    count = round(number["seconds"] / number["dt"]) + 1
    if count > _MOST_STEPS:
        raise ParameterError(f"A motion has up to {_MOST_STEPS:g} steps, not {seconds:g} s by {dt:g} s.")
    drawn = number["spring"] * number["speed"] * number["dt"] * np.arange(count)
    t, x, v = slide(model, drawn, **given, dt=dt, **options)
    return t, x, v, drawn - number["spring"] * x
