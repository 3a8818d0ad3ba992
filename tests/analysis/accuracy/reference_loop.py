"""A loop in plain Python that calls a law's Python function: the reference for the page *This scene*.

It shares the laws, the hands' targets and the just-noticeable differences with the package. Handle, hand,
sensor, velocity estimate, delay, hold and force limit are implemented independently.
"""

import math

import numpy as np
from scipy.linalg import solve_discrete_are

from hapkit_studio.analysis import perception
from hapkit_studio.haptics import rows
from tests.laws.twins import Plain

FINE = 16_000.0  # lowest rate in Hz of the handle's integration steps


class Kalman:
    """Kalman filter for a quantised position, with white acceleration noise of density q in m²/s³."""

    def __init__(self, period, quantum, q=0.01):
        r = quantum**2 / 12.0
        spread = q * np.array([[period**3 / 3.0, period**2 / 2.0], [period**2 / 2.0, period]])
        move, seen = np.array([[1.0, period], [0.0, 1.0]]), np.array([[1.0], [0.0]])
        p = solve_discrete_are(move.T, seen, spread / r, np.eye(1))[:, 0]
        self.period, self.place, self.speed = period, None, 0.0
        self.alpha, self.beta = (p / (p[0] + 1.0)).tolist()

    def __call__(self, place):
        before = place if self.place is None else self.place + self.period * self.speed
        self.place = before + self.alpha * (place - before)
        self.speed += self.beta * (place - before)
        return self.speed


class LowPass:
    """Velocity as a backward difference, low-pass filtered with a cutoff in Hz."""

    cutoff = 35.5

    def __init__(self, period, _quantum):
        self.period, self.place, self.speed = period, None, 0.0
        self.share = -math.expm1(-2.0 * math.pi * self.cutoff * period)

    def __call__(self, place):
        before, self.place = place if self.place is None else self.place, place
        self.speed += self.share * ((place - before) / self.period - self.speed)
        return self.speed


class Difference(LowPass):
    """Velocity as the backward difference of two positions."""

    cutoff = math.inf


def rendered(trial, device, environment, values, real=(), rate=FINE, delay=0.0, estimate=Kalman):
    """Return a law's rows at perception.RATE; only the loop's parts in ``real`` are real, the others ideal.

    An event is a sample or the start of a force. Between two events, the handle moves for half a step, is
    accelerated, and moves for the other half.
    """
    rate, delay = rate if "rate" in real else FINE, delay if "delay" in real else 0.0
    quantum, limit = (device.quantum if "sensor" in real else 0.0), device.max_force
    limit = limit if "limit" in real else math.inf
    law = Plain(environment.force, values, 1.0 / rate)
    filtered = estimate(1.0 / rate, device.quantum) if "velocity" in real else None
    hand, seconds = trial.hand, trial.seconds
    samples = np.arange(math.ceil(seconds * rate) + 1) / rate
    grid = np.concatenate([np.arange(seconds * FINE + 1) / FINE, samples, samples + delay, [hand.release]])
    grid = np.unique(np.round(grid[grid <= seconds + 1e-12], 9))
    t, marks = 0.5 * (grid[1:] + grid[:-1]), np.arange(round(seconds * perception.RATE) + 1) / perception.RATE
    held = t < hand.release
    mass, tug = device.mass + held * hand.mass, held * pull(hand, t, 0.0, 0.0)
    loss = 0.5 * np.diff(grid) * (device.damping + held * hand.damping) / mass
    asks, acts, marks = (np.searchsorted(grid, np.round(at, 9)) for at in (samples, samples + delay, marks))
    asks, acts = set(asks.tolist()), set(acts.tolist())
    counted = [environment.state_names.index(name) for name in environment.counts]
    steps = np.column_stack([np.diff(grid), mass, loss, tug, held * hand.stiffness]).tolist()
    x, v, motor, forces, seen = 0.0, trial.thrown, 0.0, [], []
    for n, (h, m, lost, f, k) in enumerate(steps):
        if n in asks:
            ahead = x if real else x + 0.5 * h * v  # an ideal loop uses the position at half a step
            place = quantum * math.floor(ahead / quantum) if quantum else ahead
            asked = law.call(place, filtered(place) if filtered else v)
            forces.append(min(max(asked, -limit), limit))
            counts = [law.state[i] for i in counted]
        if n in acts:
            motor = forces.pop(0)
        seen.append((x, v, *counts))
        x += 0.5 * h * v
        w = (v * (1.0 - lost) + h * (f - k * x + motor) / m) / (1.0 + lost)
        v = math.copysign(max(abs(w) - h * device.coulomb_force / m, 0.0), w)
        x += 0.5 * h * v
    place, speed, *counts = np.array([*seen, (x, v, *counts)])[marks].T
    found, t = np.zeros((len(place), rows.ROW_WIDTH)), grid[marks]
    found[:, rows.TRUE_POSITION] = place
    found[:, rows.HAND_FORCE] = np.where(t < hand.release, pull(hand, t, place, speed), 0.0)
    for i, count in zip(counted, counts, strict=True):
        found[:, rows.STATE + i] = count
    return found


def pull(hand, t, place, speed):
    """Return a hand's force (n,) in N at times in s, from the handle's positions and velocities."""
    target = hand.target if hand.vectorised else np.vectorize(hand.target, otypes=[float])
    at, moved = target(t), (target(t + 1e-6) - target(t - 1e-6)) / 2e-6
    return hand.stiffness * (at - place) + hand.damping * (moved - speed)
