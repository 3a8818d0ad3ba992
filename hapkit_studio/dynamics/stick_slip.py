"""Stick-slip for all friction models: a spring with a moving end pulls a mass with dry friction.

The step of a model maps the velocity v in m/s to the next one. The applied force is known, as in a
simulation. ``memory`` contains the anchor, the bristle deflection and the last position in m, and the
direction of sliding, which is 0 while sticking. Options are numbers in the order of the model's parameters.
"""

import math

import numpy as np

from hapkit_studio.dynamics.friction import bristle, projected, sticking_tether, stribeck
from hapkit_studio.dynamics.integrators import HUGE, TINY, checked, instants
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Parameter, resolve

COULOMB, SMOOTHED, KARNOPP, KARNOPP_BAND, STRIBECK = range(5)
PROJECTION, TETHER, LUGRE, DAHL, HAYWARD_ARMSTRONG = range(5, 10)
MEMORY = 4
_ANCHOR, _BEND, _BEFORE, _SLIDES = range(MEMORY)


@internal
def _bristles(v, memory, level, stiffness, damping, dt):
    """Return the friction in N of bristles with stiffness and damping."""
    before = memory[_BEND]
    memory[_BEND] = bristle(before, v * dt, level, stiffness)
    return stiffness * memory[_BEND] + damping * (memory[_BEND] - before) / dt


@internal
def _hayward_armstrong(x, memory, static, kinetic, stiffness):
    """Return the friction in N of an anchor whose creep increases with its strain."""
    reach, strain = kinetic / stiffness, x - memory[_ANCHOR]
    share = (strain * stiffness) ** 8
    creep = share / (static**8 + share) / reach if share > 0.0 else 0.0
    if creep * abs(strain) > 1.0:
        memory[_ANCHOR] = x - math.copysign(reach, strain)
    else:
        memory[_ANCHOR] += abs(x - memory[_BEFORE]) * creep * strain
    return stiffness * (x - memory[_ANCHOR])


@internal
def _strained(model, x, v, memory, static, kinetic, options, dt):
    """Return the friction in N of the models with an elastic strain, for positive motion."""
    if model == TETHER:
        drag, memory[_ANCHOR], memory[_SLIDES] = sticking_tether(
            x, memory[_BEFORE], memory[_ANCHOR], memory[_SLIDES], options[0], options[1], static, kinetic, dt
        )
        return -drag
    if model == LUGRE:
        return _bristles(v, memory, stribeck(v, static, kinetic, options[2]), options[0], options[1], dt)
    if model == DAHL:
        return _bristles(v, memory, kinetic, options[0], 0.0, dt)
    if model == HAYWARD_ARMSTRONG:
        return _hayward_armstrong(x, memory, static, kinetic, options[0])
    return stribeck(v, static, kinetic, options[1]) * math.tanh(v / options[0])


@internal
def _next(model, x, v, pull, memory, mass, static, kinetic, options, dt):
    """Return the velocity after a step."""
    step = dt / mass
    slid = v + step * (pull - math.copysign(kinetic, v))
    # the mass rests, or breaks away against the kinetic friction
    stuck = 0.0 if abs(pull) <= static else v + step * (pull - math.copysign(kinetic, pull))
    if model == COULOMB:  # this model uses only the sign of the velocity
        return slid if v != 0.0 else step * (pull - math.copysign(min(abs(pull), static), pull))
    if model == KARNOPP:  # a state machine, which sticks when the velocity would change its sign
        if v == 0.0:
            return stuck
        return slid if slid * v > 0.0 else 0.0
    if model == KARNOPP_BAND:
        return slid if abs(v) >= options[0] else stuck
    if model == STRIBECK:
        return projected(v + step * pull, stribeck(v, static, kinetic, options[0]) * step)
    if model == PROJECTION:
        rests = v == 0.0 and abs(pull) <= static
        return 0.0 if rests else projected(v + step * pull, kinetic * step)
    friction = _strained(model, x, v, memory, static, kinetic, options, dt)
    memory[_BEFORE] = x
    return v + step * (pull - friction)


@compiled
def run(model, times, applied, mass, spring, viscous, static, kinetic, options, dt, memory, x, v):
    """Compute x, v (n,) from their first values by the semi-implicit rule.

    The computation is repeated ``times`` times, to measure its speed.
    m x'' = applied - spring x - viscous v - friction. The new velocity moves the mass.
    """
    for _ in range(times):
        memory[_ANCHOR], memory[_BEND], memory[_BEFORE], memory[_SLIDES] = x[0], 0.0, x[0], 0.0
        for n in range(x.size - 1):
            pull = applied[n] - spring * x[n] - viscous * v[n]
            v[n + 1] = _next(model, x[n], v[n], pull, memory, mass, static, kinetic, options, dt)
            x[n + 1] = x[n] + dt * v[n + 1]


_UNITS = {"stiffness": "N/m", "damping": "N·s/m"}


def _options(**defaults: float) -> tuple[Parameter, ...]:
    """Return a model's options besides its friction levels; options that are not in _UNITS are speeds."""
    found = []
    for key, default in defaults.items():
        label, low = key.replace("_", " ").capitalize(), 0.0 if key == "damping" else TINY
        found.append(Parameter(key, label, _UNITS.get(key, "m/s"), default, low, HUGE))
    return tuple(found)


# the options are in the order of a step's arguments
MODELS: dict[str, tuple[int, tuple[Parameter, ...]]] = {
    "coulomb": (COULOMB, ()),
    "smoothed": (SMOOTHED, _options(smoothing=0.01, stribeck_velocity=0.03)),
    "karnopp": (KARNOPP, ()),
    "karnopp_band": (KARNOPP_BAND, _options(band=0.005)),
    "stribeck": (STRIBECK, _options(stribeck_velocity=0.02)),
    "projection": (PROJECTION, ()),
    "tether": (TETHER, _options(stiffness=2e4, damping=20.0)),
    "lugre": (LUGRE, _options(stiffness=1e4, damping=45.0, stribeck_velocity=0.005)),
    "dahl": (DAHL, _options(stiffness=1e4)),
    "hayward_armstrong": (HAYWARD_ARMSTRONG, _options(stiffness=5e3)),
}


def slide(
    model: str,
    applied: np.ndarray,
    *,
    mass: float,
    static: float,
    kinetic: float,
    viscous: float = 0.0,
    spring: float = 0.0,
    x0: float = 0.0,
    v0: float = 0.0,
    dt: float = 1e-3,
    **options: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (t, x, v), each (n,), of a mass with friction and a fixed spring under forces (n,) in N.

    Row k is at t = k dt, and row 0 is the start. ``applied[k]`` acts from row k to the next row. Models and
    their options are in MODELS. Raise ParameterError for an invalid argument.
    """
    if not isinstance(model, str) or model not in MODELS:
        raise ParameterError(f"The friction model must be one of {', '.join(MODELS)}, not {model!r}.")
    code, declared = MODELS[model]
    levels = {"mass": mass, "spring": spring, "viscous": viscous, "static": static, "kinetic": kinetic}
    number = checked(levels | {"x0": x0, "v0": v0, "dt": dt})
    if number["static"] < number["kinetic"]:
        raise ParameterError(
            f"Static friction is at least the kinetic one: {number['kinetic']:g} N or more, "
            f"not {number['static']:g} N."
        )
    chosen = np.array([*resolve(declared, options, f"The friction model {model}"), 0.0])
    try:
        forces = np.ascontiguousarray(applied, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError("The applied forces must be numbers in N.") from None
    if forces.ndim != 1 or not np.isfinite(forces).all():
        raise ParameterError("The applied forces must be one row of finite numbers in N.")
    x, v = np.full(forces.size, number["x0"]), np.full(forces.size, number["v0"])
    if forces.size:
        run(code, 1, forces, *(number[key] for key in levels), chosen, number["dt"], np.zeros(MEMORY), x, v)
    return np.arange(forces.size) * number["dt"], x, v


def stick_slip(
    model: str,
    *,
    mass: float,
    spring: float,
    static: float,
    kinetic: float,
    viscous: float = 0.0,
    speed: float,
    dt: float,
    seconds: float,
    **options: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return (t, x, v, force), each (n,), of a mass at rest that an initially slack spring pulls.

    ``speed`` is that of the spring's end in m/s. ``force`` is that of the spring on the mass in N. ``mass``
    is in kg, ``spring`` in N/m, ``static`` and ``kinetic`` friction in N, ``viscous`` in N·s/m, ``dt`` and
    ``seconds`` in s. Row k is at t = k dt; n = round(seconds / dt) + 1. Models and their options are in
    MODELS. Raise ParameterError for an invalid argument.
    """
    number = checked({"spring": spring, "speed": speed, "dt": dt, "seconds": seconds})
    drawn = number["spring"] * number["speed"] * instants(number["seconds"], number["dt"])
    levels = {"mass": mass, "spring": spring, "static": static, "kinetic": kinetic, "viscous": viscous}
    t, x, v = slide(model, drawn, **levels, dt=dt, **options)
    return t, x, v, drawn - number["spring"] * x


# N: smallest force amplitude that counts as stick-slip; number of ignored first cycles
_SMALLEST_AMPLITUDE, _IGNORED_CYCLES = 0.05, 2


def exact_period(mass: float, spring: float, static: float, kinetic: float, speed: float) -> float:
    """Return the exact period in s without viscous friction: 2 dF / (k V) + 2 (pi - atan lambda) / omega."""
    drop, omega = static - kinetic, math.sqrt(spring / mass)
    slope = drop / (speed * math.sqrt(spring * mass))
    return 2.0 * drop / (spring * speed) + 2.0 * (math.pi - math.atan(slope)) / omega


def period_error(t: np.ndarray, force: np.ndarray, period: float) -> float:
    """Return the relative error of the mean time between downward crossings of the force's middle value.

    ``force`` has the shape (n,). Return inf if there are no crossings.
    """
    late = force[len(force) // 4 :]
    if not np.isfinite(force).all() or np.ptp(late) < _SMALLEST_AMPLITUDE:
        return math.inf
    middle = 0.5 * (late.max() + late.min())
    falls = np.flatnonzero((force[:-1] >= middle) & (force[1:] < middle))[_IGNORED_CYCLES:]
    if len(falls) < 2:
        return math.inf
    share = (force[falls] - middle) / (force[falls] - force[falls + 1])
    times = t[falls] + share * (t[falls + 1] - t[falls])
    return abs(float(times[-1] - times[0]) / (len(times) - 1) / period - 1.0)
