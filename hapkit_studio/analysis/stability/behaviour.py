"""Behaviour of the handle in a scene, simulated sample by sample.

Linear limits ignore dry friction, quantisation and the force limit. With these, stability depends on the
amplitude: friction stops a small motion that delay would amplify, and the force limit bounds the growth of a
large one. The handle is released without speed at increasing distances from the scene's centre until it does
not settle. The boundary is refined by bisection. (Describing functions explain this behaviour, e.g. Diolaiti
et al., IEEE T-RO 22(2), 2006, but are inaccurate for motions of few counts.)
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.statistics import LEAST_CYCLES
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.errors import LawError
from hapkit_studio.formatting import hertz, on_screen, with_unit
from hapkit_studio.haptics import headless, patience, rows, settling
from hapkit_studio.haptics.cell_batch import packed
from hapkit_studio.haptics.settling import GROWS, IRREGULAR, LEAVES, RESTS, SHRINKS

PUSHES = tuple(31.25e-6 * 2.0**n for n in range(10))
"""m: initial displacements of the handle, up to 16 mm."""
_BETWEEN = tuple(math.sqrt(2.0) * push for push in PUSHES[:-1])
_FINER = tuple(2.0**share * push for share in (0.25, 0.75) for push in PUSHES[:-1])
# displacements beyond the boundary that are also tried, as multiples of the boundary
_BEYOND = (1.05, 1.1, 1.2, 1.3, 1.5)
NUDGE = 1e-3
"""m: displacement that an unintended nudge of the hand causes."""
_HALVINGS = 7
# m: distance at which the handle has run away; _ENDLESS applies to scenes without a restoring force
_FAR, _ENDLESS = 0.060, 1e3
_TURNS = 2.2
_FEWEST_SAMPLES = 8
_LONGER = 4
# Numbers of simulated samples that bound the computing time: for refining the boundary, for further
# oscillations, and for the oscillations of a damper in a grip, which are more numerous.
_SEARCHED, _SAMPLES, _KICKED_SAMPLES = 32_000, 270_000, 500_000
# Relative tolerances: oscillations with closer amplitudes are treated as one, and closer frequencies are
# shown as one.
_SAME, _SAME_SPEED = 0.05, 0.02
# s: shortest time over which the motion is evaluated in a scene with an object
_RETURN_SECONDS = 0.25
_REST_REACH, _REST_FORCE, _REST_SECONDS = 1e-6, 0.020, 0.050
# m: positions searched for a restoring force
PLACES = np.linspace(-0.045, 0.045, 901)
# N: forces with which a hand presses on a scene that only pushes back; largest such force as a fraction of
# the scene's or the motor's force
_PRESSES, _PRESSED = (1.0, 2.0), 0.6
# N/m: stiffness that sets the time scale of a scene without a spring, and the smallest one for any scene
_SPRINGLESS, _SOFTEST = 100.0, 1.0
# an oscillation with a larger fraction of clamped samples is bounded by the force limit
_AT_LIMIT = 0.05


@dataclass(frozen=True)
class Lasting:
    """A sustained oscillation: amplitude in m, frequency in Hz (NaN with too few cycles).

    ``clamped`` is the fraction of clamped samples. If ``irregular`` is not 0, the amplitude varies, up to
    this value.
    """

    amplitude: float
    frequency: float = math.nan
    clamped: float = 0.0
    irregular: bool = False

    @property
    def at_limit(self) -> bool:
        """Return True if the motor's force limit bounds the oscillation."""
        return self.clamped > _AT_LIMIT


@dataclass(frozen=True)
class Behaviour:
    """The behaviour of a handle that is released without speed at a distance from a scene's centre.

    ``push`` is the largest displacement in m from which the handle settles; inf if it settles from all
    displacements tried, 0 if from none. From larger displacements it leaves (beyond 60 mm) or oscillates;
    with quantisation several limit cycles coexist. ``least`` and ``most`` are the smallest and the largest
    amplitude over all displacements, and are equal if there is only one. ``often`` contains the lowest and
    the highest frequency in Hz. ``flick`` is the initial speed in m/s that corresponds to a push of 1 m in a
    scene without a restoring force, else 0. ``trembles`` is True if the handle keeps moving by less than one
    sensor step peak to peak, while its force keeps changing. If the behaviour was not determined, ``unknown``
    contains sentences with the reason; otherwise it is "".
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
        """Return True if the handle settles from any displacement."""
        return self.push == math.inf

    @property
    def spontaneous(self) -> bool:
        """Return True if the oscillation needs no knock: it starts at the smallest displacement."""
        return not self.calm and not self.push and not self.unknown

    @property
    def sign(self) -> tuple[str, str]:
        """Return icon and colour: red if the oscillation starts by itself, amber if a knock must start it."""
        if self.unknown:
            return "circle", "ink2"
        if self.calm:
            return "check", "ok"
        return ("cross", "danger") if self.spontaneous else ("triangle", "warn")

    def sentence(self, in_hand: bool) -> str:
        """Return a sentence such as "In your hand, a push of more than 0.22 mm makes the handle buzz."."""
        where = "In your hand" if in_hand else "After you let go"
        if self.unknown:
            return f"{where}, the stability is not judged. {self.unknown}"
        if self.calm:
            trembles = " (it moves by less than one sensor step)" if self.trembles else ""
            return f"{where}, the handle is stable{trembles}."
        if self.spontaneous:
            does = self._joined(f"buzzes by itself{self.swing}", "flies away by itself")
            return f"{where}, the handle {does}."
        edge = with_unit(self.push * self.flick, "m/s", 2) if self.flick else on_screen(self.push, "m", 2)
        if in_hand:
            knock = f"a flick faster than {edge}" if self.flick else f"a push of more than {edge}"
            return (
                f"{where}, {knock} "
                f"{self._joined(f'makes the handle buzz{self.swing}', 'throws the handle away')}."
            )
        start = (
            f"flick the handle faster than {edge}"
            if self.flick
            else f"displace the handle by more than {edge}"
        )
        return f"If you {start} and let go, it {self._joined(f'buzzes{self.swing}', 'flies away')}."

    def _joined(self, buzzes: str, leaves: str) -> str:
        return " or ".join([buzzes] * bool(self.most) + [leaves] * self.leaves)

    @property
    def swing(self) -> str:
        """Return frequency and amplitude, as in " at 30 Hz (±2.3 mm, the motor's limit)"; "" if calm.

        The text is " at 14 to 16 Hz (±0.05 to ±0.5 mm)" if several limit cycles exist.
        """
        if self.least is None or self.most is None:
            return ""
        smallest, largest = (on_screen(one.amplitude, "m", 2) for one in (self.least, self.most))
        size = f"±{largest}"
        often = ""
        if self.most.irregular:
            often, size = " irregularly", f"up to {size}"
        elif self.often:
            slow, fast = self.often
            one = math.isclose(slow, fast, rel_tol=_SAME_SPEED)
            often = (
                f" at {hertz(0.5 * (slow + fast))}"
                if one
                else f" at {hertz(slow).removesuffix(' Hz')} to {hertz(fast)}"
            )
        if smallest != largest and not self.most.irregular:
            size = f"±{with_unit(1e3 * self.least.amplitude, digits=2)} to {size}"
        limited = ", held back by the motor's limit" if self.most.at_limit else ""
        return f"{often} ({size}{limited})"


@dataclass(frozen=True)
class Centre:
    """The starting point of trials: position in m, the hand's target in m, direction of the push.

    ``returns`` is True if the force is restoring on both sides. ``kick`` is the initial speed in m/s that
    corresponds to a push of 1 m in a scene without a restoring force.
    """

    position: float
    target: float
    side: float = 1.0
    returns: bool = True
    kick: float = 0.0

    @property
    def pushes(self) -> bool:
        """Return True if the law only pushes the handle away."""
        return not self.returns and not self.kick


class Trials:
    """One scene that is prepared for many releases of the handle."""

    def __init__(self, scene: headless.Scene, grip: Grip | None, centre: Centre):
        r, body = scene.prepare()
        self._title = scene.environment.title
        self._r, self._body, self._flat = packed(r, body)
        self._made = self._flat.copy()
        self._hand = np.array([grip.mass, grip.damping, grip.stiffness]) if grip else np.zeros(3)
        # If the delay is longer than the spring's period, a loop oscillates with a period of two to four
        # delays.
        self._turns = _TURNS * (2.0 * math.pi / _natural(scene, grip) + 4.0 * scene.loop.delay)
        # an object may come back to the handle after the handle has come to rest
        self._objects = _RETURN_SECONDS if scene.environment.stored else 0.0
        self._rate = scene.loop.rate
        rest = max(_REST_SECONDS + scene.loop.delay, settling.CALM_WINDOWS * self._objects)
        still = math.ceil(rest * scene.loop.rate)
        far = _ENDLESS if centre.kick else _FAR
        self._quiet = settling.Quiet(
            _REST_REACH, scene.device.quantum, _REST_FORCE, still, far, drifts=centre.kick > 0.0
        )
        self.centre, self.step = centre, scene.device.quantum
        # Quantisation rounds down, so the two sides differ and both are tried. A scene that only pushes needs
        # one side.
        self.sides = (1.0,) if centre.pushes else (1.0, -1.0)
        # an ideal handle never stops completely: its motion only decays
        self._ideal = scene.device.coulomb_force == 0.0 and scene.device.quantum == 0.0
        self._row, self._swing = np.zeros(rows.ROW_WIDTH), settling.new_swing()
        self.samples, self.trembles = 0, False

    def end(self, push: float, longer: int = 1, known: bool = False) -> int:
        """Release the handle at ``push`` m from the centre and simulate; return how the run ended.

        ``longer`` multiplies the evaluated time. If ``known`` is true, stop as soon as it is certain
        whether the handle settles; otherwise continue until the oscillation is steady.
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
        """Return True if the handle settles after a push in m, or leaves a scene that only pushes it away."""
        return all(self._settled(self.end(side * push, known=True)) for side in self.sides)

    def _settled(self, end: int) -> bool:
        """Return True if the last run ended at rest, or with a motion within one sensor step peak to peak."""
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
        """Return the last run's peak-to-peak motion in m, after removing drift."""
        return float(self._swing.reach[0])

    @property
    def _frequency(self) -> float:
        """Return the last run's frequency in Hz; NaN if its last half has too few cycles."""
        frequency = float(self._swing.frequency[0])
        cycles = frequency * 0.5 * float(self._swing.samples[0]) / self._rate
        return frequency if cycles >= LEAST_CYCLES else math.nan

    def swings(self, push: float, longer: int = 1) -> list[Lasting | None]:
        """Release the handle on each side at ``push`` m; return the oscillations, None if the handle left."""
        found: list[Lasting | None] = []
        for side in self.sides:
            end = self.end(side * push, longer=longer)
            if self._settled(end):
                continue
            numbers = 0.5 * self._reach, self._frequency, float(self._swing.clamped[0])
            found.append(None if end == LEAVES else Lasting(*numbers, end == IRREGULAR))
        return found


def centres_of(scene: headless.Scene, grip: Grip | None) -> list[Centre]:
    """Return the points of the strongest restoring force, or points at which a hand presses on the scene."""
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
    if grip is None:  # release the handle at the surface, towards the inside
        touched = np.flatnonzero(against > 0.0)[0]
        return [Centre(float(places[max(touched - 1, 0)]), 0.0, side, returns=False)]
    presses = sorted({min(press, _PRESSED * most) for press in _PRESSES})
    found = [_first_position(places, against, press) for press in presses]
    return [
        Centre(place, place + side * press / grip.stiffness, side, returns=False)
        for place, press in zip(found, presses, strict=True)
    ]


def _first_position(places: np.ndarray, force: np.ndarray, wanted: float) -> float:
    """Return the first of the positions (n,) in m at which the force (n,) reaches ``wanted`` N."""
    i = int(np.flatnonzero(force >= wanted)[0])
    if i == 0:
        return float(places[0])
    share = (wanted - force[i - 1]) / (force[i] - force[i - 1])
    return float(places[i - 1] + share * (places[i] - places[i - 1]))


def _natural(scene: headless.Scene, grip: Grip | None) -> float:
    """Return the natural frequency in rad/s of the handle on the scene's spring."""
    own = scene.environment.impedance
    stiffness = (own(scene.values)[0] if own else 0.0) + (grip.stiffness if grip else 0.0)
    mass = scene.device.mass + (grip.mass if grip else 0.0)
    return math.sqrt(max(stiffness or _SPRINGLESS, _SOFTEST) / mass)


def behaviour(scene: headless.Scene, grip: Grip | None) -> Behaviour:
    """Return the handle's behaviour in a scene, in a grip or released (None), over all starting points.

    The behaviour is unknown if the law is too slow.
    """
    try:
        tried = [Trials(scene, grip, centre) for centre in centres_of(scene, grip)]
        edges, found = zip(*(_boundary_and_swings(trials) for trials in tried), strict=True)
    except LawError as error:
        return Behaviour(0.0, unknown=str(error))
    summary = _summary(tried[0], min(edges), [one for some in found for one in some])
    return replace(summary, trembles=any(trials.trembles for trials in tried))


def settles(scene: headless.Scene, grip: Grip | None, push: float) -> bool:
    """Return True if a handle settles after a push in m, from all starting points of a grip.

    Raise LawError if the law is too slow.
    """
    return all(Trials(scene, grip, centre).settles(push) for centre in centres_of(scene, grip))


def _boundary_and_swings(trials: Trials) -> tuple[float, list[Lasting | None]]:
    """Return the largest push in m after which the handle settles, and oscillations after larger pushes.

    The push is inf if the handle settles after every push.
    """
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
    # damping in a grip often has a second, small limit cycle, which only few pushes reach
    if trials.centre.kick:
        beyond = [times * edge for times in _BEYOND] if calm else []
        larger = [*beyond, *larger, *(other for other in _FINER if other > edge)]
    for other in larger:
        if trials.samples < (_KICKED_SAMPLES if trials.centre.kick else _SAMPLES):
            found += trials.swings(other)
    return calm, found


def _summary(trials: Trials, calm: float, found: list[Lasting | None]) -> Behaviour:
    """Return the behaviour: the smallest and the largest oscillation, and whether the handle leaves."""
    swings = sorted((one for one in found if one), key=lambda one: one.amplitude)
    behaviour = Behaviour(calm, leaves=None in found, flick=trials.centre.kick if found else 0.0)
    if not swings:
        return behaviour
    least, most = swings[0], swings[-1]
    if most.amplitude - least.amplitude <= max(_SAME * least.amplitude, trials.step):
        least = most
    heard = [one.frequency for one in swings if math.isfinite(one.frequency) and not one.irregular]
    return replace(behaviour, least=least, most=most, often=(min(heard), max(heard)) if heard else None)
