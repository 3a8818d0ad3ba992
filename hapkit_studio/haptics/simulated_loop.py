"""The live loop on the simulated Hapkit: sleeps to absolute deadlines, renders, moves the paddle on."""

from hapkit_studio.devices import simulated
from hapkit_studio.haptics import block, histogram, plant, rig, ring, rows, settings, sleep
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.haptics.jit import compiled
from hapkit_studio.haptics.priority import demote
from hapkit_studio.haptics.tick import latch, tick

# A pass that finds its deadline gone by did not wait; so many in a row mean the machine cannot keep up.
MOST_PASSES_WITHOUT_WAITING = 100


@compiled
def sample(r, body, out, now, begin, lateness):
    """Render one sample at the clock's now, publish its row, move the paddle on by one period."""
    plant.follow_settings(body, r)
    period = r.values[block.PERIOD]
    target = body.constants[plant.TARGET]
    row = out.rows[ring.next_index(out)]
    plant.write_truth(body, target, row)
    force = tick(r, plant.measure(body), period, body.dev[simulated.EFFECT], row)
    simulated.command(body.dev, body.queue, force)
    after = plant.next_target(body, r.values[block.HAND_TARGET], period)
    simulated.advance(body.dev, body.queue, target, after)
    body.constants[plant.TARGET] = after
    r.real[rig.CLOCK] += period
    row[rows.HOST_TIME] = now - begin
    row[rows.BOARD_TIME] = r.real[rig.CLOCK]
    row[rows.LATENESS] = lateness
    row[rows.COMPUTE] = sleep.now() - now
    ring.publish(out)


@compiled
def run(r, body, out, late):
    """Own the calling thread until told to quit; the last act is a zero command."""
    settings.adopt(r, plant.measure(body))
    start = sleep.now()
    deadline = start
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
        sample(r, body, out, now, start, lateness)
    simulated.command(body.dev, body.queue, 0.0)
    store_release(r.control, rig.DONE, 1)
