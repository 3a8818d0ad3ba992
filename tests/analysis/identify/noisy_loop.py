"""An independent reference loop with a noisy sensor, for many handles in a spring at once.

It makes velocity Verlet steps of 50 µs (kick, drift, kick) with mass, viscous and Coulomb friction. Spring
and damping act as commands, which are held for a period and delayed.
"""

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.identify.recording import Handle, Recording, Setup, hand_parts
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.haptics.rows import CLAMPED

STEPS = 20  # number of integration steps per sample period
RATE = 1000.0
QUANTUM = 20.7e-6
HANDLE = Handle(0.044, 0.5, 0.10)
GRIP = Grip(0.05, 4.0, 200.0)


def recordings(
    seeds, noise, *, held, stiffness=150.0, damping=0.0, delay_steps=STEPS, seconds=2.0, known=True
):
    """Return one recording per seed: a hand follows four sines, or the handle is released at 12 to 25 mm.

    ``noise`` is the standard deviation in counts of each reading before quantisation; ``delay_steps`` is the
    delay in steps of 50 µs.
    """
    count, generators = round(seconds * RATE), [np.random.default_rng(seed) for seed in seeds]
    time = np.arange(count) / RATE
    target = np.stack([_sines(random, time) for random in generators]) if held else None
    mass = HANDLE.mass + (GRIP.mass if held else 0.0)
    x = np.array([random.uniform(0.012, 0.025) * random.choice((-1, 1)) for random in generators])
    x = target[:, 0].copy() if held else x
    errors = np.stack([random.normal(0.0, 1.0, count) for random in generators]) * noise * QUANTUM
    errors += np.array([random.uniform(0.0, QUANTUM) for random in generators])[:, None]
    # the rows are position, velocity, command, the hand's force, and the true position
    rows = np.zeros((5, len(x), count))
    v, before, step = np.zeros(len(x)), None, 1.0 / RATE / STEPS
    commands = np.zeros((len(x), count + 1))
    for k in range(count):
        seen = QUANTUM * np.floor((x + errors[:, k]) / QUANTUM)
        speed = np.zeros(len(x)) if before is None else (seen - before) * RATE
        before = seen
        commands[:, k + 1] = np.clip(-stiffness * seen - damping * speed, -3.0, 3.0)
        at = along = 0.0
        if held:
            at = target[:, k]
            along = (target[:, k + 1] - at) * RATE if k + 1 < count else 0.0 * at
            earlier = (at - target[:, k - 1]) * RATE if k else along
            rows[3, :, k] = GRIP.stiffness * (at - x) + GRIP.damping * (earlier - v)
        rows[0, :, k], rows[1, :, k], rows[2, :, k], rows[4, :, k] = seen, speed, commands[:, k + 1], x
        for n in range(STEPS):
            late = k - (delay_steps - n + STEPS - 1) // STEPS if n < delay_steps else k
            force = commands[:, max(late, -1) + 1]
            there = at + along * (n * step)
            v = _kick(v, x, force, there, along, 0.5 * step, mass, held)
            x = x + step * v
            v = _kick(v, x, force, there + along * step, along, 0.5 * step, mass, held)
    values = environments.named("spring").values({"stiffness": stiffness, "damping": damping})
    setup = Setup(
        environments.named("spring"),
        values,
        RATE,
        delay_steps * step,
        QUANTUM,
        HANDLE if known else None,
        GRIP if held else None,
    )
    found = []
    for i in range(len(x)):
        moved = target[i] if held else None
        hand = hand_parts(rows[3, i], moved, setup)
        flags = np.where(np.abs(rows[2, i]) >= 3.0, CLAMPED, 0)
        motion = (time, rows[0, i], rows[1, i], rows[2, i], rows[2, i])
        found.append(Recording(*motion, flags, *hand, setup, moved))
    return found, rows[4]


def _kick(v, x, force, target, along, step, mass, held):
    """Return the velocity after all forces have acted for ``step``; Coulomb friction never reverses it."""
    push = force - HANDLE.viscous * v
    if held:
        push = push + GRIP.stiffness * (target - x) + GRIP.damping * (along - v)
    v = v + step * push / mass
    return np.sign(v) * np.maximum(np.abs(v) - step * HANDLE.coulomb / mass, 0.0)


def _sines(random, time):
    hertz, phase = random.uniform(0.7, 6.0, 4), random.uniform(0.0, 2.0 * np.pi, 4)
    size = 0.0125 / hertz**0.7 * random.uniform(0.5, 1.0, 4)
    return size @ np.sin(2.0 * np.pi * np.outer(hertz, time) + phase[:, None])
