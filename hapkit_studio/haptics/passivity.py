"""The passivity observer and controller in the time domain (Hannaford & Ryu, 2002), between law and guard.

The observer sums the energy that the law gives to handle and hand, and compares it with a limit: the energy
that the law can give from the position at which the observer started. This limit is the maximum work of the
law's static force. To compute it, the observer divides the travel into cells, and calls the law, at rest and
with its initial state, in a few more cells in every tick. For a law without a state the limit also decreases
as the handle moves, so energy that a damper took earlier does not excuse energy given later. A law with
moving objects reports the energy stored in them. Energy dissipated by the damping of the paddle raises the
limit, at most by the excess.

Quantisation causes no apparent energy. When the reading changes by one count, the handle is exactly at the
edge between both counts, so a slow motion in and out over the same edges sums to zero.

Quantisation causes no apparent damping either. A sum of b v² over differences of counts overestimates the
dissipation, because counts jump while the handle glides. An optimistic limit is acceptable for an alarm,
which must not be false, but not for a controller. Therefore there are two limits: a tolerant one for the
alarm, and a strict one for the controller. Only dissipation that is proven by the counts raises the strict
limit. Of all motions through the same counts, the motion that keeps its velocity until an edge forces it to
turn has the smallest integral of v².

A delay of a fraction of a period is covered as well. If the force changes within a period, the controller
assumes the largest energy, beyond that of the mean force, that a free handle can get. The controller's effect
is limited, because its damping is limited and delayed: it stabilises a spring if K (T/2 + td) - b is at most
0.75 of most_damping. Above 0.9, only the motor's force limit ends the growth.
"""

import math

import numpy as np

from hapkit_studio.dynamics.jit import inlined, internal
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.arrays import CELLS, LoopArrays
from hapkit_studio.haptics.record import Record
from hapkit_studio.laws.native import LAW_FUEL, call

# J: energy that fingers do not feel, 0.3 N over 0.4 mm
FELT = 0.12e-3
# Sensor error in counts at the largest force: one count at either end of the path, and half a count of delay.
# If the limit follows the handle, the same error occurs a second time.
COUNTS = 4.0
# Width of a cell in m, and the number of cells per tick and side for which the law is called. While the
# handle moves fast this number is larger, up to the maximum, so that the possible energy is known before it
# is given.
CELL, A_TICK, MOST_A_TICK = 0.125e-3, 4, 64
A_METRE = 1.0 / CELL
# Largest number of loop iterations in one call of the law, and in all calls of a tick. A slower law is not
# called, and the energy that it can give remains unknown.
MOST_PASSES, PASSES_A_TICK = 250, 2000
# largest fraction of a period, in a live loop, for the loop's call of the law and the observer's calls
MOST_SHARE = 0.5
# Largest damping of the controller, as a fraction of mass / (period + delay). Without a spring the stability
# limit is 1.3 in theory; in simulation it is 2.0, or 0.83 with a delay of a period. With a stiff spring and a
# delay it is at most 0.42.
SAFE = 0.25
# largest force that a controller adds, as a fraction of the device's largest force
SHARE = 0.5

PAUSING = rows.STOPPED | rows.FAULT | rows.STALE | rows.FADING


def most_damping(mass: float, period: float, delay: float) -> float:
    """Return the largest damping in N·s/m that a controller may add; mass in kg, period and delay in s."""
    return SAFE * mass / (period + delay)


@inlined
def watch(r: LoopArrays, position: float, effect: float, period: float) -> None:
    """Add the energy that the mean force in N has given since the last sample."""
    w = r.watch
    moved = position - r.tick.last_position
    controlled = r.settings.damper != 0.0
    if controlled:
        w.strict.limit -= unknown_work(r, effect)
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
            edge *= period / elapsed  # the handle crossed the edge half a sample ago
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
def unknown_work(r: LoopArrays, effect: float) -> float:
    """Return the largest work in J that a change of the force can do beyond the work of the mean force.

    If the force changes by dF at a fraction d of a period, a free handle gets d (1 - d) T² / 2m dF ((1/2 - d)
    dF - b v) more, plus a term in F² that averages out. The maxima of the two terms over d are 1/24 and 1/8.
    """
    w, settings = r.watch, r.settings
    change, w.effect = effect - w.effect, effect
    mass = settings.damper * (settings.period + settings.delay) / SAFE
    more = change / 24.0 - settings.viscous * w.speed / 8.0
    return settings.period**2 / mass * change * more


@inlined
def straighten(w: Record, position: float, half: float, elapsed: float) -> float:
    """Extend the straightest motion by one count of width 2 ``half`` in m.

    Return the added ∫v² dt in m²/s.
    """
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
    """Add a reversal at a count's edge, reached after a time in s at a velocity in m/s."""
    w.turn += velocity * time
    w.before += velocity * velocity * time
    w.lasted -= time
    w.least, w.greatest = -math.inf, math.inf


@inlined
def compare(r: LoopArrays, position: float, taken: float, proven: float) -> None:
    """Compare the given energy with both limits.

    ``taken`` is the dissipated energy in J, and ``proven`` its provable part.
    """
    w = r.watch
    known = w.cells_known
    cell = (position - w.start) * A_METRE
    follows = r.settings.n_state == 0
    if known <= CELLS if not follows else abs(cell) >= known - 1:
        w.alarm.limit += taken
        w.strict.limit += proven
        return
    level = w.given
    if follows:  # add the energy that a law without a state can still give
        below = math.floor(cell)
        i, work = CELLS + int(below), w.work
        level += w.most - (work[i] + (cell - below) * (work[i + 1] - work[i]))
    settle(w.alarm, level, taken, follows)
    if r.settings.damper != 0.0:  # only the controller uses this limit, and computing it takes 0.5 ns
        settle(w.strict, level, proven, follows)


@inlined
def settle(limit: Record, level: float, taken: float, follows: bool) -> None:
    """Update a limit and its excess in J; dissipated energy raises the limit, at most by the excess."""
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
    """Return the threshold in J of an excess that can be felt and that quantisation cannot cause."""
    return FELT + COUNTS * r.settings.quantum * r.watch.peak


@inlined
def control(r: LoopArrays, period: float) -> float:
    """Return the force in N, in the direction of motion, whose subtraction removes the excess in a period."""
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
    """Write the row's flags and energies; restart the observer after every change of the rendered law."""
    w, t = r.watch, r.tick
    flags = t.row_flags
    if flags & PAUSING or r.tick.ramp < 1.0 or w.renew:
        w.renew = w.cells_known = 0
        w.given = w.alarm.limit = w.alarm.excess = w.strict.limit = w.strict.excess = 0.0
        row[rows.ENERGY_GIVEN] = row[rows.ENERGY_LIMIT] = math.nan
        return
    if w.cells_known <= CELLS:
        extend_cells(r, position, period)
    if taken != 0.0:
        flags |= rows.DAMPED
    if w.alarm.excess > FELT and w.alarm.excess > threshold(r):
        flags |= rows.ACTIVE
    t.row_flags = flags
    row[rows.ENERGY_GIVEN], row[rows.ENERGY_LIMIT] = w.given, w.alarm.limit


@internal
def force_at(r: LoopArrays, position: float, period: float) -> float:
    """Return the law's static force in N at a position, for its initial state, within the motor's limit."""
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
def extend_cells(r: LoopArrays, position: float, period: float) -> None:
    """Call the law at the next cells, and add the work up to these cells."""
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
    """Return the last cell to evaluate.

    This cell is beyond the position that the handle reaches in one period at twice its speed.

    In a live loop the law's duration limits the number of cells.
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
    """Raise the maximum of the law's work to a value in J if the value is larger."""
    if work > w.most:
        w.alarm.limit += work - w.most
        w.strict.limit += work - w.most
        w.most = work


@internal
def begin(r: LoopArrays, position: float, period: float) -> None:
    """Start the observer at this position: no cell has been visited, and no energy has been given out."""
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
        centre_force = call(r.settings.stored, r.params[slot], w.frozen, position, 0.0, period, w.fault)
        w.alarm.limit = w.strict.limit = w.most = centre_force if math.isfinite(centre_force) else 0.0
        w.cells_known = CELLS + 1
