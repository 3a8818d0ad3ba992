"""A scene rendered without a window or a clock: the raw entry of simulate, sweeps and stability tests."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Grip, Hand, Prescribed
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import batch, block, plant, rig, rows
from hapkit_studio.haptics.settings_writer import LoopSettings, Wanted

FAULT = rig.FAULT
# The hand's speed in a prescribed motion comes from its positions this far apart.
_DIFFERENCE_SECONDS = 1e-6


@dataclass(frozen=True)
class Scene:
    """What is rendered: values may lie beyond a person's limits, they only have to be finite.

    true_velocity: the law gets the paddle's own velocity in place of the loop's estimate. controller: the
    passivity controller is on, as it is where the loop's settings have it on. designed_for: the quantum in m
    that the velocity estimator expects, where it is not the device's own.
    """

    environment: Environment
    values: Mapping[str, float]
    device: SimulatedHapkit = field(default_factory=SimulatedHapkit)
    loop: LoopSettings = field(default_factory=LoopSettings)
    max_speed: float = math.inf
    true_velocity: bool = False
    controller: bool = False
    designed_for: float | None = None

    def prepare(self) -> tuple[rig.Rig, plant.Plant]:
        """Return a rig at full parameters, and the device at its initial motion."""
        wanted = Wanted(
            self.environment,
            self.values,
            self.loop.changed(controller=self.controller or self.loop.controller),
            max_force=self.device.max_force,
            max_speed=self.max_speed,
            quantum=self.device.quantum,
            mass=self.device.mass,
            viscous=self.device.viscous,
            coulomb=self.device.coulomb_force,
            true_velocity=self.true_velocity,
            designed_for=self.designed_for,
        )
        shared = block.new_block()
        r = rig.new_rig(*shared)
        block.publish(*shared, *wanted.encode())
        r.real[rig.GAIN] = 1.0
        periods = math.ceil(self.loop.delay * self.loop.rate) + 2
        return r, plant.new_plant(self.device, periods)


@dataclass(frozen=True)
class Stage:
    """A scene and the hand on it, made ready: ``run`` is compiled code alone, and happens once."""

    rig: rig.Rig
    body: plant.Plant
    grip: np.ndarray
    targets: np.ndarray
    holding: np.ndarray
    out: np.ndarray

    def run(self) -> np.ndarray:
        """Render; return the telemetry rows (count, ROW_WIDTH)."""
        batch.run(self.rig, self.body, self.grip, self.targets, self.holding, self.out)
        return self.out


def stage(scene: Scene, hand: Hand, count: int) -> Stage:
    """Return a scene made ready for count rows; raise ParameterError for a motion that is not finite."""
    r, body = scene.prepare()
    times = np.arange(count + 1) / scene.loop.rate
    holding = (times[:-1] < hand.release).astype(np.int64)
    targets = _sampled(hand.target, times, hand.vectorised) if holding.any() else np.zeros(count + 1)
    numbers = np.array([hand.mass, hand.damping, hand.stiffness])
    return Stage(r, body, numbers, targets, holding, batch.new_rows(count))


def render(scene: Scene, hand: Hand | Prescribed | None, count: int) -> tuple[np.ndarray, rig.Rig]:
    """Return count telemetry rows and the rig they left; raise ParameterError for a motion not finite."""
    if isinstance(hand, Prescribed):
        return _render_prescribed(hand, scene, count)
    hand = hand or Hand(release=0.0)
    made = stage(scene, hand, count)
    out, targets = made.run(), made.targets
    if made.holding[0]:
        away, rate = targets[0] - scene.device.initial_position, (targets[1] - targets[0]) * scene.loop.rate
        pull = hand.stiffness * away + hand.damping * (rate - scene.device.initial_velocity)
        out[0, rows.HAND_FORCE] = pull
    return out, made.rig


def _render_prescribed(hand: Prescribed, scene: Scene, count: int) -> tuple[np.ndarray, rig.Rig]:
    r, body = scene.prepare()
    times, out = np.arange(count) / scene.loop.rate, batch.new_rows(count)
    positions = _sampled(hand.position, times)
    after, before = times + _DIFFERENCE_SECONDS, np.maximum(times - _DIFFERENCE_SECONDS, 0.0)
    velocities = (_sampled(hand.position, after) - _sampled(hand.position, before)) / (after - before)
    batch.run_prescribed(r, body, positions, velocities, out)
    device = scene.device
    pull = device.mass * np.gradient(velocities) * scene.loop.rate if len(times) > 1 else np.zeros(1)
    friction = device.damping * velocities + device.coulomb_force * np.sign(velocities)
    late = min(math.ceil(scene.loop.delay * scene.loop.rate - 1e-9), len(times))
    motor = np.append(np.zeros(late), out[: len(times) - late, rows.APPLIED])
    out[:, rows.HAND_FORCE] = pull + friction - motor
    return out, r


def _sampled(motion, times: np.ndarray, vectorised: bool = False) -> np.ndarray:
    if not callable(motion):
        raise ParameterError(f"The hand's position is a function of time in s, not {motion!r}.")
    values = motion(times) if vectorised else [motion(t) for t in times.tolist()]
    try:
        values = np.array(values, dtype=float).reshape(times.shape)
    except (TypeError, ValueError):
        raise ParameterError(
            "The hand's position must be one number of m at every time; it is not."
        ) from None
    if not np.isfinite(values).all():
        when = times[np.flatnonzero(~np.isfinite(values))[0]]
        raise ParameterError(f"The hand's position must be a finite number of m; at {when:.4g} s it is not.")
    return values


def spring_rows(
    environment: Environment,
    values: Mapping[str, float],
    device: SimulatedHapkit,
    loop: LoopSettings,
    grip: Grip | None,
    count: int,
) -> np.ndarray:
    """Return rows of a scene whose hand rests at the origin, or of a released handle."""
    scene = Scene(environment, values, device, loop)
    hand = Hand(grip.mass, grip.damping, grip.stiffness) if grip else None
    return render(scene, hand, count)[0]
