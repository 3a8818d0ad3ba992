"""What the handle does where a scene is rendered: the loop and the paddle iterated, sample by sample.

A linear limit knows nothing of dry friction, sensor steps and the force limit, which make stability a matter
of size: friction holds a small motion that delay would let grow, the force limit ends the growth of a large
one. So the handle is let go at rest at a place off the scene's centre, again and again from farther away,
until it does not come to rest; the edge between is found by bisection (describing functions explain it, e.g.
Diolaiti et al., IEEE T-RO 22(2), 2006; they miss where the motion is few counts).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.statistics import LEAST_CYCLES
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.errors import LawError
from hapkit_studio.formatting import hertz, on_screen, with_unit
from hapkit_studio.haptics import headless, patience, rows, settling
from hapkit_studio.haptics.settling import GROWS, IRREGULAR, LEAVES, RESTS, SHRINKS
from hapkit_studio.haptics.survey import Flat, packed

PUSHES = tuple(31.25e-6 * 2.0**n for n in range(10))
"""m, from which the handle is let go: up to 16 mm."""
_BETWEEN = tuple(math.sqrt(2.0) * push for push in PUSHES[:-1])
_FINER = tuple(2.0**share * push for share in (0.25, 0.75) for push in PUSHES[:-1])
_BEYOND = (1.05, 1.1, 1.2, 1.3, 1.5)  # times the edge
NUDGE = 1e-3
"""m: a hand does that much without meaning to."""
_HALVINGS = 7
# m: thrown out; where nothing brings the handle back it may drift on, and swing
_FAR, _ENDLESS = 0.060, 1e3
_TURNS = 2.2
_FEWEST_SAMPLES = 8
_LONGER = 4
# samples after which no push between those of the ladder is tried for the edge, and no further one for
# another swing, so that the answer is not late; damping in a grip has more swings to be found
_SEARCHED, _SAMPLES, _KICKED_SAMPLES = 32_000, 270_000, 500_000
# Swings whose sizes differ by less are one; frequencies that do are said as one.
_SAME, _SAME_SPEED = 0.05, 0.02
# s: how long a window is at least where there are objects
_RETURN_SECONDS = 0.25
_REST_REACH, _REST_FORCE, _REST_SECONDS = 1e-6, 0.020, 0.050
# m: where a law is looked at for places at which it brings the handle back.
PLACES = np.linspace(-0.045, 0.045, 901)
# N: presses into a scene that only pushes back; a share of what it, or the motor, can bear at most.
_PRESSES, _PRESSED = (1.0, 2.0), 0.6
# N/m: stands for the spring where there is none (how long is a turn, how fast a kick?); and the softest one
_SPRINGLESS, _SOFTEST = 100.0, 1.0
# The share of clamped samples from which the motor's limit is what holds a swing.
_AT_LIMIT = 0.05


@dataclass(frozen=True)
class Lasting:
    """A swing that lasts: m, Hz (NaN with too few cycles), the share of samples at the force limit.

    irregular: it goes on now more, now less, up to that amplitude.
    """

    amplitude: float
    frequency: float = math.nan
    clamped: float = 0.0
    irregular: bool = False

    @property
    def at_limit(self) -> bool:
        """Say whether the motor's limit is what holds it."""
        return self.clamped > _AT_LIMIT


@dataclass(frozen=True)
class Behaviour:
    """What a handle does that is let go at rest off a scene's centre.

    push: m, up to which it settles; inf where it settles from everywhere that was tried, 0 where from
    nowhere. From farther away it leaves, thrown beyond 60 mm, or swings on: sensor steps let several
    swings last side by side; least and most are the smallest and the largest of all pushes that were
    tried, the same where they are one; often: Hz of the slowest and the fastest. flick: where nothing
    brings it back a push of 1 m is a speed of so many m/s; 0 elsewhere. trembles: it goes on moving by less
    than one sensor step from peak to peak, and its force goes on changing. unknown: in sentences why it was
    not judged, "" where it was.
    """

    push: float = math.inf
    least: Lasting | None = None
    most: Lasting | None = None
    often: tuple[float, float] | None = None
    leaves: bool = False
    flick: float = 0.0
    trembles: bool = False
    unknown: str = ""

    @property
    def calm(self) -> bool:
        """Say whether it settles from any push."""
        return self.push == math.inf

    @property
    def sign(self) -> tuple[str, str]:
        """Return icon and colour: fine, mind, danger where a nudge is enough."""
        if self.unknown:
            return "circle", "ink2"
        if self.calm:
            return "check", "ok"
        return ("cross", "danger") if self.push < NUDGE else ("triangle", "warn")

    @property
    def words(self) -> str:
        """Return it in a few words: "settles below 0.9 mm, buzzes above"."""
        if self.unknown:
            return "not judged"
        if self.calm:
            return "calm to a sensor step" if self.trembles else "calm"
        does = " or ".join(["buzzes"] * bool(self.most) + ["is thrown out"] * self.leaves)
        if not self.push and not self.leaves and self.least and self.least.at_limit:
            return "grows to the motor's limit"
        edge = with_unit(self.push * self.flick, "m/s", 2) if self.flick else on_screen(self.push, "m", 2)
        return f"settles below {edge}, {does} above" if self.push else does

    @property
    def swing(self) -> str:
        """Return how it swings: "±2.3 mm at 30 Hz, at the motor's limit"; "" where it settles or leaves.

        "±0.05 to ±0.5 mm at 14 to 16 Hz, by how it is pushed" where several swings last.
        """
        if self.least is None or self.most is None:
            return ""
        far = f"±{on_screen(self.most.amplitude, 'm', 2)}"
        limited = ", at the motor's limit" if self.most.at_limit else ""
        if self.most.irregular:
            return f"irregularly, up to {far}{limited}"
        if self.often:
            slow, fast = self.often
            one = math.isclose(slow, fast, rel_tol=_SAME_SPEED)
            said = (
                hertz(0.5 * (slow + fast)) if one else f"{hertz(slow).removesuffix(' Hz')} to {hertz(fast)}"
            )
            far = f"{far} at {said}"
        if self.least == self.most:
            return f"{far}{limited}"
        return f"±{with_unit(1e3 * self.least.amplitude, digits=2)} to {far}{limited}, by how it is pushed"

    @property
    def sentence(self) -> str:
        """Return both, without a full stop."""
        if self.unknown:
            return f"{self.words}, as {self.unknown[0].lower()}{self.unknown[1:].removesuffix('.')}"
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

    @property
    def pushes(self) -> bool:
        """Say whether the law only pushes the handle out of itself."""
        return not self.returns and not self.kick


class Trials:
    """One scene made ready to be let go many times."""

    def __init__(self, scene: headless.Scene, grip: Grip | None, centre: Centre):
        r, body = scene.prepare()
        self._title = scene.environment.title
        self._r, self._body, self._flat = packed(r, body)
        self._made = Flat(*(array.copy() for array in self._flat))
        self._hand = np.array([grip.mass, grip.damping, grip.stiffness]) if grip else np.zeros(3)
        # a loop whose delay is longer than the spring's own turn swings in two to four delays
        self._turns = _TURNS * (2.0 * math.pi / _natural(scene, grip) + 4.0 * scene.loop.delay)
        # objects come back to a handle that has come to rest
        self._objects = _RETURN_SECONDS if scene.environment.stored else 0.0
        self._rate = scene.loop.rate
        rest = max(_REST_SECONDS + scene.loop.delay, settling.CALM_WINDOWS * self._objects)
        still = math.ceil(rest * scene.loop.rate)
        far = _ENDLESS if centre.kick else _FAR
        self._quiet = settling.Quiet(
            _REST_REACH, scene.device.quantum, _REST_FORCE, still, far, drifts=centre.kick > 0.0
        )
        self.centre, self.step = centre, scene.device.quantum
        # to both sides but where the scene pushes the handle out of itself: sensor steps round down
        self.sides = (1.0,) if centre.pushes else (1.0, -1.0)
        # nothing brings an ideal handle to rest for good: the smallest motion, too, only shrinks
        self._ideal = scene.device.coulomb_force == 0.0 and scene.device.quantum == 0.0
        self._row, self._swing = np.zeros(rows.ROW_WIDTH), settling.new_swing()
        self.samples, self.trembles = 0, False

    def end(self, push: float, longer: int = 1, known: bool = False) -> int:
        """Let go at a push in m, on the other side where it is negative; return one of settling's ends.

        longer: by how much its windows are; known: until it is known whether it settles, else until the swing
        is steady.
        """
        c = self.centre
        begin = c.position + (0.0 if c.kick else c.side * push)
        away = np.array([begin, c.side * push * c.kick, c.target])
        args = self._r, self._body, self._flat, self._made, self._hand, away
        window = max(math.ceil(max(self._turns, self._objects) * longer * self._rate), _FEWEST_SAMPLES)
        found = int(settling.let_go(*args, window, self._ideal, known, self._quiet, self._row, self._swing))
        patience.check(self._r, self._title)
        self.samples += int(self._swing.samples[0])
        return found

    def settles(self, push: float) -> bool:
        """Return whether what is let go at a push in m comes to rest, or leaves where nothing holds it."""
        return all(self._settled(self.end(side * push, known=True)) for side in self.sides)

    def _settled(self, end: int) -> bool:
        """Return whether the last run ended at rest, or moves by less than one sensor step, peak to peak."""
        if end in (RESTS, SHRINKS):
            return True
        if end == LEAVES:
            return self.centre.pushes
        if self.centre.kick and math.isnan(self._swing.frequency[0]):
            return True
        small = end != GROWS and self._reach < self.step
        self.trembles |= small
        return small

    @property
    def _reach(self) -> float:
        """Return how far the last run swung, in m, peak to peak, beside its drift where nothing holds it."""
        return float(self._swing.reach[0])

    @property
    def _frequency(self) -> float:
        """Return how often the last run swung in Hz; NaN with too few cycles in its last half to tell."""
        frequency = float(self._swing.frequency[0])
        cycles = frequency * 0.5 * float(self._swing.samples[0]) / self._rate
        return frequency if cycles >= LEAST_CYCLES else math.nan

    def swings(self, push: float, longer: int = 1) -> list[Lasting | None]:
        """Return how it swings that is let go at a push in m, on each side; None where it leaves."""
        found: list[Lasting | None] = []
        for side in self.sides:
            end = self.end(side * push, longer=longer)
            if self._settled(end):
                continue
            numbers = 0.5 * self._reach, self._frequency, float(self._swing.clamped[0])
            found.append(None if end == LEAVES else Lasting(*numbers, end == IRREGULAR))
        return found


def centres_of(scene: headless.Scene, grip: Grip | None) -> list[Centre]:
    """Return where a law brings the handle back most strongly, or places where a hand presses into it."""
    force = np.empty_like(PLACES)
    r, _ = scene.prepare()
    settling.static_forces(r, PLACES, force)
    patience.check(r, scene.environment.title)
    slope = np.diff(force)
    falls = (force[:-1] >= 0.0) & (force[1:] <= 0.0) & (slope < 0.0)
    crossings = 1 + np.flatnonzero(falls[1:-1] & (force[:-3] > 0.0) & (force[3:] < 0.0))
    if crossings.size:
        i = int(crossings[slope[crossings].argmin()])
        place = float(PLACES[i] - force[i] * (PLACES[i + 1] - PLACES[i]) / slope[i])
        return [Centre(place, place)]
    side = 1.0 if -force.min() >= force.max() else -1.0
    against = (-side * force)[:: int(side)]
    places, most = PLACES[:: int(side)], min(float(against.max()), scene.device.max_force)
    if not most > 0.0:
        return [Centre(0.0, 0.0, returns=False, kick=_natural(scene, grip))]
    if grip is None:  # let go at the surface, into it
        touched = np.flatnonzero(against > 0.0)[0]
        return [Centre(float(places[max(touched - 1, 0)]), 0.0, side, returns=False)]
    presses = sorted({min(press, _PRESSED * most) for press in _PRESSES})
    found = [_where(places, against, press) for press in presses]
    return [
        Centre(place, place + side * press / grip.stiffness, side, returns=False)
        for place, press in zip(found, presses, strict=True)
    ]


def _where(places: np.ndarray, force: np.ndarray, wanted: float) -> float:
    """Return the first place (n,) in m at which a force (n,) reaches what is wanted, in N."""
    i = max(int(np.flatnonzero(force >= wanted)[0]), 1)
    share = (wanted - force[i - 1]) / (force[i] - force[i - 1])
    return float(places[i - 1] + share * (places[i] - places[i - 1]))


def _natural(scene: headless.Scene, grip: Grip | None) -> float:
    """Return how fast the handle turns on the scene's spring, in rad/s."""
    own = scene.environment.impedance
    stiffness = (own(scene.values)[0] if own else 0.0) + (grip.stiffness if grip else 0.0)
    mass = scene.device.mass + (grip.mass if grip else 0.0)
    return math.sqrt(max(stiffness or _SPRINGLESS, _SOFTEST) / mass)


def behaviour(scene: headless.Scene, grip: Grip | None) -> Behaviour:
    """Return what the handle does in a scene, let go (None) or in a hand's grip, wherever that presses.

    It is unknown where the law takes too long.
    """
    try:
        tried = [Trials(scene, grip, centre) for centre in centres_of(scene, grip)]
        edges, found = zip(*(_searched(trials) for trials in tried), strict=True)
    except LawError as error:
        return Behaviour(0.0, unknown=str(error))
    said = _summary(tried[0], min(edges), [one for some in found for one in some])
    return replace(said, trembles=any(trials.trembles for trials in tried))


def settles(scene: headless.Scene, grip: Grip | None, push: float) -> bool:
    """Return whether a handle comes to rest that is let go at a push in m, in a grip wherever it presses.

    Raise LawError where the law takes too long.
    """
    return all(Trials(scene, grip, centre).settles(push) for centre in centres_of(scene, grip))


def _searched(trials: Trials) -> tuple[float, list[Lasting | None]]:
    """Return up to which push in m it settles, inf where from all, and the swings from larger ones."""
    edge, rests = math.inf, [0.0]
    found: list[Lasting | None] = []
    for push in (*PUSHES, *_BETWEEN, *_FINER):
        if push > edge or (push not in PUSHES and trials.samples > _SEARCHED):
            continue
        if trials.settles(push) or not (lasting := trials.swings(push, _LONGER)):
            rests.append(push)
        else:
            edge, found = push, found + lasting
    if not found:
        return math.inf, []
    calm = max(push for push in rests if push < edge)
    larger = [other for other in (PUSHES[-1], *PUSHES[:-1], *_BETWEEN) if other > edge]
    for _ in range(_HALVINGS if calm else 0):
        middle = math.sqrt(calm * edge)
        calm, edge = (middle, edge) if trials.settles(middle) else (calm, middle)
    if calm:
        found += trials.swings(edge, _LONGER)
    if trials.centre.kick:  # damping in a grip often has a second, small oscillation, which few pushes reach
        beyond = [times * edge for times in _BEYOND] if calm else []
        larger = [*beyond, *larger, *(other for other in _FINER if other > edge)]
    for other in larger:
        if trials.samples < (_KICKED_SAMPLES if trials.centre.kick else _SAMPLES):
            found += trials.swings(other)
    return calm, found


def _summary(trials: Trials, calm: float, found: list[Lasting | None]) -> Behaviour:
    """Return what is said of the swings from all pushes: the smallest and the largest, or that it leaves."""
    swings = sorted((one for one in found if one), key=lambda one: one.amplitude)
    behaviour = Behaviour(calm, leaves=None in found, flick=trials.centre.kick if found else 0.0)
    if not swings:
        return behaviour
    least, most = swings[0], swings[-1]
    if most.amplitude - least.amplitude <= max(_SAME * least.amplitude, trials.step):
        least = most
    heard = [one.frequency for one in swings if math.isfinite(one.frequency) and not one.irregular]
    return replace(behaviour, least=least, most=most, often=(min(heard), max(heard)) if heard else None)
