"""A step that is too long for its integrator: each method's limit of ω dt at six damping ratios."""

from functools import partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.failures import base
from hapkit_studio.analysis.failures.plane import Boundary, Field, Panel, Plane
from hapkit_studio.dynamics.integrator_stability import longest_step, spectral_radius
from hapkit_studio.dynamics.integrators import INTEGRATORS, integrate
from hapkit_studio.environments.pushed import LABELS
from hapkit_studio.formatting import with_unit


def growth_per_radian(method: str, ratio: float, step: float) -> float:
    """Return the growth of the largest root per radian ω t, for a damping ratio and a step ω dt."""
    return float(np.log(spectral_radius(method, step, ratio)) / step)


METHODS = ("explicit_euler", "lecture", "semi_implicit", "verlet", "rk4")
METHOD = base.Choice(
    "method",
    "Integrator",
    METHODS,
    "semi_implicit",
    labels=tuple(LABELS[INTEGRATORS.index(m)] for m in METHODS),
)
RATIOS = (0.01, 0.05, 0.2, 0.5, 1.0, 2.0)
# a mass of 1 kg at 10 rad/s, released at 10 mm
OMEGA, START = 10.0, 0.01
STEPS = 200_000
# amplitude relative to the start; a motion below DEAD has died out, one above LOST has diverged
DEAD, LOST = 1e-9, 1e9
_SHARES = np.r_[0.5:0.95:10j, 0.98, 0.99, 1.0, 1.01, 1.02, 1.05:1.5:10j]


def method_of(case: base.Case) -> str:
    """Return the method of a case."""
    return METHODS[int(case["method"])]


def _ratio(case: base.Case) -> float:
    return RATIOS[int(case["ratio"])]


def _growth(method: str, step: float, case: base.Case) -> float:
    return OMEGA * growth_per_radian(method, _ratio(case), step)


def limit(case: base.Case) -> float:
    """Return the largest ω dt at which the oscillation does not grow."""
    return longest_step(method_of(case), 1.0, 2.0 * _ratio(case), 1.0)


def probe(step: float, case: base.Case) -> base.Evidence:
    """Release the mass, and simulate it until the motion has diverged or died out."""
    damping, dt = 2.0 * _ratio(case) * OMEGA, step / OMEGA
    with np.errstate(over="ignore", invalid="ignore"):
        _, x, v = integrate(
            method_of(case), mass=1.0, damping=damping, stiffness=OMEGA**2, x0=START, v0=0.0, dt=dt,
            seconds=STEPS * dt,
        )  # fmt: skip
        size = np.hypot(x, v / OMEGA)
    size = size[: base.alive(size[: base.before_lost(size, LOST * START)], DEAD * START)]
    shown = base.alive(size[: base.before_lost(size, 30.0 * START)], 1e-3 * START)
    true = f"; the true motion decays at {with_unit(-_growth('exact', 1.0, case), '1/s')}"
    return base.growth_evidence(1e3 * x[:shown], dt, base.growth(size, dt), more=true)


def live(step: float, case: base.Case) -> base.Live:
    """Return the live settings of the mass, with the case's integrator and damping ratio, at a step ω dt."""
    # largest frequency of the mass in the window for this damping ratio
    omega = 200.0 / max(_ratio(case), 1.0)
    values = {"mass": 0.05, "stiffness": 0.05 * omega**2, "damping": 0.1 * _ratio(case) * omega}
    values = base.within("mass_spring_damper", values)
    values |= {"integrator": float(INTEGRATORS.index(method_of(case))), "contact_stiffness": 100.0}
    rate = base.live_rate(base.short(omega / step, omega / limit(case)))
    holds = omega / rate < limit(case)
    what = "comes to rest" if holds else "oscillates more and more, becomes unstable and starts again"
    slow = " The loop in the window cannot run slower than 100 Hz." if omega / rate < 0.999 * step else ""
    advice = f"Drag to 30 mm against the mass, then back to −30 mm. The mass {what}.{slow}"
    return base.Live("mass_spring_damper", values, {"rate": rate}, advice=advice)


# for the chart of stability regions: axis ranges, grid points per axis, spectral radii drawn as lines
_STEPS, _PLANE_RATIOS, _GRID, _LEVELS = (0.01, 4.0), (0.003, 3.0), 161, (0.5, 0.9, 0.99)


def swing_points(rate: float = 1000.0) -> list[tuple[float, float, str]]:
    """Return ω dt, damping ratio and title of every object in contact, at the default values of its scene."""
    found = []
    for environment in environments.discover().values():
        if environment.moves and environment.moves.swing:
            mass, damping, stiffness = environment.moves.swing(environment.values())
            omega = (stiffness / mass) ** 0.5
            # undamped objects are drawn at the edge of the chart
            ratio = max(damping / (2.0 * mass * omega), _PLANE_RATIOS[0])
            found.append((omega / rate, ratio, environment.title))
    return found


def plane(case: base.Case) -> Plane:
    """Return the stability regions of all integrators over step and damping ratio, from closed forms."""
    steps, ratios = np.geomspace(*_STEPS, _GRID), np.geomspace(*_PLANE_RATIOS, _GRID)
    panels = []
    for method, name in zip(INTEGRATORS, LABELS, strict=True):
        radius = spectral_radius(method, steps, ratios[:, np.newaxis])
        field = Field(steps, ratios, np.where(radius > 1.0, 3.0, radius), _LEVELS)
        longest = np.array([longest_step(method, 1.0, 2.0 * ratio, 1.0) for ratio in ratios])
        limits = (Boundary("longest stable step", longest, ratios),) if np.isfinite(longest).all() else ()
        panels.append(Panel(field, name, limits, marks=tuple(swing_points())))
    return Plane(
        "Green: the motion decays. Number at a line: growth factor of the amplitude per step. Stars: the "
        "scenes at 1,000 Hz",
        "ω dt: angle of the oscillation in one step",
        "damping ratio ζ",
        tuple(panels),
        partial(_place, ratio=_ratio(case)),
        own=INTEGRATORS.index(method_of(case)),
    )


def _place(step: float, ratio: float) -> tuple[float, float]:
    return step, ratio


FAILURE = base.Failure(
    key="integrators",
    title="A time step too long for the integrator",
    summary="Above a certain step size the computed motion of a mass on a spring gains energy in every "
    "oscillation",
    formula="Stable if ω dt < 2 ζ (explicit Euler), 2(√(1 + ζ²) − ζ) (semi-implicit), 2 (Verlet) or 2.83 "
    "(RK4 at ζ = 0), with frequency ω, step dt and damping ratio ζ",
    explanation="An integrator replaces the motion within a step by an approximation, and its error adds "
    "or removes energy. The result depends on the angle ω dt by which the oscillation advances in one "
    "step, and on the damping ratio ζ. Explicit Euler and the lecture's rule add energy in every step, "
    "so only enough damping keeps them stable. The other methods are stable up to about two radians a step.",
    knob=base.Parameter(
        "step",
        "Step",
        "",
        1.0,
        1e-3,
        10.0,
        "Phase in radians by which the oscillation advances in one step",
        "ω·dt",
    ),
    limit=limit,
    probe=probe,
    plot=base.Plot(
        "ω·dt",
        _SHARES,
        (
            base.Curve("theory", lambda step, case: _growth(method_of(case), step, case), base.THEORY),
            base.Curve("simulation"),
            base.Curve("true motion", lambda step, case: _growth("exact", 1.0, case), base.OTHER),
        ),
        "limit",
    ),
    options=(METHOD, base.Choice("ratio", "Damping ratio", tuple(f"{r:g}" for r in RATIOS), "0.2")),
    live=live,
    plane=plane,
    order=2,
)
