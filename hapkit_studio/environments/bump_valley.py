"""Bump and valley: a hill at −25 mm and a hollow at +25 mm, rendered as a horizontal force."""

import math

import numpy as np

from hapkit_studio.environments.base import Environment, Values, no_terms
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter

BUMP = -0.025
# A Gaussian is cut off at 3 sigma. Its value there is subtracted, so that force and height are continuous.
CUT = math.exp(-4.5)
# 1 over the maximum of t (exp(−t²/2) − CUT), which is at t = 0.9909
GAUSSIAN_PEAK = 1.6793390230328566
# 1 over the height at the centre
GAUSSIAN_RISE = 1.0 / (1.0 - 5.5 * CUT)
# height at the centre over width, for bumps whose largest slope is 1
COSINE_TOP, GAUSSIAN_TOP = 1.0 / math.pi, GAUSSIAN_PEAK / 6.0 / GAUSSIAN_RISE
# N: the relief is drawn so that its slope times this force is the rendered force
NORMAL_FORCE = 1.0


def gaussian_push(a):
    """Return the force of a Gaussian bump, at most 1, at ``a`` widths (6 sigma) from the centre."""
    return GAUSSIAN_PEAK * 6.0 * a * (math.exp(-18.0 * a * a) - CUT)


def gaussian_rise(a):
    """Return the height of the Gaussian bump, which is 1 at the centre."""
    return GAUSSIAN_RISE * (math.exp(-18.0 * a * a) - 5.5 * CUT + 18.0 * CUT * a * a)


def cosine_rise(a):
    """Return the height of the cosine bump, which is 1 at the centre."""
    return 0.5 * (1.0 + math.cos(math.tau * a))


@law
def force(p, s, x, v, dt):
    sign = 1.0 if x < 0.0 else -1.0
    a = (x - sign * BUMP) / p.width
    if abs(a) >= 0.5:
        return 0.0
    if p.law == "gradient":
        push = gaussian_push(a) if p.profile == "gaussian" else math.sin(math.tau * a)
        return sign * p.peak_force * push
    level = cosine_rise(a) if p.profile == "cosine" else gaussian_rise(a)
    return -sign * p.peak_force * level


def _top(values):
    return COSINE_TOP if values["profile"] else GAUSSIAN_TOP


def height(values: Values, x: np.ndarray) -> np.ndarray:
    """Return the height (n,) in m of the drawn relief at x (n,) in m; it is 0 on the flat ground.

    The option ``same`` is the relief that the gradient law renders for a weight of 1 N. The option
    ``opposite`` is the mirror image of this relief.
    """
    sign = np.where(x < 0.0, 1.0, -1.0)
    a = (x - sign * BUMP) / values["width"]
    inside = np.abs(a) < 0.5
    rise = cosine_rise if values["profile"] else gaussian_rise
    rise = _top(values) * np.vectorize(rise, otypes=[float])(np.where(inside, a, 0.5))
    drawn = (1.0, -1.0, 0.0)[int(values["picture"])]
    scale = drawn * values["peak_force"] / NORMAL_FORCE * values["width"]
    return np.where(inside, scale * sign * rise, 0.0)


def impedance(values: Values) -> tuple[float, float]:
    """Return the steepest slope of the force, and no damping.

    The force of the gradient law is steepest at the centre.
    """
    per_width = values["peak_force"] / values["width"]
    if values["law"]:
        return per_width / _top(values), 0.0
    return per_width * (math.tau if values["profile"] else 6.0 * GAUSSIAN_PEAK * (1.0 - CUT)), 0.0


ENVIRONMENT = Environment(
    key="bump_valley",
    title="Bump and valley",
    summary="A hill and a valley to feel",
    parameters=(
        Parameter(
            "peak_force",
            "Peak force",
            "N",
            0.7,
            0.0,
            3.0,
            "Largest force on the hill and in the valley",
            "F<sub>p</sub>",
        ),
        Parameter(
            "width",
            "Width",
            "m",
            0.02,
            0.004,
            0.04,
            "Width of the hill and of the valley: from where the force begins to where it ends",
            "w",
        ),
        Choice(
            "profile",
            "Profile",
            ("gaussian", "cosine"),
            "gaussian",
            "Shape of the hill and the valley, seen from the side",
        ),
        Choice(
            "law",
            "Force depends on",
            ("gradient", "height"),
            "gradient",
            "Slope: the force depends on the slope, as for a rolling ball. Height: the force depends on "
            "the height and pushes to the left on the hill and to the right in the valley. This feels like a "
            "hill only when you come from one side.",
            labels=("Slope", "Height"),
        ),
        Choice(
            "picture",
            "Picture",
            ("same", "opposite", "flat"),
            "same",
            "Ground that is drawn: the shape that you feel, the opposite shape (valleys for hills), or flat "
            "ground. The force does not change.",
            labels=("Felt shape", "Opposite shape", "Flat ground"),
        ),
    ),
    force=force,
    shortcut="6",
    formula="<i>F</i> = −<i>N</i> d<i>h</i>/d<i>x</i>",
    symbols="<i>N</i> weight (1 newton), <i>h</i> height of the ground, <i>x</i> position",
    explanation="The handle moves on a level line, and yet you feel a hill. The slope of the height h pushes "
    "against you on the way up and helps you on the way down, from both sides alike, so crossing "
    "the hill costs no energy. Set the picture to Opposite shape and feel again: most people believe "
    "the force, not the shape that they see (Robles-De-La-Torre and Hayward, 2001).",
    impedance=impedance,
    terms=no_terms,
    hands=("sweep", "released"),
    needs=("mass", "viscous", "coulomb", "sampling", "delay"),
    order=6,
)
