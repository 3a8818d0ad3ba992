"""Render a scene without a window and without real time, for simulate, sweeps and stability tests."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from hapkit_studio.devices import simulated
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Hand, Prescribed
from hapkit_studio.dynamics.jit import compiled, inlined
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact
from hapkit_studio.haptics import arrays, block, patience, rows, simulated_loop
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.block_content import BlockContent
from hapkit_studio.haptics.clib import load_acquire
from hapkit_studio.haptics.simulated_loop import Plant
from hapkit_studio.haptics.tick import tick


@inlined
def simulate_sample(
    r: LoopArrays, body: Plant, row: np.ndarray, target: float, after: float, shown: float
) -> bool:
    """Fill one row, whose time is already set, and advance the device by one period.

    During the period the hand's target moves from ``target`` to ``after`` in m. ``shown`` is the target that
    is stored in the row, NaN without a hand. Return False if the run shall end.
    """
    simulated_loop.write_truth(body, shown, row)
    force = tick(r, simulated_loop.measure(body), r.block.settings.period, body.dev[simulated.EFFECT], row)
    simulated.command(body.dev, body.queue, force)
    simulated.advance(body.dev, body.queue, target, after)
    return patience.goes_on(r)


@compiled
def run_batch(
    r: LoopArrays, body: Plant, hand: np.ndarray, targets: np.ndarray, holding: np.ndarray, out: np.ndarray
) -> int:
    """Fill one row per sample and return the number of rows. Only a cancelled run fills fewer rows.

    ``hand`` contains mass, damping and stiffness. ``targets`` (n + 1,) are in m, with linear interpolation
    between samples. Element k of ``holding`` (n,) is True if the hand holds the handle from sample k to the
    next. ``out`` is (n, ROW_WIDTH); row 0 is the initial state.
    """
    settings = r.block.settings
    period, grip = settings.period, (hand[0], hand[1], hand[2])
    patience.begin(r)
    if load_acquire(r.control.quit, 0):
        return 0
    for k in range(out.shape[0]):
        on = holding[k] != 0
        simulated_loop.configure(body, settings, grip, on)
        row = out[k]
        row[rows.BOARD_TIME] = k * period
        if not simulate_sample(r, body, row, targets[k], targets[k + 1], targets[k] if on else math.nan):
            return k + 1
    return out.shape[0]


@compiled
def run_prescribed(
    r: LoopArrays, body: Plant, positions: np.ndarray, velocities: np.ndarray, out: np.ndarray
) -> None:
    """Fill one row per sample of a prescribed motion: positions (n,) in m and velocities (n,) in m/s."""
    settings = r.block.settings
    simulated_loop.configure(body, settings, (0.0, 0.0, 0.0), False)
    patience.begin(r)
    for k in range(out.shape[0]):
        body.dev[simulated.X] = positions[k]
        body.dev[simulated.V] = velocities[k]
        row = out[k]
        row[rows.BOARD_TIME] = k * settings.period
        if not simulate_sample(r, body, row, positions[k], positions[k], positions[k]):
            return


_AT_ONCE = 1 << 17  # rows per call, which take 35 MB, so that Ctrl+C is handled soon


def new_rows(count: int) -> np.ndarray:
    """Return an array of rows whose memory is already mapped, so that timings measure only the loop."""
    out = np.empty((count, rows.ROW_WIDTH))
    for first in range(0, count, _AT_ONCE):
        out[first : first + _AT_ONCE] = 0.0
    return out


# s: step of the numerical derivative of a prescribed motion
_DIFFERENCE_SECONDS = 1e-6


@dataclass(frozen=True)
class Scene:
    """An environment with its values, device and loop; values must be finite, but may exceed their limits.

    If ``true_velocity`` is true, the law gets the paddle's true velocity instead of the loop's estimate.
    ``designed_for`` is the sensor quantum in m that the velocity estimator assumes, None for the quantum of
    the device.
    """

    environment: Environment
    values: Mapping[str, float]
    device: SimulatedHapkit = field(default_factory=SimulatedHapkit)
    loop: LoopSettings = field(default_factory=LoopSettings)
    max_speed: float = math.inf
    true_velocity: bool = False
    designed_for: float | None = None

    def prepare(self) -> tuple[LoopArrays, Plant]:
        """Return the loop's arrays, with parameters that do not ramp, and the device in its initial state."""
        device = self.device
        settings = replace(
            self.loop, mass=device.mass, viscous=device.viscous, coulomb=device.coulomb_force,
            quantum=device.quantum, max_force=device.max_force,
        )  # fmt: skip
        content = BlockContent(
            self.environment, self.values, settings, self.max_speed, self.true_velocity, self.designed_for
        )
        shared = block.new_block()
        r = arrays.new_arrays(shared)
        block.publish(shared, content.encode())
        r.tick.gain = 1.0
        periods = math.ceil(self.loop.delay * self.loop.rate) + 2
        return r, simulated_loop.new_plant(self.device, periods)


@dataclass(frozen=True)
class PreparedRun:
    """A prepared scene and hand; ``run`` executes only compiled code, and may be called once."""

    title: str
    arrays: LoopArrays
    body: Plant
    grip: np.ndarray
    targets: np.ndarray
    holding: np.ndarray
    out: np.ndarray

    def run(self) -> np.ndarray:
        """Render; return the telemetry rows (count, ROW_WIDTH); raise LawError if the law is too slow."""
        run_batch(self.arrays, self.body, self.grip, self.targets, self.holding, self.out)
        patience.check(self.arrays, self.title)
        return self.out


def prepare_run(scene: Scene, hand: Hand, count: int, room: int | None = None) -> PreparedRun:
    """Prepare a scene for count rows; raise ParameterError for a motion that is not finite.

    ``room`` is the number of rows in memory, for rendering in chunks.
    """
    r, body = scene.prepare()
    times = np.arange(count + 1) / scene.loop.rate
    holding = (times[:-1] < hand.release).astype(np.int64)
    targets = _sampled(hand.target, times, hand.vectorised) if holding.any() else np.zeros(count + 1)
    numbers = np.array([hand.mass, hand.damping, hand.stiffness])
    out = new_rows(count if room is None else room)
    return PreparedRun(scene.environment.title, r, body, numbers, targets, holding, out)


_CHUNK = 256  # number of rows in a chunk, so that the chunk fits into the processor's cache


def render_every(scene: Scene, hand: Hand, count: int, every: int) -> np.ndarray:
    """Return every n-th of ``count`` telemetry rows; only one chunk of rows is in memory at a time."""
    made, pieces = prepare_run(scene, hand, count, min(count, _CHUNK * every)), []
    for at in range(0, count, len(made.out)):
        targets, holding = made.targets[at : at + len(made.out) + 1], made.holding[at : at + len(made.out)]
        out = made.out[: len(holding)]
        run_batch(made.arrays, made.body, made.grip, targets, holding, out)
        patience.check(made.arrays, made.title)
        pieces.append(out[::every].copy())
    found = np.concatenate(pieces)
    found[:, rows.BOARD_TIME] = np.arange(len(found)) * every / scene.loop.rate
    return found


def render(scene: Scene, hand: Hand | Prescribed | None, count: int) -> tuple[np.ndarray, LoopArrays]:
    """Return ``count`` telemetry rows and the loop's final arrays.

    Raise ParameterError if a motion is not finite, and LawError if a law is too slow.
    """
    if isinstance(hand, Prescribed):
        return _render_prescribed(hand, scene, count)
    hand = hand or Hand(release=0.0)
    made = prepare_run(scene, hand, count)
    out, targets = made.run(), made.targets
    if made.holding[0]:
        away, rate = targets[0] - scene.device.initial_position, (targets[1] - targets[0]) * scene.loop.rate
        pull = hand.stiffness * away + hand.damping * (rate - scene.device.initial_velocity)
        out[0, rows.HAND_FORCE] = pull
    return out, made.arrays


def _render_prescribed(hand: Prescribed, scene: Scene, count: int) -> tuple[np.ndarray, LoopArrays]:
    r, body = scene.prepare()
    times, out = np.arange(count) / scene.loop.rate, new_rows(count)
    positions = _sampled(hand.position, times)
    after, before = times + _DIFFERENCE_SECONDS, np.maximum(times - _DIFFERENCE_SECONDS, 0.0)
    velocities = (_sampled(hand.position, after) - _sampled(hand.position, before)) / (after - before)
    run_prescribed(r, body, positions, velocities, out)
    patience.check(r, scene.environment.title)
    device = scene.device
    pull = device.mass * np.gradient(velocities) * scene.loop.rate if len(times) > 1 else np.zeros(1)
    friction = device.damping * velocities + device.coulomb_force * np.sign(velocities)
    late = min(math.ceil(scene.loop.delay * scene.loop.rate - 1e-9), len(times))
    motor = np.append(np.zeros(late), out[: len(times) - late, rows.APPLIED_FORCE])
    out[:, rows.HAND_FORCE] = pull + friction - motor
    return out, r


def _sampled(motion, times: np.ndarray, vectorised: bool = False) -> np.ndarray:
    if not callable(motion):
        raise ParameterError(f"The hand's position must be a function of time in s, not {motion!r}.")
    values = motion(times) if vectorised else [motion(t) for t in times.tolist()]
    try:
        values = np.array(values, dtype=float).reshape(times.shape)
    except (TypeError, ValueError):
        raise ParameterError("The hand's position must be one number in m at every time.") from None
    if not np.isfinite(values).all():
        when = times[np.flatnonzero(~np.isfinite(values))[0]]
        raise ParameterError(
            f"The hand's position must be a finite number in m; at {compact(when, 4)} s it is not."
        )
    return values
