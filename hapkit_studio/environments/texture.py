"""Texture: bands of damping, a force grating, or sandpaper, each with a wavelength."""

import math
from collections.abc import Iterable

import numpy as np

from hapkit_studio.environments.base import Conditions, Environment, Values, no_terms
from hapkit_studio.formatting import compact, with_unit
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter

KINDS = ("bands", "grating", "sandpaper")
BANDS, GRATING = 0, 1
# largest slope of 16 u² (1 − u)², at u = (1 − 1/√3) / 2
STEEPEST = 16.0 * math.sqrt(3.0) / 9.0
# Period of the sandpaper in half wavelengths. It is a prime, so that cubes of smaller integers are distinct
# modulo this number. It is small enough to be exact in single precision, so that the board renders the same
# grains.
GRAINS = 251


def centred(n):
    """Return an integer modulo the number of grains, from -125 to 125, robust against rounding errors."""
    return n - GRAINS * math.floor(n * (1.0 / GRAINS) + 0.5)


def grain(n, seed):
    """Return the height, 0 to 1, of grain n: each of 251 heights occurs once, in a pseudo-random order."""
    m = centred(n + 17.0 * seed)
    m = centred(centred(m * m * m) + seed + 1.0)
    m = centred(m * m * m)
    return (m if m >= 0.0 else m + GRAINS) / (GRAINS - 1.0)


@law(state={"cell": 0.5, "seed": 0.0, "rise": 0.0})
def force(p, s, x, v, dt):
    u = x / p.wavelength
    if p.kind == "grating":
        return p.amplitude * math.sin(math.tau * u)
    if p.kind == "bands":
        return -p.damping * v if u - math.floor(u) < 0.5 else 0.0
    # the force of sandpaper is the scaled negative slope of its heights; at the start of a cell a grain is
    # chosen
    u, seed = 2.0 * u, math.floor(p.seed)
    n = math.floor(u)
    if n != s.cell or seed != s.seed:
        s.cell, s.seed, s.rise = n, seed, grain(n + 1.0, seed) - grain(n, seed)
    u -= n
    bend = u * (1.0 - u)
    return -16.0 * p.amplitude * s.rise * bend * bend


def impedance(values: Values) -> tuple[float, float]:
    """Return the steepest slope of the ridges, or the damping of the bands."""
    if values["kind"] == BANDS:
        return 0.0, values["damping"]
    factor = math.tau if values["kind"] == GRATING else 2.0 * STEEPEST
    return factor * values["amplitude"] / values["wavelength"], 0.0


def unused(values: Values) -> dict[str, str]:
    """Return the parameters that belong to other kinds of texture."""
    kind = int(values["kind"])
    keys = (("amplitude", "seed"), ("damping", "seed"), ("damping",))[kind]
    return {key: f'Not used by the texture "{KINDS[kind]}"' for key in keys}


def warnings(values: Values, conditions: Conditions) -> Iterable[str]:
    """Warn if ridges pass too fast or are too fine to be sampled."""
    wavelength, period = values["wavelength"], conditions.period
    fastest = wavelength / (10.0 * period)
    if conditions.speed > fastest:
        yield (
            f"Above {compact(fastest, 3)} m/s the loop takes fewer than 10 samples for each ridge; "
            f"the handle moved at {compact(conditions.speed, 3)} m/s."
        )
    finest = 10.0 * conditions.quantum
    if wavelength < finest:
        ridges, counts = with_unit(1e3 * wavelength, "mm"), with_unit(1e3 * finest, "mm")
        yield (
            f"A wavelength of {ridges} is too short for the sensor: it must be at least {counts} (10 sensor "
            "steps)."
        )


def over_position(values: Values, x: np.ndarray) -> np.ndarray:
    """Return the force (n,) in N of ridges; NaN for bands, whose force depends on the speed."""
    if values["kind"] == BANDS:
        return np.full(len(x), np.nan)
    return ENVIRONMENT.curve(values, x)


def over_velocity(values: Values, v: np.ndarray) -> np.ndarray:
    """Return the forces (2, n) in N inside bands and between bands; NaN for ridges."""
    if values["kind"] == BANDS:
        return np.array([-values["damping"] * v, 0.0 * v])
    return np.full((2, len(v)), np.nan)


ENVIRONMENT = Environment(
    key="texture",
    title="Texture",
    summary="Ridges under the finger",
    parameters=(
        Choice(
            "kind",
            "Kind",
            KINDS,
            "grating",
            "Bands: damping acts in every second stripe. Grating: equal ridges, whose force is a regular "
            "wave. Sandpaper: the grains are random.",
        ),
        Parameter(
            "damping", "Damping", "N·s/m", 8.0, 0.0, 50.0, "Force for each m/s of speed inside a band", "b"
        ),
        Parameter("amplitude", "Amplitude", "N", 0.25, 0.0, 2.0, "Largest force of a ridge or grain", "A"),
        Parameter(
            "wavelength", "Wavelength", "m", 0.005, 0.0005, 0.02, "Distance from one ridge to the next", "λ"
        ),
        Parameter(
            "seed",
            "Grain pattern",
            "",
            1.0,
            0.0,
            99.0,
            "Number of the pattern of grains: each whole number gives a different piece of sandpaper",
            whole=True,
        ),
    ),
    force=force,
    shortcut="7",
    formula="<i>F</i> = −<i>b v</i>, <i>A</i> sin(2π<i>x</i>/<i>λ</i>) or −d<i>h</i>/d<i>x</i>",
    symbols="bands: <i>b</i> damping, <i>v</i> velocity; grating: <i>A</i> amplitude, <i>x</i> position, "
    "<i>λ</i> wavelength; sandpaper: <i>h</i> height of the grains",
    explanation="Ridges make the handle vibrate, and a finger feels this as roughness. At a speed v and "
    "a wavelength λ you cross v/λ ridges per second. Each ridge needs at least ten samples of the "
    "loop and ten steps of the sensor. The force of a high and narrow ridge is as steep as that of "
    "a stiff spring, so above some amplitude the handle buzzes by itself.",
    impedance=impedance,
    terms=no_terms,
    unused=unused,
    warnings=warnings,
    over_position=over_position,
    over_velocity=over_velocity,
    hands=("sweep", "released"),
    needs=("mass", "viscous", "coulomb", "quantization", "sampling", "delay"),
    order=7,
)
