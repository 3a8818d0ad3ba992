"""Hard surface: a wall with a short vibration at every entry, as if something solid were tapped.

The vibration is a decaying sinusoid scaled by the speed of entry (Okamura, Cutkosky, Dennerlein 2001).
"""

import math
from collections.abc import Iterable

from hapkit_studio.dynamics import nominal
from hapkit_studio.environments.base import Conditions, Environment, ForceTerms, Values
from hapkit_studio.formatting import with_unit
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter

# m: the handle must retract this far before the next tap; at rest it jitters by one sensor count, 20.7 µm
LEFT = 2.0 * nominal.QUANTUM
# the vibration ends when it has decayed to exp(-30)
OVER = 30.0
MATERIALS = ("custom", "rubber", "wood", "aluminium")
RUBBER, WOOD, ALUMINIUM = 1, 2, 3
# Amplitudes in N per m/s: the ratios of acceleration to speed in the paper, 116.7, 150 and 300 1/s, times the
# mass of 0.044 kg.
RUBBER_A, RUBBER_DECAY, RUBBER_HZ = 5.1, 60.0, 18.0
WOOD_A, WOOD_DECAY, WOOD_HZ = 6.6, 80.0, 100.0
ALUMINIUM_A, ALUMINIUM_DECAY, ALUMINIUM_HZ = 13.2, 90.0, 300.0


def sound(material, amplitude, decay, hertz):
    """Return (amplitude N per m/s, decay 1/s, frequency Hz) of a material; for custom, the given values."""
    if material == RUBBER:
        return RUBBER_A, RUBBER_DECAY, RUBBER_HZ
    if material == WOOD:
        return WOOD_A, WOOD_DECAY, WOOD_HZ
    if material == ALUMINIUM:
        return ALUMINIUM_A, ALUMINIUM_DECAY, ALUMINIUM_HZ
    return amplitude, decay, hertz


def ringing(since, amplitude, decay, hertz):
    """Return the vibration per speed of entry in N per m/s, ``since`` s after the entry."""
    return amplitude * math.exp(-decay * since) * math.sin(math.tau * hertz * since)


def ringing_steps(decay, hertz, dt):
    """Return the coefficients (first, kept, drawn) of a recursion for ``ringing``, with an amplitude of 1.

    The first difference is ``first``. Each following difference is ``kept`` times the previous one minus
    ``drawn`` times the value in between.
    """
    shrinks, angle = math.exp(-decay * dt), math.tau * hertz * dt
    kept = shrinks * shrinks
    return shrinks * math.sin(angle), kept, 1.0 + kept - 2.0 * shrinks * math.cos(angle)


@law(state={"since": -1.0, "speed": 0.0, "ring": 0.0, "rise": 0.0})
def force(p, s, x, v, dt):
    """Render the wall and the vibration ``ringing``, which is computed recursively."""
    depth, pull = x - p.position, 0.0
    if depth > 0.0:
        pull = -p.stiffness * depth
        if p.damping > 0.0 and v > 0.0:
            pull -= p.damping * v
    elif depth <= -LEFT:
        s.since = -1.0
        return 0.0
    amplitude, decay, hertz = sound(p.material, p.amplitude, p.decay, p.frequency)
    first, kept, drawn = ringing_steps(decay, hertz, dt)
    if s.since < 0.0:
        if depth > 0.0:
            s.since, s.speed, s.ring = 0.0, max(v, 0.0), 0.0
            s.rise = amplitude * first * s.speed
        return pull
    if s.since > OVER / decay:
        return pull
    s.since += dt
    s.ring += s.rise
    s.rise = kept * s.rise - drawn * s.ring
    return pull - min(max(s.ring, -p.limit), p.limit)


def unused(values: Values) -> dict[str, str]:
    """Return the parameters that the chosen material sets itself."""
    if not values["material"]:
        return {}
    name = MATERIALS[int(values["material"])].capitalize()
    amplitude, decay, hertz = sound(values["material"], 0.0, 0.0, 0.0)
    return {
        "amplitude": f"The material {name} sets the ringing strength to {amplitude:g} N·s/m",
        "decay": f"The material {name} sets the ringing decay to {decay:g} 1/s",
        "frequency": f"The material {name} sets the ringing frequency to {hertz:g} Hz",
    }


def warnings(values: Values, conditions: Conditions) -> Iterable[str]:
    """Warn if a cycle of the vibration has fewer than 10 samples."""
    _, _, hertz = sound(*(values[key] for key in ("material", "amplitude", "decay", "frequency")))
    highest = 0.1 / conditions.period
    if hertz > highest * (1.0 + 1e-9):
        rings, most = with_unit(hertz, "Hz"), with_unit(highest, "Hz")
        yield (
            f"Ringing at {rings} is too fast: above {most}, the loop takes fewer than 10 samples per "
            "vibration."
        )


def terms(p: Values) -> ForceTerms:
    """Return the surface's spring and its damper, which acts only on entry."""
    found = "stiffness", "damping"
    return ForceTerms(
        p["stiffness"], p["damping"], None, p["position"], 1.0, contact=True, simple=False, terms=found
    )


ENVIRONMENT = Environment(
    key="hard_surface",
    title="Hard surface",
    summary="A wall that rings when hit",
    parameters=(
        Parameter(
            "stiffness",
            "Stiffness",
            "N/m",
            250.0,
            0.0,
            5000.0,
            "Force for each metre of depth in the surface",
            "k",
        ),
        Parameter(
            "damping", "Damping", "N·s/m", 0.0, 0.0, 50.0, "Force for each m/s of speed on the way in", "b"
        ),
        Parameter(
            "position", "Position", "m", 0.005, -0.04, 0.04, "Position of the surface", "x<sub>w</sub>"
        ),
        Choice(
            "material",
            "Material",
            MATERIALS,
            "custom",
            "Rubber, wood and aluminium have fixed values of ringing strength, decay and frequency. Custom "
            "uses the values below.",
        ),
        Parameter(
            "amplitude",
            "Ringing strength",
            "N·s/m",
            15.0,
            0.0,
            100.0,
            "Force of the ringing for each m/s of impact speed",
            "A",
        ),
        Parameter("decay", "Ringing decay", "1/s", 60.0, 5.0, 300.0, "How fast the ringing dies out", "γ"),
        Parameter(
            "frequency", "Ringing frequency", "Hz", 50.0, 5.0, 400.0, "Number of vibrations per second", "f"
        ),
        Parameter(
            "limit",
            "Ringing limit",
            "N",
            1.5,
            0.0,
            3.0,
            "Largest force of the ringing alone, before the wall's force is added",
        ),
    ),
    force=force,
    shortcut="5",
    formula="<i>F</i> = −<i>k d</i> − <i>A v</i><sub>i</sub> e<sup>−γτ</sup> sin 2π<i>f</i>τ",
    symbols="<i>k</i> stiffness, <i>d</i> depth, <i>A</i> ringing strength, <i>v</i><sub>i</sub> impact "
    "speed, γ ringing decay, <i>f</i> ringing frequency, τ time since the impact",
    explanation="A motor cannot be as stiff as wood, but it can vibrate as wood does when you knock on it. "
    "Each time you hit the surface, the motor adds a short vibration, the ringing. The faster you "
    "hit, the stronger the ringing, and your hand feels this as hardness. Each hit rings only "
    "once; the next hit rings only after you have clearly left the surface.",
    impedance=lambda p: (p["stiffness"], p["damping"]),
    terms=terms,
    unused=unused,
    warnings=warnings,
    over_position=lambda values, x: -values["stiffness"] * (x - values["position"]).clip(0.0),
    shades=True,
    hands=("tap", "released"),
    needs=("mass", "viscous", "coulomb", "quantization", "sampling", "delay", "saturation", "filter"),
    order=5,
)
