"""Cat: fur with a nap, breathing, and a mood that depends on the hand."""

import math

import numpy as np

from hapkit_studio.dynamics.friction import tether
from hapkit_studio.environments.base import Environment, Values, no_terms
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter

FUR_STIFFNESS = 200.0  # N/m: a stroke bends hairs by 2 to 3 mm before they slip
HAIR_SPACING = 0.003  # m
# Speeds of the hand in m/s. Below the first speed the hand rests. Between the next two the cat feels a caress
# (1 to 10 cm/s: C-tactile afferents, Löken et al. 2009; the range is wider here, because tufts vary the
# speed). Above the last speed the hand is rough.
RESTS, SLOW, FAST, ROUGH = 0.003, 0.005, 0.12, 0.14
PACE_TIME = 0.01  # s: time constant of two low-pass filters, which suppress sensor counts and the purr
# contentment per metre that a caress adds, and that a stroke against the nap and a rough stroke remove
LIKED, MISLIKED, HATED = 3.0, 0.8, 3.5
FORGETS = 10.0  # s: time constant of the mood; the effect of a caress decays only while the hand rests
PURRS_ABOVE, SWATS_BELOW = 0.3, -0.5
# the purr's pitch in Hz and its relative force increase by these amounts on exhaling, and decrease on
# inhaling
BREATH_PITCH, BREATH_STRENGTH = 1.2, 0.2
SWAT_TIME, SWAT_FORCE = 0.3, 1.5  # s, N: duration and force of a swat
SULK_TIME = 5.0  # s: time after a swat during which the cat sulks
CHOOSY, GRUMPY = 1, 2
TURN = 2.0 * math.pi


def noticed(way, nearly, pace, dt):
    """Return the intermediate state of the filter, and the filtered speed of the hand in m/s."""
    nearly += (way - nearly * dt) / (PACE_TIME + dt)
    return nearly, pace + (nearly - pace) * dt / (PACE_TIME + dt)


def feeling(pace, temperament, sulk):
    """Return the contentment per metre of the hand's motion to the right, for a filtered speed in m/s.

    The distance is signed, so that jitter leaves the mood unchanged.
    """
    liking, dislike = 1.0, 1.0
    if temperament == CHOOSY:
        liking, dislike = 0.8, 1.25
    elif temperament == GRUMPY:
        liking, dislike = 0.7, 1.5
    if pace > ROUGH:
        return -HATED * dislike
    if pace < -FAST:
        return HATED * dislike
    if pace < -RESTS:
        return MISLIKED * dislike
    if SLOW <= pace <= FAST and sulk == 0.0:
        return LIKED * liking
    return 0.0


def paw(swat, sulk, provoked, dt):
    """Return the remaining seconds of a swat and of the following sulk, which prevents another swat."""
    if swat > 0.0:
        swat = max(0.0, swat - dt)
        return swat, SULK_TIME if swat == 0.0 else 0.0
    if provoked > 0.0 and sulk == 0.0:
        return SWAT_TIME, 0.0
    return 0.0, max(0.0, sulk - dt)


def turned(angle, frequency, dt):
    """Return an angle in rad, below one turn, after dt s at a frequency in Hz."""
    return math.fmod(angle + TURN * frequency * dt, TURN)


def purr(contentment, strength, frequency, breath, phase, dt):
    """Return the purr in N and its phase in rad; the phase is accumulated, so that the pitch may vary."""
    if contentment <= PURRS_ABOVE:
        return 0.0, 0.0
    out = 1.0 if breath < math.pi else -1.0
    phase = turned(phase, frequency + BREATH_PITCH * out, dt)
    return contentment * strength * (1.0 + BREATH_STRENGTH * out) * math.sin(phase), phase


STATE = (
    "anchor", "phase", "breath", "contentment", "swat", "sulk", "swats", "push", "last", "nearly", "pace",
    "started",
)  # fmt: skip


@law(state=dict.fromkeys(STATE, 0.0))
def force(p, s, x, v, dt):
    if s.started == 0.0:
        s.started, s.anchor, s.last = 1.0, x, x
    way = x - s.last
    s.last = x
    s.nearly, s.pace = noticed(way, s.nearly, s.pace, dt)
    gain = way * feeling(s.pace, p.temperament, s.sulk)
    if s.contentment < 0.0 or abs(s.pace) < RESTS:
        s.contentment *= 1.0 - min(1.0, dt / FORGETS)
    s.contentment = min(1.0, max(-1.0, s.contentment + gain))
    if s.swat == 0.0:
        s.push = -1.0 if s.pace > 0.0 else 1.0
    provoked = 1.0 if gain < 0.0 and s.contentment < SWATS_BELOW else 0.0
    s.swat, s.sulk = paw(s.swat, s.sulk, provoked, dt)
    if s.swat == SWAT_TIME:
        s.swats += 1.0
    blow = s.push * SWAT_FORCE * math.sin(math.pi * s.swat / SWAT_TIME)

    limit = p.fur_friction if x > s.anchor else p.fur_friction * p.nap_ratio
    fur, s.anchor = tether(x, s.anchor, FUR_STIFFNESS, limit)
    fur += p.hair * math.sin(TURN * x / HAIR_SPACING) - p.fur_damping * v

    s.breath = turned(s.breath, p.breathing_rate, dt)
    hum, s.phase = purr(s.contentment, p.purr_force, p.purr_frequency, s.breath, s.phase, dt)
    return fur + blow + hum


def impedance(p: Values) -> tuple[float, float]:
    """Return the (stiffness, damping) of bending hairs at the steepest ripple."""
    return FUR_STIFFNESS + p["hair"] * TURN / HAIR_SPACING, p["fur_damping"]


def over_position(p: Values, x: np.ndarray) -> np.ndarray:
    """Return the force in N, (2, n), of slipping with the nap and against the nap, without tufts."""
    return np.outer((-p["fur_friction"], p["fur_friction"] * p["nap_ratio"]), np.ones_like(x))


PARAMETERS = (
    Parameter(
        "fur_friction",
        "Fur friction",
        "N",
        0.35,
        0.0,
        1.5,
        "Force at which the fur slips under your hand when you stroke from head to tail",
    ),
    Parameter(
        "nap_ratio",
        "Reverse friction",
        "×",
        1.8,
        1.0,
        3.0,
        "Friction from tail to head, divided by the friction from head to tail",
    ),
    Parameter(
        "fur_damping",
        "Damping",
        "N·s/m",
        1.5,
        0.0,
        10.0,
        "Force against the motion for each m/s of speed",
        "b",
    ),
    Parameter(
        "hair",
        "Force of the hairs",
        "N",
        0.06,
        0.0,
        0.3,
        "Force of the small waves that the hair adds, one wave every 3 mm",
    ),
    Parameter(
        "purr_force",
        "Purr force",
        "N",
        0.25,
        0.0,
        1.0,
        "Force of the purr when the cat's contentment is +1, the highest value (−1 is the lowest). The cat "
        "purrs when its contentment is above 0.3. Without stroking, contentment falls by a third every 4 s",
        "F<sub>p</sub>",
    ),
    Parameter(
        "purr_frequency",
        "Purr pitch",
        "Hz",
        26.3,
        20.0,
        30.0,
        "Frequency of the purr. It rises and falls by 1.2 Hz with each breath",
    ),
    Parameter("breathing_rate", "Breathing rate", "Hz", 0.4, 0.1, 1.0, "Breaths per second"),
    Choice(
        "temperament",
        "Character",
        ("easy", "choosy", "grumpy"),
        "easy",
        "How strokes change the cat's contentment, which is between −1 and +1. Easy: the contentment "
        "grows by 3 per metre of strokes from head to tail at 1 to 10 cm/s, the speed at which people like "
        "to be stroked. Strokes against the fur lower it by 0.8 per metre. Fast strokes (above 12 cm/s "
        "against the fur, above 14 cm/s from head to tail) lower it by 3.5 per metre. Below −0.5 the cat "
        "hits your hand, then ignores you for 5 s. Choosy: the contentment grows 0.8 times and falls 1.25 "
        "times as fast as with Easy. Grumpy: it grows 0.7 times and falls 1.5 times as fast as with Easy.",
    ),
)


ENVIRONMENT = Environment(
    key="cat",
    title="Cat",
    summary="Pet it gently",
    parameters=PARAMETERS,
    force=force,
    drives="The purr and the paw move the handle by themselves.",
    shortcut="C",
    formula="<i>F</i> = fur − <i>b v</i> + <i>c F</i><sub>p</sub> sin <i>φ</i>",
    symbols="fur: friction and force of the hairs, <i>b</i> damping, <i>v</i> velocity, <i>c</i> "
    "contentment, <i>F</i><sub>p</sub> purr force, <i>φ</i> phase of the purr",
    explanation="Stroke the cat slowly from head (left) to tail: it becomes content and purrs. It dislikes "
    "fast strokes and strokes against the fur. If you stroke it the wrong way for long, it hits your "
    "hand once with its paw and then ignores you for 5 s. If you leave it alone, its mood "
    "slowly becomes neutral.",
    impedance=impedance,
    terms=no_terms,
    over_position=over_position,
    counts=("contentment", "swats"),
    hands=("pet", "rub", "released"),
    needs=("mass", "viscous", "coulomb", "sampling", "delay", "filter"),
    order=12,
)
