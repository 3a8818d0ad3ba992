"""The simulated Hapkit in a loop, and the live loop that renders on it.

The loop sleeps until absolute deadlines, renders a sample, and advances the paddle.
"""

import math
from typing import NamedTuple

import numpy as np

from hapkit_studio.devices import simulated
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.hand import ARRIVES, LEADS
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import arrays, clock, health, rows
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.clib import load_acquire, store_release
from hapkit_studio.haptics.priority import demote
from hapkit_studio.haptics.record import Record
from hapkit_studio.haptics.rows import Ring
from hapkit_studio.haptics.tick import adopt, latch, live_tick

MASS, QUANTUM = 0, 1
HAND, PERIOD, DELAY, VISCOUS, COULOMB, TARGET, TOP_SPEED, RELEASES = 2, 5, 6, 7, 8, 9, 10, 11
_CONSTANTS = 12
# s: The pointer moves in steps, once per video frame. Its motion is smoothed over this time, because a hand
# moves smoothly.
POINTER_SECONDS = 0.012


class Plant(NamedTuple):
    """The device's arrays: its motion, its pending commands, its constants, and its last configuration."""

    dev: np.ndarray
    queue: np.ndarray
    constants: np.ndarray


def new_plant(device: SimulatedHapkit, periods: int = 1022) -> Plant:
    """Return a plant at the device's initial position and velocity; delays can have ``periods`` periods."""
    start = device.initial_position, device.initial_velocity
    dev, queue = simulated.new_state(*start, periods, device.end_stops)
    constants = np.full(_CONSTANTS, math.nan)
    constants[MASS], constants[QUANTUM] = device.mass, device.quantum
    return Plant(dev, queue, constants)


@internal
def configure(plant: Plant, settings: Record, hand: tuple[float, float, float], gripped: bool) -> None:
    """Apply the hand, and the settings' period, delay and friction, if one of them has changed.

    ``hand`` contains mass, damping and stiffness in SI units.
    """
    now = plant.constants
    m, b, k = hand if gripped else (0.0, 0.0, 0.0)
    period, delay = settings.period, settings.delay
    viscous, coulomb = settings.viscous, settings.coulomb
    same = now[HAND] == m and now[HAND + 1] == b and now[HAND + 2] == k
    same = same and now[PERIOD] == period and now[DELAY] == delay
    if same and now[VISCOUS] == viscous and now[COULOMB] == coulomb:
        return
    now[HAND], now[HAND + 1], now[HAND + 2] = m, b, k
    now[PERIOD], now[DELAY], now[VISCOUS], now[COULOMB] = period, delay, viscous, coulomb
    simulated.configure(plant.dev, plant.queue, now[MASS], viscous, coulomb, m, b, k, period, delay)


@compiled
def follow_settings(plant: Plant, r: LoopArrays) -> None:
    """Apply the block's device, hand, period and delay; a new hand starts at the handle's position.

    If the hand releases the handle at rest, the handle's speed is set to zero. After a change of sensor, the
    first reading is the handle's current position and is not evaluated as a motion.
    """
    settings, constants = r.settings, plant.constants
    on = settings.hand_on != 0
    if not on:
        constants[TARGET] = math.nan
    elif math.isnan(constants[TARGET]):
        constants[TARGET], constants[TOP_SPEED] = plant.dev[simulated.X], ARRIVES
    releases = float(r.settings.releases)
    if constants[RELEASES] < releases:
        plant.dev[simulated.V] = 0.0
    constants[RELEASES] = releases
    if constants[QUANTUM] != settings.quantum:
        constants[QUANTUM] = settings.quantum
        position = measure(plant)
        estimators.resume(r.memory, position, r.tick.velocity)
        r.tick.last_position = position
    hand = settings.hand
    configure(plant, settings, (hand[0], hand[1], hand[2]), on)


@compiled
def cut_motor(plant: Plant) -> None:
    """Switch the motor off at once, and discard delayed forces."""
    plant.queue[:] = 0.0


@compiled
def measure(plant: Plant) -> float:
    """Return the position in m that the sensor measures now."""
    return simulated.quantise(plant.dev[simulated.X], plant.constants[QUANTUM])


@compiled
def write_truth(plant: Plant, target: float, row: np.ndarray) -> None:
    """Write the paddle's true motion at this instant into the row."""
    row[rows.TRUE_POSITION] = plant.dev[simulated.X]
    row[rows.TRUE_VELOCITY] = plant.dev[simulated.V]
    row[rows.HAND_FORCE] = plant.dev[simulated.HAND_FORCE]
    row[rows.HAND_TARGET] = target


@internal
def lead(plant: Plant, pointer: float) -> tuple[float, float]:
    """Move the hand's target towards the pointer in m; return the target now and one period later."""
    now = plant.constants
    target, most = now[TARGET], now[TOP_SPEED] * now[PERIOD]
    step = (pointer - target) * -math.expm1(-now[PERIOD] / POINTER_SECONDS)
    if abs(step) < most:
        now[TOP_SPEED] = LEADS
    now[TARGET] = target + min(max(step, -most), most)
    return target, now[TARGET]


# the machine cannot keep up if this many consecutive iterations missed their deadline
MOST_PASSES_WITHOUT_WAITING = 100


@internal
def render_sample(r: LoopArrays, body: Plant, out: Ring, now: float, lateness: float) -> None:
    """Render one sample at the time ``now``, publish its row, and advance the paddle to the next sample.

    Settings that the tick adopts apply from this sample on. The interval before this sample still had the old
    period.
    """
    row = out.rows[rows.next_index(out)]
    write_truth(body, body.constants[TARGET], row)
    row[rows.BOARD_TIME] = r.tick.clock
    force = live_tick(r, measure(body), body.constants[PERIOD], body.dev[simulated.EFFECT], row)
    follow_settings(body, r)
    if r.tick.row_flags & (rows.STOPPED | rows.FAULT):
        cut_motor(body)
    simulated.command(body.dev, body.queue, force)
    target, after = lead(body, r.settings.hand_target)
    simulated.advance(body.dev, body.queue, target, after)
    r.tick.clock += body.constants[PERIOD]
    row[rows.HOST_TIME] = now
    row[rows.LATENESS] = lateness
    row[rows.COMPUTE] = clock.now() - now
    rows.publish(out)


@compiled
def run(r: LoopArrays, body: Plant, out: Ring, late: np.ndarray) -> None:
    """Run the loop in the calling thread until it is told to quit; the last force is always zero."""
    adopt(r, measure(body))
    follow_settings(body, r)
    deadline = clock.now()
    hurried = 0
    while load_acquire(r.control.quit, 0) == 0:
        period = r.settings.period
        deadline += period
        hurried = hurried + 1 if clock.now() >= deadline else 0
        if hurried > MOST_PASSES_WITHOUT_WAITING:
            latch(r, arrays.RUNAWAY, 1.0 / period, 0.0)
            demote()
            deadline = clock.now() + period
            hurried = 0
        clock.until(deadline)
        now = clock.now()
        lateness = now - deadline
        health.add_lateness(late, lateness)
        if lateness >= period:
            missed = int(lateness / period)
            deadline += missed * period
            store_release(r.control.missed, 0, r.control.missed[0] + missed)
        render_sample(r, body, out, now, lateness)
    cut_motor(body)
    store_release(r.control.done, 0, 1)
