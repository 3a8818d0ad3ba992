"""The engine: the one object the window talks to. It sends parameters, never forces, and never waits."""

import math
import threading
from collections.abc import Mapping

import numpy as np

from hapkit_studio import environments
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.hand import grip_named
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError, StudioError
from hapkit_studio.haptics import block, faults, histogram, priority, rig
from hapkit_studio.haptics.drivers import Driver, compile_ahead, driver_for
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.haptics.health import Health, Watch
from hapkit_studio.haptics.priority import Priority
from hapkit_studio.haptics.ring import RingReader, new_ring
from hapkit_studio.haptics.settings_writer import LoopSettings, Wanted

STARTING = Priority("Starting", False, "")
JOIN_SECONDS = 2.0


def _environment(named: str | Environment) -> Environment:
    return named if isinstance(named, Environment) else environments.named(named)


class Engine:
    """Runs one device's loop in a thread of its own and passes settings to it."""

    def __init__(self, device, environment: str | Environment = "wall", realtime: bool = True):
        self._block = block.new_block()
        self._rig = rig.new_rig(*self._block)
        self._ring = new_ring(self._rig.control)
        self._late = histogram.new_histogram()
        self._lock = threading.RLock()
        self._watch = Watch()
        self._thread: threading.Thread | None = None
        self._driver: Driver | None = None
        self._priority = STARTING
        self._realtime = realtime
        self._message = ""
        # a law by its address, with the last generation of settings that wanted it
        self._kept: dict[int, tuple[int, object]] = {}
        self._grip_name = "medium"
        self._target: float | None = None
        self.device = device
        chosen = _environment(environment)
        self._wanted = Wanted(chosen, chosen.values())

    # --- life
    def start(self) -> None:
        """Open the device and start the loop; raise DeviceError. Compiles on the very first start."""
        self.close()
        driver = driver_for(self.device)
        try:
            self._begin(driver)
        except BaseException:
            driver.close()
            raise

    def _begin(self, driver: Driver) -> None:
        self._driver, self._message = driver, ""
        loop = self.loop.changed(rate=driver.rate)
        self._changed(max_force=self.device.max_force, quantum=self.device.quantum, loop=loop)
        compile_ahead(driver, self._rig, self._late)
        self._late[:] = 0
        rig.restart(self._rig, driver.hold_seconds)
        self._watch.forget()
        self._thread = threading.Thread(
            target=self._own_thread, args=(driver,), name="hapkit-loop", daemon=True
        )
        self._thread.start()

    def _own_thread(self, driver: Driver) -> None:
        self._priority = priority.obtain() if self._realtime else Priority("Normal priority", False, "")
        try:
            driver.run(self._rig, self._ring, self._late)
        except StudioError as error:
            if self.fault is None:
                store_release(self._rig.control, rig.FAULT, rig.DEVICE_GONE)
            self._message = str(error)
        finally:
            priority.release()

    def close(self) -> None:
        """Stop the loop with a zero command and let go of the device."""
        store_release(self._rig.control, rig.QUIT, 1)
        if self._thread is not None:
            self._thread.join(JOIN_SECONDS)
            self._thread = None
        if self._driver is not None:
            self._driver.close()
            self._driver = None

    def use(self, device) -> None:
        """Change to another device, settings and readers kept; raise DeviceError with the force at zero."""
        self.close()
        self.device = device
        self.start()

    # --- settings: checked here, in force at the next tick
    def _publish(self, wanted: Wanted) -> None:
        with self._lock:
            wanted.generation = self._wanted.generation + 1
            grip = grip_named(self._grip_name)
            wanted.grip, wanted.target = grip, self._target
            values, words = wanted.encode()
            law = wanted.environment.force.compiled()
            self._kept[law.address] = (wanted.generation, law)
            block.publish(*self._block, values, words)
            self._wanted = wanted
            accepted = int(load_acquire(self._rig.control, rig.ACCEPTED))
            self._kept = {address: kept for address, kept in self._kept.items() if kept[0] >= accepted}

    def _changed(self, **changes) -> None:
        with self._lock:
            self._publish(Wanted(**{**vars(self._wanted), **changes}))

    @property
    def environment(self) -> Environment:
        return self._wanted.environment

    @property
    def values(self) -> dict[str, float]:
        return dict(self._wanted.values)

    @property
    def loop(self) -> LoopSettings:
        return self._wanted.loop

    @property
    def grip(self) -> str:
        return self._grip_name

    def set_environment(self, key: str | Environment, values: Mapping[str, object] | None = None) -> None:
        """Switch to an environment, cross-faded over 30 ms; raise ParameterError."""
        chosen = _environment(key)
        self._changed(environment=chosen, values=chosen.values(values))

    def set_parameter(self, key: str, value: object) -> None:
        """Change one parameter; raise ParameterError, and the loop keeps the last good value."""
        current = {p.key: self._wanted.values[p.key] for p in self.environment.parameters}
        self._changed(values=self.environment.values({**current, key: value}))

    def set_loop(
        self, rate: float | None = None, delay: float | None = None, estimator: Spec | None = None
    ) -> None:
        """Change rate in Hz, added delay in s, velocity estimator; raise ParameterError."""
        own_rate = self._driver.rate if self._driver is not None else None
        if rate is not None and own_rate not in (None, rate):
            raise ParameterError(f"{self.device.title} sets the rate: {own_rate:g} Hz, not {rate:g} Hz.")
        self._changed(loop=self.loop.changed(rate, delay, estimator))
        if rate is not None:
            self._watch.forget()

    def set_grip(self, name: str) -> None:
        """Choose how firmly the hand holds: released, light, medium, firm; raise ParameterError."""
        grip_named(name)
        self._grip_name = name
        self._hand_moved()

    def move_hand(self, target: float | None) -> None:
        """Move the hand's target to a position in m, None lets go; raise ParameterError."""
        if target is not None and not math.isfinite(target):
            raise ParameterError(f"The hand's target must be a finite number of m, not {target:g}.")
        self._target = target
        self._hand_moved()

    def _hand_moved(self) -> None:
        self._changed()
        if self._driver is not None:
            self._driver.move_hand(self._target, self._grip_name)

    def zero_here(self) -> None:
        """Make the present position the zero of a real board; the force fades in again."""
        self._count_up(rig.ZERO)

    def flip_direction(self) -> None:
        """Turn the positive direction of a real board around; the force fades in again."""
        self._count_up(rig.FLIP)

    def _count_up(self, word: int) -> None:
        store_release(self._rig.control, word, int(self._rig.control[word]) + 1)

    # --- safety
    def stop(self) -> None:
        """E-stop: zero force from the next tick until released on purpose."""
        store_release(self._rig.control, rig.STOP, 1)

    def release_stop(self) -> None:
        """Release the E-stop; the force fades in from zero."""
        store_release(self._rig.control, rig.STOP, 0)

    @property
    def stopped(self) -> bool:
        return bool(load_acquire(self._rig.control, rig.STOP))

    @property
    def fault(self) -> faults.Fault | None:
        return faults.describe(int(load_acquire(self._rig.control, rig.FAULT)), self._rig)

    def clear_fault(self) -> None:
        """Clear a latched fault; the law starts anew, the force fades in from zero."""
        self._count_up(rig.CLEAR)

    # --- what comes back
    def reader(self) -> RingReader:
        """Return a reader of all rows from now on, with a cursor of its own."""
        return RingReader(self._ring)

    def health(self) -> Health:
        """Return how the loop is doing; call it at a few hertz."""
        control = self._rig.control
        rate, late, missed_lately = self._watch.look(control, self._late)
        running = self._thread is not None and self._thread.is_alive()
        gone = int(control[rig.FAULT]) == rig.DEVICE_GONE
        return Health(
            rate=rate,
            lateness_us=late,
            missed=int(control[rig.MISSED]),
            lost_frames=int(control[rig.LOST_FRAMES]),
            crc_errors=int(control[rig.CRC_ERRORS]),
            stale_count=int(control[rig.STALE_COUNT]),
            stale=bool(self._rig.word[rig.STALE]),
            priority=self._priority_now(),
            delay=self._driver.delay(self._rig) if self._driver else self.loop.delay,
            running=running,
            connected=running and not gone,
            message=self._message,
            missed_lately=missed_lately,
        )

    def _priority_now(self) -> Priority:
        thread = self._thread
        if thread is None or not thread.is_alive() or thread.native_id is None:
            return self._priority
        return priority.held(self._priority, thread.native_id)

    @property
    def arrays(self) -> rig.Rig:
        """Return the loop's arrays, for tests and benchmarks."""
        return self._rig

    @property
    def driver(self) -> Driver | None:
        """Return what moves the loop now, for tests and benchmarks."""
        return self._driver

    @property
    def lateness_bins(self) -> np.ndarray:
        """Return the lateness histogram since the start, int64 bins."""
        return self._late
