"""What the handle does where a scene is rendered: the loop and the paddle iterated, sample by sample.

A linear limit knows nothing of dry friction, sensor steps and the force limit, which make stability a matter
of size: friction holds a small motion that delay would let grow, the force limit ends the growth of a large
one. So the handle is let go at rest at a place off the scene's centre, again and again from farther away,
until it does not come to rest; the edge between is found by bisection (describing functions explain it, e.g.
Diolaiti et al., IEEE T-RO 22(2), 2006; they miss where the motion is few counts).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.environments.base import Environment
from hapkit_studio.formatting import on_screen, significant
from hapkit_studio.haptics import headless, rows, settling
from hapkit_studio.haptics.settling import LEAVES, RESTS, SHRINKS
from hapkit_studio.haptics.survey import Flat, packed

PUSHES = tuple(31.25e-6 * 2.0**n for n in range(10))
"""m, from which the handle is let go: up to 16 mm."""
NUDGE = 1e-3
"""m: a hand does that much without meaning to."""
_HALVINGS = 7
_FAR = 0.060
_TURNS = 2.2
_FEWEST_SAMPLES = 8
_LONGER = 4
# At the edge itself a motion neither dies nor grows for long.
_OFF_EDGE = 1.05
_REST_REACH, _REST_FORCE, _REST_SECONDS = 1e-6, 0.020, 0.050
# m: where a law is looked at for places at which it brings the handle back.
PLACES = np.linspace(-0.045, 0.045, 451)
_PRESS = 1.0
# N/m of a scene without a spring in a free hand: how long a turn is at most, and how fast a kick is.
_SOFT, _KICKED = 1.0, 100.0
# The share of clamped samples from which the motor's limit is what holds a swing.
_AT_LIMIT = 0.05


@dataclass(frozen=True)
class Behaviour:
    """What a handle does that is let go at rest off a scene's centre.

    push: m, up to which it settles; inf where it settles from everywhere that was tried, 0 where from
    nowhere. From farther away it swings by an amplitude in m at a frequency in Hz, clamped is the share of
    samples at the force limit; or it leaves, thrown beyond 60 mm.
    """

    push: float = math.inf
    amplitude: float = 0.0
    frequency: float = math.nan
    clamped: float = 0.0
    leaves: bool = False

    @property
    def calm(self) -> bool:
        """Say whether it settles from any push."""
        return self.push == math.inf

    @property
    def words(self) -> str:
        """Return it in a few words: "settles below 0.9 mm, buzzes above"."""
        if self.calm:
            return "calm"
        does = "is thrown out" if self.leaves else "buzzes"
        if not self.push and self.at_limit:
            return "grows to the motor's limit"
        return f"settles below {on_screen(self.push, 'm', 2)}, {does} above" if self.push else does

    @property
    def at_limit(self) -> bool:
        """Say whether the motor's limit is what holds a swing."""
        return self.clamped > _AT_LIMIT

    @property
    def swing(self) -> str:
        """Return how it swings: "±2.3 mm at 30 Hz, at the motor's limit"; "" where it settles or leaves."""
        if self.calm or self.leaves:
            return ""
        limited = ", at the motor's limit" if self.at_limit else ""
        return f"±{on_screen(self.amplitude, 'm', 2)} at {significant(self.frequency)} Hz{limited}"

    @property
    def sentence(self) -> str:
        """Return both, without a full stop."""
        return f"{self.words}: {self.swing}" if self.swing else self.words


@dataclass(frozen=True)
class Centre:
    """Where a motion is tried: m, where the hand pulls to in m, which way the handle is pushed.

    returns: the law brings it back from both sides. kick: a push of 1 m is a start with so many m/s where
    nothing brings it back.
    """

    position: float
    target: float
    side: float = 1.0
    returns: bool = True
    kick: float = 0.0


class Trials:
    """One scene made ready to be let go many times."""

    def __init__(self, scene: headless.Scene, grip: Grip | None, centre: Centre, stiffness: float):
        r, body = scene.prepare()
        self._r, self._body, self._flat = packed(r, body)
        self._made = Flat(*(array.copy() for array in self._flat))
        self._hand = np.array([grip.mass, grip.damping, grip.stiffness]) if grip else np.zeros(3)
        mass = scene.device.mass + (grip.mass if grip else 0.0)
        held = stiffness + (grip.stiffness if grip else 0.0)
        # a loop whose delay is longer than the spring's own turn swings in two to four delays
        turn = 2.0 * math.pi * math.sqrt(mass / max(held, _SOFT)) + 4.0 * scene.loop.delay
        self._window = max(math.ceil(_TURNS * turn * scene.loop.rate), _FEWEST_SAMPLES)
        still = math.ceil((_REST_SECONDS + scene.loop.delay) * scene.loop.rate)
        self._quiet = settling.Quiet(_REST_REACH, scene.device.quantum, _REST_FORCE, still, _FAR)
        self._centre = centre
        # nothing brings an ideal handle to rest for good: the smallest motion, too, only shrinks
        self._ideal = scene.device.coulomb_force == 0.0 and scene.device.quantum == 0.0
        self._row, self._swing = np.zeros(rows.ROW_WIDTH), settling.new_swing()

    def end(self, push: float, steady: bool = False) -> int:
        """Let go at a push in m; return how it ended, one of settling's ends.

        steady: until the swing is steady; else until it is known, where all smaller pushes settle.
        """
        c = self._centre
        away = np.array([c.position + (0.0 if c.kick else c.side * push), c.side * push * c.kick, c.target])
        args = self._r, self._body, self._flat, self._made, self._hand, away
        window = self._window * (_LONGER if steady else 1)
        shrinks = push > PUSHES[0] or self._ideal
        ends = not steady and shrinks, not steady
        return int(settling.let_go(*args, window, *ends, self._quiet, self._row, self._swing))

    def settles(self, push: float) -> bool:
        """Return whether what is let go at a push in m comes to rest, or leaves where nothing holds it."""
        end = self.end(push)
        return end in (RESTS, SHRINKS) or (end == LEAVES and not self._centre.returns)

    def swing_found(self) -> tuple[float, float, float]:
        """Return amplitude in m, frequency in Hz and clamped share of the last run."""
        return (
            0.5 * float(self._swing.reach[0]),
            float(self._swing.frequency[0]),
            float(self._swing.clamped[0]),
        )


def centre_of(environment: Environment, values: Mapping[str, float], grip: Grip | None) -> Centre:
    """Return where a law brings the handle back most strongly, or a place where a hand presses into it."""
    force = environment.curve(values, PLACES)
    slope = np.diff(force)
    falls = (force[:-1] >= 0.0) & (force[1:] <= 0.0) & (slope < 0.0)
    crossings = 1 + np.flatnonzero(falls[1:-1] & (force[:-3] > 0.0) & (force[3:] < 0.0))
    if crossings.size:
        i = int(crossings[slope[crossings].argmin()])
        place = float(PLACES[i] - force[i] * (PLACES[i + 1] - PLACES[i]) / slope[i])
        return Centre(place, place)
    if not np.abs(force).max() > 0.0:
        return Centre(0.0, 0.0, returns=False, kick=1.0)
    return _pressed(force, grip)


def _pressed(force: np.ndarray, grip: Grip | None) -> Centre:
    """Return where a law that pushes one way only balances a hand's press, and where the hand pulls to."""
    side = 1.0 if force[-1] < -force[0] else -1.0
    against = -side * force
    press = min(_PRESS, 0.5 * float(against.max()))
    order = slice(None) if side > 0.0 else slice(None, None, -1)
    i = int(np.flatnonzero(against[order] >= press)[0])
    places = PLACES[order]
    before, after = against[order][i - 1 : i + 1]
    place = float(places[i - 1] + (places[i] - places[i - 1]) * (press - before) / (after - before))
    if grip is None:  # let go at the surface, into it
        touched = np.flatnonzero(against[order] > 0.0)[0]
        return Centre(float(places[max(touched - 1, 0)]), 0.0, side, returns=False)
    return Centre(place, place + side * press / grip.stiffness, side, returns=False)


def behaviour(scene: headless.Scene, grip: Grip | None) -> Behaviour:
    """Return what the handle does in a scene, let go (None) or in a hand's grip."""
    environment, values = scene.environment, scene.values
    centre = centre_of(environment, values, grip)
    stiffness = environment.impedance(values)[0] if environment.impedance else 0.0
    if centre.kick:
        held = stiffness + (grip.stiffness if grip else 0.0)
        mass = scene.device.mass + (grip.mass if grip else 0.0)
        centre = replace(centre, kick=math.sqrt(max(held, _KICKED) / mass))
    trials = Trials(scene, grip, centre, stiffness)
    calm = 0.0
    for push in PUSHES:
        if not trials.settles(push):
            break
        calm = push
    else:
        return Behaviour()
    beyond = push
    for _ in range(_HALVINGS if calm else 0):
        middle = math.sqrt(calm * beyond)
        calm, beyond = (middle, beyond) if trials.settles(middle) else (calm, middle)
    # where nothing settles, sensor steps may hold the least motion within a few counts: a nudge shows more
    swings = []
    for push in (_OFF_EDGE * beyond,) if calm else (_OFF_EDGE * beyond, NUDGE):
        if trials.end(push, steady=True) == LEAVES:
            return Behaviour(calm, leaves=True)
        swings.append(trials.swing_found())
    return Behaviour(calm, *max(swings))
