"""Detents: each multiple of the pitch has a notch with a spring and damper; the handle is free in between."""

import math

from hapkit_studio.environments.base import Environment, no_terms
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


@law
def force(p, s, x, v, dt):
    away = x - p.pitch * math.floor(x / p.pitch + 0.5)
    if abs(away) > p.half_width:
        return 0.0
    return -p.stiffness * away - p.damping * v


ENVIRONMENT = Environment(
    key="detents",
    title="Detents",
    summary="Notches that click",
    parameters=(
        Parameter(
            "stiffness",
            "Stiffness",
            "N/m",
            400.0,
            0.0,
            2000.0,
            "Force for each metre of distance from the centre of a notch",
            "k",
        ),
        Parameter(
            "damping", "Damping", "N·s/m", 2.0, 0.0, 50.0, "Force for each m/s of speed inside a notch", "b"
        ),
        Parameter(
            "pitch",
            "Pitch",
            "m",
            0.02,
            0.005,
            0.04,
            "Distance from the centre of one notch to the next. One notch has its centre at 0",
            "p",
        ),
        Parameter(
            "half_width",
            "Half width",
            "m",
            0.003,
            0.0005,
            0.005,
            "Distance that a notch reaches from its centre to each side",
            "w",
        ),
    ),
    force=force,
    shortcut="9",
    formula="<i>F</i> = −<i>k</i> (<i>x</i> − <i>x</i><sub>n</sub>) − <i>b v</i> in a notch",
    symbols="<i>k</i> stiffness, <i>x</i> position, <i>x</i><sub>n</sub> centre of the notch, "
    "<i>b</i> damping, <i>v</i> velocity",
    explanation="In each notch, a short spring pulls the handle to the notch's centre x<sub>n</sub>. When "
    "you pull the handle out of a notch, the force rises up to k·w (stiffness times half width) and then "
    "drops to zero: this drop is the click of a knob. Damping absorbs the energy of the fall into the next "
    "notch; without damping, the handle vibrates.",
    impedance=lambda p: (p["stiffness"], p["damping"]),
    terms=no_terms,
    hands=("sweep", "released"),
    needs=("mass", "viscous", "coulomb", "quantization", "sampling", "delay", "filter"),
    order=9,
)
