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
    """What is rendered: values may lie beyond a person's limits, they only have to be finite."""

    environment: Environment
    values: Mapping[str, float]
    device: SimulatedHapkit = field(default_factory=SimulatedHapkit)
    loop: LoopSettings = field(default_factory=LoopSettings)
    max_speed: float = math.inf

    def prepare(self) -> tuple[rig.Rig, plant.Plant]:
        """Return a rig at full parameters, and the device at its initial motion."""
        wanted = Wanted(
            self.environment,
            self.values,
            self.loop,
            max_force=self.device.max_force,
            max_speed=self.max_speed,
            quantum=self.device.quantum,
        )
        values, words = block.new_block()
        r = rig.new_rig(values, words)
        block.publish(values, words, *wanted.encode())
        r.real[rig.GAIN] = 1.0
        periods = math.ceil(self.loop.delay * self.loop.rate) + 2
        return r, plant.new_plant(self.device, periods)


def render(scene: Scene, hand: Hand | Prescribed | None, count: int) -> tuple[np.ndarray, rig.Rig]:
    """Return count telemetry rows and the rig they left; raise ParameterError for a motion not finite."""
    r, body = scene.prepare()
    out = batch.new_rows(count)
    times = np.arange(count + 1) / scene.loop.rate
    if isinstance(hand, Prescribed):
        _render_prescribed(r, body, hand, times[:-1], out, scene)
        return out, r
    hand = hand or Hand(release=0.0)
    holding = (times[:-1] < hand.release).astype(np.int64)
    targets = _sampled(hand.target, times) if holding.any() else np.zeros(count + 1)
    numbers = np.array([hand.mass, hand.damping, hand.stiffness])
    batch.run(r, body, numbers, targets, holding, out)
    return out, r


def _render_prescribed(r, body, hand: Prescribed, times: np.ndarray, out: np.ndarray, scene: Scene) -> None:
    step = _DIFFERENCE_SECONDS
    positions = _sampled(hand.position, times)
    ahead, behind = _sampled(hand.position, times + step), _sampled(hand.position, times - step)
    velocities = (ahead - behind) / (2.0 * step)
    batch.run_prescribed(r, body, positions, velocities, out)
    device = scene.device
    pull = device.mass * np.gradient(velocities) * scene.loop.rate if len(times) > 1 else np.zeros(1)
    friction = device.damping * velocities + device.coulomb_force * np.sign(velocities)
    out[:, rows.HAND_FORCE] = pull + friction - out[:, rows.APPLIED]


def _sampled(motion, times: np.ndarray) -> np.ndarray:
    values = np.array([float(motion(t)) for t in times])
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
