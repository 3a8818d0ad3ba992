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
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.arrays import CELLS, LoopArrays
from hapkit_studio.haptics.record import Record
from hapkit_studio.laws.native import LAW_FUEL, call

# Energy of a force and a length that fingers do not feel (0.3 N, 0.4 mm), in J.
FELT = 0.12e-3
# Counts by which the sensor may err at the highest force: a count at either end of the way, half a count as
# the reading lags behind, and where the limit follows, the same once more.
COUNTS = 4.0
# Forces at so many times so many m to either side are known; so many of them are asked for a tick, each side,
# more where the handle is faster, up to so many: what it could give is known before it is given.
CELL, A_TICK, MOST_A_TICK = 0.125e-3, 4, 64
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

HELD = rows.STOPPED | rows.FAULT | rows.STALE | rows.FADING


def most_damping(mass: float, period: float, delay: float) -> float:
    """Return the most damping in N·s/m that a controller may add, of mass kg, period s and delay s."""
    return SAFE * mass / (period + delay)


@inlined
def watch(r: LoopArrays, position: float, effect: float, period: float) -> None:
    """Sum up the energy given since the last sample by the mean force in N in effect since then."""
    w = r.watch
    moved = position - r.tick.last_position
    controlled = r.settings.damper != 0.0
    if controlled:
        w.strict.limit -= untold(r, effect)
    if moved == 0.0:
        w.since += period
        w.impulse += effect * period
        w.speed = 0.0
        return
    quantum, viscous = r.settings.quantum, r.settings.viscous
    edge = 0.5 * quantum
    elapsed = w.since + period
    proven = 0.0
    if controlled:
        proven = viscous * straighten(w, position, edge, elapsed)
    if abs(moved) <= 1.5 * quantum:
        if w.since > 0.0:
            edge *= period / elapsed  # half a sample past it
            effect = (w.impulse + effect * period) / elapsed
            period = elapsed
        if moved < 0.0:
            edge = quantum - edge
    w.since = w.impulse = 0.0
    travelled = moved + edge - w.edge
    w.edge = edge
    w.speed = speed = travelled / period
    w.given += effect * travelled
    if abs(effect) > w.peak:
        w.peak = abs(effect)
    compare(r, position + edge - 0.5 * quantum, viscous * travelled * speed, proven)


@inlined
def untold(r: LoopArrays, effect: float) -> float:
    """Return the most work in J that the change to another mean force in N gave beyond the mean's.

    A force that changes by dF at a share d of a period gives a free handle d (1 - d) T² / 2m dF
    ((1/2 - d) dF - b v) more, and what comes and goes with F². The worst d: 1/24 and 1/8 for its two terms.
    """
    w, settings = r.watch, r.settings
    change, w.effect = effect - w.effect, effect
    mass = settings.damper * (settings.period + settings.delay) / SAFE
    more = change / 24.0 - settings.viscous * w.speed / 8.0
    return settings.period**2 / mass * change * more


@inlined
def straighten(w: Record, position: float, half: float, elapsed: float) -> float:
    """Lead the straightest motion through one more count, half of it in m; return how v² dt grew in m²/s."""
    w.lasted += elapsed
    ahead = position - w.turn
    if ahead - half > w.greatest * w.lasted:
        turn(w, w.greatest, w.greatest_time)
    elif ahead + half < w.least * w.lasted:
        turn(w, w.least, w.least_time)
    ahead = position - w.turn
    least, greatest = (ahead - half) / w.lasted, (ahead + half) / w.lasted
    if least >= w.least:
        w.least, w.least_time = least, w.lasted
    if greatest <= w.greatest:
        w.greatest, w.greatest_time = greatest, w.lasted
    slowest = min(max(w.least, 0.0), w.greatest)
    before = w.squares
    w.squares = w.before + slowest * slowest * w.lasted
    return w.squares - before


@inlined
def turn(w: Record, velocity: float, time: float) -> None:
    """Turn after a time in s at a velocity in m/s, at a count's edge; the motion up to there is known."""
    w.turn += velocity * time
    w.before += velocity * velocity * time
    w.lasted -= time
    w.least, w.greatest = -math.inf, math.inf


@inlined
def compare(r: LoopArrays, position: float, taken: float, proven: float) -> None:
    """Compare what was given with both limits; what the damping took, and what of it is proven, is in J."""
    w = r.watch
    known = w.cells_known
    cell = (position - w.start) * A_METRE
    follows = r.settings.n_state == 0
    if known <= CELLS if not follows else abs(cell) >= known - 1:
        w.alarm.limit += taken
        w.strict.limit += proven
        return
    level = w.given
    if follows:  # and what a law without a state can still give
        below = math.floor(cell)
        i, work = CELLS + int(below), w.work
        level += w.most - (work[i] + (cell - below) * (work[i + 1] - work[i]))
    settle(w.alarm, level, taken, follows)
    if r.settings.damper != 0.0:  # nobody else goes by it, and it costs 0.5 ns
        settle(w.strict, level, proven, follows)


@inlined
def settle(limit: Record, level: float, taken: float, follows: bool) -> None:
    """Update a limit and the excess over it, in J: what the damping took lifts the limit by any excess."""
    excess = level - limit.limit
    if excess > 0.0:
        lifted = min(taken, excess)
        limit.limit += lifted
        excess -= lifted
    elif follows:
        limit.limit = level
        excess = 0.0
    limit.excess = excess


@inlined
def threshold(r: LoopArrays) -> float:
    """Return the excess in J that means something: it would be felt, and no sensor step can feign it."""
    return FELT + COUNTS * r.settings.quantum * r.watch.peak


@inlined
def control(r: LoopArrays, period: float) -> float:
    """Return the force in N to take off, along the motion, so that the excess is gone within a period."""
    w = r.watch
    most = r.settings.damper
    if most == 0.0 or w.strict.excess <= FELT:
        return 0.0
    excess, speed = w.strict.excess - threshold(r), w.speed
    if excess <= 0.0 or speed == 0.0:
        return 0.0
    push = min(excess / (period * speed * speed), most) * abs(speed)
    return math.copysign(min(push, SHARE * r.settings.max_force), speed)


@inlined
def judge(r: LoopArrays, taken: float, position: float, period: float, row: np.ndarray) -> None:
    """Write the flags and the row's energies; restart the observer after every change of the rendered law."""
    w, t = r.watch, r.tick
    flags = t.row_flags
    if flags & HELD or r.tick.ramp < 1.0 or w.renew:
        w.renew = w.cells_known = 0
        w.given = w.alarm.limit = w.alarm.excess = w.strict.limit = w.strict.excess = 0.0
        row[rows.ENERGY_GIVEN] = row[rows.ENERGY_LIMIT] = math.nan
        return
    if w.cells_known <= CELLS:
        ask(r, position, period)
    if taken != 0.0:
        flags |= rows.DAMPED
    if w.alarm.excess > FELT and w.alarm.excess > threshold(r):
        flags |= rows.ACTIVE
    t.row_flags = flags
    row[rows.ENERGY_GIVEN], row[rows.ENERGY_LIMIT] = w.given, w.alarm.limit


@internal
def force_at(r: LoopArrays, position: float, period: float) -> float:
    """Return the force in N that the law's beginning gives at rest at a place, as far as the motor can."""
    w = r.watch
    fault = w.fault
    for i in range(rows.STATES):
        w.scratch[i] = w.frozen[i]
    slot = r.tick.slot
    fault[3] = MOST_PASSES
    w.calls += 1
    force = call(r.laws[slot], r.params[slot], w.scratch, position, 0.0, period, fault)
    if not math.isfinite(force) or fault[0]:
        if fault[0] == LAW_FUEL:
            w.opaque = 1
        fault[0] = 0
        fault[1] = MOST_PASSES
        return 0.0
    limit = r.settings.max_force
    return min(max(force, -limit), limit)


@internal
def ask(r: LoopArrays, position: float, period: float) -> None:
    """Ask the law for its force at the next places, and sum up the work on the way to them."""
    w = r.watch
    if w.cells_known == 0:
        begin(r, position, period)
    passes, work = PASSES_A_TICK, w.work
    for cell in range(w.cells_known, reach(r, position, period)):
        for side in range(2):
            sign = 2 * side - 1
            force, before = sign * force_at(r, w.start + sign * cell * CELL, period), w.ends[side]
            passes -= MOST_PASSES - w.fault[1]
            w.ends[side] = force
            there = CELLS + sign * cell
            if before > 0.0 > force:
                lift(w, work[there - sign] + 0.5 * before * CELL * before / (before - force))
            work[there] = work[there - sign] + 0.5 * (force + before) * CELL
            lift(w, work[there])
        if w.opaque:
            return
        w.cells_known = cell + 1
        if passes <= 0:
            return


@internal
def reach(r: LoopArrays, position: float, period: float) -> int:
    """Return up to which cell to ask: past where the handle is after another period, twice as fast.

    A live loop asks for no more than its law has time for.
    """
    w, each = r.watch, r.tick.law_time
    known = w.cells_known
    if w.opaque:
        return known
    cells = 2.0 + A_METRE * (abs(position - w.start) + 2.0 * period * abs(w.speed))
    upto = known + A_TICK
    if cells > upto:
        upto = min(known + MOST_A_TICK, int(min(cells, 2.0 * CELLS)))
    if each > 0.0:
        upto = min(upto, known + int(0.5 * max(MOST_SHARE * r.settings.period / each - 1.0, 0.0)))
    return min(upto, CELLS + 1)


@internal
def lift(w: Record, work: float) -> None:
    """Raise what the law can give to a work in J."""
    if work > w.most:
        w.alarm.limit += work - w.most
        w.strict.limit += work - w.most
        w.most = work


@internal
def begin(r: LoopArrays, position: float, period: float) -> None:
    """Begin here: nothing given, nothing known of what the law can give but what its objects hold."""
    w = r.watch
    w.opaque = 0
    w.given = w.alarm.limit = w.alarm.excess = w.strict.limit = w.strict.excess = w.most = 0.0
    w.edge = w.since = w.impulse = w.peak = w.speed = w.effect = 0.0
    w.lasted = w.before = w.squares = 0.0
    slot = r.tick.slot
    for i in range(rows.STATES):
        w.frozen[i] = r.states[slot, i]
    w.start = w.turn = position
    w.least, w.greatest = -math.inf, math.inf
    w.work[CELLS] = 0.0
    force = force_at(r, position, period)
    w.ends[0], w.ends[1] = -force, force
    w.cells_known = 1
    if r.settings.stored:
        held = call(r.settings.stored, r.params[slot], w.frozen, position, 0.0, period, w.fault)
        w.alarm.limit = w.strict.limit = w.most = held if math.isfinite(held) else 0.0
        w.cells_known = CELLS + 1
