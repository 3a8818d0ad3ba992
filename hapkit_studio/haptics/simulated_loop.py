"""The live loop on the simulated Hapkit: sleeps to absolute deadlines, renders, moves the paddle on."""

from hapkit_studio.devices import simulated
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import block, histogram, plant, rig, ring, rows, settings, sleep
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.haptics.priority import demote
from hapkit_studio.haptics.tick import latch, note_time, tick

# A pass that finds its deadline gone by did not wait; so many in a row mean the machine cannot keep up.
MOST_PASSES_WITHOUT_WAITING = 100


@internal
def sample(r, body, out, now, lateness):
    """Render one sample at the clock's now, publish its row, move the paddle on to the next one.

    Settings that the tick takes hold from this sample on; up to here the old period has passed.
    """
    row = out.rows[ring.next_index(out)]
    plant.write_truth(body, body.constants[plant.TARGET], row)
    row[rows.BOARD_TIME] = r.real[rig.CLOCK]
    force = tick(r, plant.measure(body), body.constants[plant.PERIOD], body.dev[simulated.EFFECT], row)
    plant.follow_settings(body, r)
    if r.word[rig.FLAGS] & (rows.STOPPED | rows.FAULT):
        plant.cut(body)
    simulated.command(body.dev, body.queue, force)
    period, target = body.constants[plant.PERIOD], body.constants[plant.TARGET]
    after = plant.next_target(body, r.values[block.HAND_TARGET], period)
    simulated.advance(body.dev, body.queue, target, after)
    body.constants[plant.TARGET] = after
    r.real[rig.CLOCK] += period
    row[rows.HOST_TIME] = now
    row[rows.LATENESS] = lateness
    row[rows.COMPUTE] = sleep.now() - now
    note_time(r, row[rows.COMPUTE])
    ring.publish(out)


@compiled
def run(r, body, out, late):
    """Own the calling thread until told to quit; the last act is a zero command."""
    settings.adopt(r, plant.measure(body))
    plant.follow_settings(body, r)
    deadline = sleep.now()
    hurried = 0
    while load_acquire(r.control, rig.QUIT) == 0:
        period = r.values[block.PERIOD]
        deadline += period
        hurried = hurried + 1 if sleep.now() >= deadline else 0
        if hurried > MOST_PASSES_WITHOUT_WAITING:
            latch(r, rig.RUNAWAY, 1.0 / period, 0.0)
            demote()
            deadline = sleep.now() + period
            hurried = 0
        sleep.until(deadline)
        now = sleep.now()
        lateness = now - deadline
        histogram.add(late, lateness)
        if lateness >= period:
            missed = int(lateness / period)
            deadline += missed * period
            store_release(r.control, rig.MISSED, r.control[rig.MISSED] + missed)
        sample(r, body, out, now, lateness)
    plant.cut(body)
    store_release(r.control, rig.DONE, 1)
