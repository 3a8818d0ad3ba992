"""The simulated Hapkit inside a loop: settings in force, the hand's target, one sample after the other."""

import math
from typing import NamedTuple

import numpy as np

from hapkit_studio.devices import simulated
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import block, rows

MASS, VISCOUS, COULOMB, QUANTUM = range(4)
HAND, PERIOD, TARGET = 4, 7, 9
_CONSTANTS = 12
# The pointer moves in steps of a frame; a hand does not.
POINTER_SECONDS = 0.012


class Plant(NamedTuple):
    """The device's arrays: motion and pending commands, constants, what was configured last."""

    dev: np.ndarray
    queue: np.ndarray
    constants: np.ndarray


def new_plant(device: SimulatedHapkit, periods: int = 1022) -> Plant:
    """Return a plant at the device's initial motion, for delays of up to ``periods`` periods."""
    dev, queue = simulated.new_state(device.initial_position, device.initial_velocity, periods)
    constants = np.full(_CONSTANTS, math.nan)
    constants[:4] = device.mass, device.viscous, device.coulomb_force, device.quantum
    return Plant(dev, queue, constants)


@internal
def configure(plant, hand_mass, hand_damping, hand_stiffness, period, delay):
    """Bring hand, period and delay into force where any of them changed."""
    now = plant.constants
    same = now[HAND] == hand_mass and now[HAND + 1] == hand_damping and now[HAND + 2] == hand_stiffness
    if same and now[PERIOD] == period and now[PERIOD + 1] == delay:
        return
    now[HAND], now[HAND + 1], now[HAND + 2] = hand_mass, hand_damping, hand_stiffness
    now[PERIOD], now[PERIOD + 1] = period, delay
    simulated.configure(
        plant.dev,
        plant.queue,
        now[MASS],
        now[VISCOUS],
        now[COULOMB],
        hand_mass,
        hand_damping,
        hand_stiffness,
        period,
        delay,
    )


@compiled
def follow_settings(plant, r):
    """Bring the block's hand, period and delay into force; a hand that appears starts at the handle."""
    values = r.values
    on = r.words[block.HAND_ON] != 0
    if on:
        if math.isnan(plant.constants[TARGET]):
            plant.constants[TARGET] = plant.dev[simulated.X]
    else:
        plant.constants[TARGET] = math.nan
    configure(
        plant,
        values[block.HAND_MASS] if on else 0.0,
        values[block.HAND_DAMPING] if on else 0.0,
        values[block.HAND_STIFFNESS] if on else 0.0,
        values[block.PERIOD],
        values[block.DELAY],
    )


@compiled
def next_target(plant, goal, period):
    """Return the hand's target in m one period on, following the pointer's goal smoothly."""
    target = plant.constants[TARGET]
    return target + (goal - target) * -math.expm1(-period / POINTER_SECONDS)


@compiled
def cut(plant):
    """Switch the motor off at once: forces still on their way are dropped, whatever the delay."""
    plant.queue[:] = 0.0


@compiled
def measure(plant):
    """Return the position in m that the sensor reads now."""
    return simulated.quantise(plant.dev[simulated.X], plant.constants[QUANTUM])


@compiled
def write_truth(plant, target, row):
    """Fill the row's truth: the paddle's physics at this instant."""
    row[rows.TRUE_POSITION] = plant.dev[simulated.X]
    row[rows.TRUE_VELOCITY] = plant.dev[simulated.V]
    row[rows.HAND_FORCE] = plant.dev[simulated.HAND_FORCE]
    row[rows.HAND_TARGET] = target
