"""The passivity observer and controller in the time domain (Hannaford & Ryu, 2002), between law and guard.

The observer sums the energy given to handle and hand and compares it with a limit: what the law could give
from where the observer began. The law itself is asked for that, at rest at every place, a few places a tick,
its state held: the highest work of its force. A law without a state can be told everywhere what it still may
give, so its limit follows down, and energy that a damper took excuses nothing later; objects that move say
what they hold. What the paddle's own damping takes of an excess lifts the limit.

Sensor steps feign no energy: where the reading goes on by one count the handle has just passed the edge
between the two, so a slow way in and out again, on the same edges, sums up to nothing.

Nor do they feign damping. b v² of every count's difference is more than the damping takes, because counts
jump where the handle glides. That is right for an alarm, which may not be false, but a controller that trusts
it lets energy grow. So there are two limits: an alarm goes by the generous one, the controller by the strict
one, which only what the counts prove lifts. Of all motions through the same counts, the one that goes
straight on until an edge makes it turn has the least integral of v².

Nor does a delay of part of a period hide anything from the controller: what a force that changes on the way
gives beyond its mean is taken at its most, for a free handle. What a controller can hold is limited by its
damping, late itself: a spring where K (T/2 + td) - b is up to 0.75 of most_damping; from 0.9 on, the motor's
force limit alone ends the growth.
"""

import math

import numpy as np

from hapkit_studio.dynamics.jit import inlined, internal
from hapkit_studio.haptics import arrays, block, rows
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.laws.native import LAW_FUEL, call

# Energy of a force and a length that fingers do not feel (0.3 N, 0.4 mm), in J.
FELT = 0.12e-3
# Counts by which the sensor may err at the highest force: a count at either end of the way, half a count as
# the reading lags behind, and where the limit follows, the same once more.
COUNTS = 4.0
# Forces at so many times so many m to either side are known; so many of them are asked for a tick, each side,
# more where the handle is faster, up to so many: what it could give is known before it is given.
CELLS, CELL, A_TICK, MOST_A_TICK = 640, 0.125e-3, 4, 64
A_METRE = 1.0 / CELL
# Passes of loops that one call of the law may take, and all calls of a tick: a law that takes more is not
# asked, and what it can give stays unknown.
MOST_PASSES, PASSES_A_TICK = 250, 2000
# Of a period, in a live loop: the law's own call and those of the observer.
MOST_SHARE = 0.5
# A controller's damping stays below this share of mass over period and delay: of a spring of K = 0, theory
# 1.3, the stable ones are 2.0 and, a period late, 0.83; with a stiff spring and both, the best is 0.42.
SAFE = 0.25
# The most force a controller adds, as a share of the device's.
SHARE = 0.5

# --- numbers in r.watch
GIVEN, LIMIT, EXCESS, STRICT, STRICT_EXCESS, MOST, EDGE, SINCE, IMPULSE, PEAK, SPEED, START = range(12)
ENDS = 12  # the force at the last place asked for on the left, on the right
# The straightest motion: where it turned last, the time since then, the integral of v² until then and until
# now; the least and the most velocity since then that pass all counts, each with the time of the count.
TURN, LASTED, BEFORE, SQUARES, LEAST, GREATEST = 14, 15, 16, 17, 18, 20
EFFECT = 22  # the mean force in N over the last period
FROZEN = 24  # the law's state when the observer began
SCRATCH = FROZEN + rows.STATES
WORK = SCRATCH + rows.STATES  # work in J of the law's force from the beginning to each place, 2 CELLS + 1
HELD = rows.STOPPED | rows.FAULT | rows.STALE | rows.FADING


def most_damping(mass: float, period: float, delay: float) -> float:
    """Return the most damping in N·s/m that a controller may add, of mass kg, period s and delay s."""
    return SAFE * mass / (period + delay)


@inlined
def watch(r: LoopArrays, position: float, effect: float, period: float) -> None:
    """Sum up the energy given since the last sample by the mean force in N in effect since then."""
    w = r.watch
    moved = position - r.real[arrays.LAST_POSITION]
    controlled = r.values[block.DAMPER] != 0.0
    if controlled:
        w[STRICT] -= untold(r, effect)
    if moved == 0.0:
        w[SINCE] += period
        w[IMPULSE] += effect * period
        w[SPEED] = 0.0
        return
    quantum, viscous = r.values[block.QUANTUM], r.values[block.VISCOUS]
    edge = 0.5 * quantum
    elapsed = w[SINCE] + period
    proven = 0.0
    if controlled:
        proven = viscous * straighten(w, position, edge, elapsed)
    if abs(moved) <= 1.5 * quantum:
        if w[SINCE] > 0.0:
            edge *= period / elapsed  # half a sample past it
            effect = (w[IMPULSE] + effect * period) / elapsed
            period = elapsed
        if moved < 0.0:
            edge = quantum - edge
    w[SINCE] = w[IMPULSE] = 0.0
    travelled = moved + edge - w[EDGE]
    w[EDGE] = edge
    w[SPEED] = speed = travelled / period
    w[GIVEN] += effect * travelled
    if abs(effect) > w[PEAK]:
        w[PEAK] = abs(effect)
    compare(r, position + edge - 0.5 * quantum, viscous * travelled * speed, proven)


@inlined
def untold(r: LoopArrays, effect: float) -> float:
    """Return the most work in J that the change to another mean force in N gave beyond the mean's.

    A force that changes by dF at a share d of a period gives a free handle d (1 - d) T² / 2m dF
    ((1/2 - d) dF - b v) more, and what comes and goes with F². The worst d: 1/24 and 1/8 for its two terms.
    """
    w, values = r.watch, r.values
    change, w[EFFECT] = effect - w[EFFECT], effect
    mass = values[block.DAMPER] * (values[block.PERIOD] + values[block.DELAY]) / SAFE
    more = change / 24.0 - values[block.VISCOUS] * w[SPEED] / 8.0
    return values[block.PERIOD] ** 2 / mass * change * more


@inlined
def straighten(w: np.ndarray, position: float, half: float, elapsed: float) -> float:
    """Lead the straightest motion through one more count, half of it in m; return how v² dt grew in m²/s."""
    w[LASTED] += elapsed
    ahead = position - w[TURN]
    if ahead - half > w[GREATEST] * w[LASTED]:
        turn(w, GREATEST)
    elif ahead + half < w[LEAST] * w[LASTED]:
        turn(w, LEAST)
    ahead = position - w[TURN]
    least, greatest = (ahead - half) / w[LASTED], (ahead + half) / w[LASTED]
    if least >= w[LEAST]:
        w[LEAST], w[LEAST + 1] = least, w[LASTED]
    if greatest <= w[GREATEST]:
        w[GREATEST], w[GREATEST + 1] = greatest, w[LASTED]
    slowest = min(max(w[LEAST], 0.0), w[GREATEST])
    before = w[SQUARES]
    w[SQUARES] = w[BEFORE] + slowest * slowest * w[LASTED]
    return w[SQUARES] - before


@inlined
def turn(w: np.ndarray, at: int) -> None:
    """Turn at the edge of the count that LEAST or GREATEST stands for; up to there the motion is known."""
    velocity, time = w[at], w[at + 1]
    w[TURN] += velocity * time
    w[BEFORE] += velocity * velocity * time
    w[LASTED] -= time
    w[LEAST], w[GREATEST] = -math.inf, math.inf


@inlined
def compare(r: LoopArrays, position: float, taken: float, proven: float) -> None:
    """Compare what was given with both limits; what the damping took, and what of it is proven, is in J."""
    w, asked = r.watch, r.word[arrays.ASKED]
    cell = (position - w[START]) * A_METRE
    follows = r.words[block.N_STATE] == 0
    if asked <= CELLS if not follows else abs(cell) >= asked - 1:
        w[LIMIT] += taken
        w[STRICT] += proven
        return
    level = w[GIVEN]
    if follows:  # and what a law without a state can still give
        below = math.floor(cell)
        i = WORK + CELLS + int(below)
        level += w[MOST] - (w[i] + (cell - below) * (w[i + 1] - w[i]))
    settle(w, LIMIT, level, taken, follows)
    if r.values[block.DAMPER] != 0.0:  # nobody else goes by it, and it costs 0.5 ns
        settle(w, STRICT, level, proven, follows)


@inlined
def settle(w: np.ndarray, at: int, level: float, taken: float, follows: bool) -> None:
    """Keep one limit and the excess beside it: damping lifts the limit by any excess."""
    excess = level - w[at]
    if excess > 0.0:
        lifted = min(taken, excess)
        w[at] += lifted
        excess -= lifted
    elif follows:
        w[at] = level
        excess = 0.0
    w[at + 1] = excess


@inlined
def threshold(r: LoopArrays) -> float:
    """Return the excess in J that means something: it would be felt, and no sensor step can feign it."""
    return FELT + COUNTS * r.values[block.QUANTUM] * r.watch[PEAK]


@inlined
def control(r: LoopArrays, period: float) -> float:
    """Return the force in N to take off, along the motion, so that the excess is gone within a period."""
    w = r.watch
    most = r.values[block.DAMPER]
    if most == 0.0 or w[STRICT_EXCESS] <= FELT:
        return 0.0
    excess, speed = w[STRICT_EXCESS] - threshold(r), w[SPEED]
    if excess <= 0.0 or speed == 0.0:
        return 0.0
    push = min(excess / (period * speed * speed), most) * abs(speed)
    return math.copysign(min(push, SHARE * r.values[block.MAX_FORCE]), speed)


@inlined
def judge(r: LoopArrays, taken: float, position: float, period: float, row: np.ndarray) -> None:
    """Write the flags and the row's energies; restart the observer after every change of the rendered law."""
    w, word = r.watch, r.word
    flags = word[arrays.FLAGS]
    if flags & HELD or r.real[arrays.RAMP] < 1.0 or word[arrays.RENEW]:
        word[arrays.RENEW] = word[arrays.ASKED] = 0
        w[GIVEN] = w[LIMIT] = w[EXCESS] = w[STRICT] = w[STRICT_EXCESS] = 0.0
        row[rows.ENERGY_GIVEN] = row[rows.ENERGY_LIMIT] = math.nan
        return
    if word[arrays.ASKED] <= CELLS:
        ask(r, position, period)
    if taken != 0.0:
        flags |= rows.DAMPED
    if w[EXCESS] > FELT and w[EXCESS] > threshold(r):
        flags |= rows.ACTIVE
    word[arrays.FLAGS] = flags
    row[rows.ENERGY_GIVEN], row[rows.ENERGY_LIMIT] = w[GIVEN], w[LIMIT]


@internal
def force_at(r: LoopArrays, position: float, period: float) -> float:
    """Return the force in N that the law's beginning gives at rest at a place, as far as the motor can."""
    w, fault = r.watch, r.word[arrays.SPARE :]
    for i in range(rows.STATES):
        w[SCRATCH + i] = w[FROZEN + i]
    slot = r.word[arrays.SLOT]
    fault[3] = MOST_PASSES
    r.word[arrays.CALLS] += 1
    force = call(r.laws[slot], r.params[slot], w[SCRATCH:WORK], position, 0.0, period, fault)
    if not math.isfinite(force) or fault[0]:
        if fault[0] == LAW_FUEL:
            r.word[arrays.OPAQUE] = 1
        fault[0] = 0
        fault[1] = MOST_PASSES
        return 0.0
    limit = r.values[block.MAX_FORCE]
    return min(max(force, -limit), limit)


@internal
def ask(r: LoopArrays, position: float, period: float) -> None:
    """Ask the law for its force at the next places, and sum up the work on the way to them."""
    w, word = r.watch, r.word
    if word[arrays.ASKED] == 0:
        begin(r, position, period)
    passes, left = PASSES_A_TICK, word[arrays.SPARE + 1 : arrays.SPARE + 2]
    for cell in range(word[arrays.ASKED], reach(r, position, period)):
        for side in range(2):
            sign = 2 * side - 1
            force, before = sign * force_at(r, w[START] + sign * cell * CELL, period), w[ENDS + side]
            passes -= MOST_PASSES - left[0]
            w[ENDS + side] = force
            there = WORK + CELLS + sign * cell
            if before > 0.0 > force:
                lift(w, w[there - sign] + 0.5 * before * CELL * before / (before - force))
            w[there] = w[there - sign] + 0.5 * (force + before) * CELL
            lift(w, w[there])
        if word[arrays.OPAQUE]:
            return
        word[arrays.ASKED] = cell + 1
        if passes <= 0:
            return


@internal
def reach(r: LoopArrays, position: float, period: float) -> int:
    """Return up to which cell to ask: past where the handle is after another period, twice as fast.

    A live loop asks for no more than its law has time for.
    """
    w, asked, each = r.watch, r.word[arrays.ASKED], r.real[arrays.LAW_TIME]
    if r.word[arrays.OPAQUE]:
        return asked
    cells = 2.0 + A_METRE * (abs(position - w[START]) + 2.0 * period * abs(w[SPEED]))
    upto = asked + A_TICK
    if cells > upto:
        upto = min(asked + MOST_A_TICK, int(min(cells, 2.0 * CELLS)))
    if each > 0.0:
        upto = min(upto, asked + int(0.5 * max(MOST_SHARE * r.values[block.PERIOD] / each - 1.0, 0.0)))
    return min(upto, CELLS + 1)


@internal
def lift(w: np.ndarray, work: float) -> None:
    """Raise what the law can give to a work in J."""
    if work > w[MOST]:
        w[LIMIT] += work - w[MOST]
        w[STRICT] += work - w[MOST]
        w[MOST] = work


@internal
def begin(r: LoopArrays, position: float, period: float) -> None:
    """Begin here: nothing given, nothing known of what the law can give but what its objects hold."""
    w = r.watch
    r.word[arrays.OPAQUE] = 0
    for i in range(FROZEN):
        w[i] = 0.0
    slot = r.word[arrays.SLOT]
    for i in range(rows.STATES):
        w[FROZEN + i] = r.states[slot, i]
    w[START] = w[TURN] = position
    w[LEAST], w[GREATEST] = -math.inf, math.inf
    w[WORK + CELLS] = 0.0
    force = force_at(r, position, period)
    w[ENDS], w[ENDS + 1] = -force, force
    r.word[arrays.ASKED] = 1
    if r.words[block.STORED]:
        fault = r.word[arrays.SPARE :]
        held = call(r.words[block.STORED], r.params[slot], w[FROZEN:SCRATCH], position, 0.0, period, fault)
        w[LIMIT] = w[STRICT] = w[MOST] = held if math.isfinite(held) else 0.0
        r.word[arrays.ASKED] = CELLS + 1
