"""The engine: the one object the window talks to. It sends parameters, never forces, and never waits."""

import threading

import numpy as np

from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import StudioError
from hapkit_studio.haptics import arrays, block, health, passivity, priority
from hapkit_studio.haptics.controls import Controls
from hapkit_studio.haptics.drivers import Driver, compile_ahead, driver_for
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.haptics.health import Health, Watch, count_link
from hapkit_studio.haptics.priority import Priority
from hapkit_studio.haptics.rows import RingReader, new_ring

STARTING = Priority("Starting", False, "")
JOIN_SECONDS = 2.0


class Engine(Controls):
    """Runs one device's loop in a thread of its own and passes settings to it."""

    def __init__(self, device, environment: str | Environment = "wall", realtime: bool = True):
        super().__init__(device, environment)
        self._ring = new_ring(self._arrays.control)
        self._late = health.new_histogram()
        self._watch = Watch()
        self._thread: threading.Thread | None = None
        self._priority = STARTING
        self._realtime = realtime
        self._message = ""

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
        device = self.device
        known = {"mass": device.mass, "viscous": device.viscous, "quantum": device.quantum}
        self._changed(max_force=device.max_force, loop=loop, **known)
        compile_ahead(driver, self._arrays, self._late)
        self._late[:] = 0
        arrays.restart(self._arrays, driver.hold_seconds)
        self._watch.forget()
        self._thread = threading.Thread(
            target=self._own_thread, args=(driver,), name="hapkit-loop", daemon=True
        )
        self._thread.start()

    def _own_thread(self, driver: Driver) -> None:
        self._priority = priority.obtain() if self._realtime else Priority("Normal priority", False, "")
        try:
            driver.run(self._arrays, self._ring, self._late)
        except StudioError as error:
            if self.fault is None:
                store_release(self._arrays.control, arrays.FAULT, arrays.DEVICE_GONE)
            self._message = str(error)
        finally:
            priority.release()

    def close(self) -> None:
        """Stop the loop with a zero command and let go of the device."""
        store_release(self._arrays.control, arrays.QUIT, 1)
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

    def set_loop(
        self,
        rate: float | None = None,
        delay: float | None = None,
        estimator: Spec | None = None,
        controller: bool | None = None,
    ) -> None:
        super().set_loop(rate, delay, estimator, controller)
        if rate is not None:
            self._watch.forget()

    # --- the board
    def zero_here(self) -> None:
        """Make the present position the zero of a real board; the force fades in again."""
        self._count_up(arrays.ZERO)

    def flip_direction(self) -> None:
        """Turn the positive direction of a real board around; the force fades in again."""
        self._count_up(arrays.FLIP)

    def _count_up(self, word: int) -> None:
        store_release(self._arrays.control, word, int(self._arrays.control[word]) + 1)

    # --- safety
    def stop(self) -> None:
        """E-stop: zero force from the next tick until released on purpose."""
        store_release(self._arrays.control, arrays.STOP, 1)

    def release_stop(self) -> None:
        """Release the E-stop; the force fades in from zero."""
        store_release(self._arrays.control, arrays.STOP, 0)

    @property
    def stopped(self) -> bool:
        return bool(load_acquire(self._arrays.control, arrays.STOP))

    @property
    def fault(self) -> health.Fault | None:
        return health.describe_fault(int(load_acquire(self._arrays.control, arrays.FAULT)), self._arrays)

    def clear_fault(self) -> None:
        """Clear a latched fault; the law starts anew, the force fades in from zero."""
        self._count_up(arrays.CLEAR)

    # --- what comes back
    def reader(self) -> RingReader:
        """Return a reader of all rows from now on, with a cursor of its own."""
        return RingReader(self._ring)

    def energies(self, ticks: np.ndarray) -> np.ndarray:
        """Return (n, 2): the energy given and its limit in J at ticks (n,), nan where unknown."""
        kept = self._arrays.energies
        ticks = ticks.astype(np.int64)
        found = kept[ticks & (len(kept) - 1)]
        found[int(self._arrays.word[arrays.TICK]) - ticks >= len(kept)] = np.nan
        return found

    @property
    def excess(self) -> tuple[float, float]:
        """Return the energy in J given beyond its limit, and how much of it means something."""
        watch, quantum = self._arrays.watch, float(self._arrays.values[block.QUANTUM])
        return float(watch[passivity.EXCESS]), passivity.FELT + passivity.COUNTS * quantum * float(
            watch[passivity.PEAK]
        )

    def health(self) -> Health:
        """Return how the loop is doing; call it at a few hertz."""
        control = self._arrays.control
        rate, late, missed_lately = self._watch.look(control, self._late)
        running = self._thread is not None and self._thread.is_alive()
        return Health(
            rate=rate,
            lateness_us=late,
            missed=int(control[arrays.MISSED]),
            lost_frames=int(control[arrays.LOST_FRAMES]),
            crc_errors=int(control[arrays.CRC_ERRORS]),
            stale_count=int(control[arrays.STALE_COUNT]),
            stale=bool(self._arrays.word[arrays.STALE]),
            link=count_link(control),
            priority=self._priority_now(),
            delay=self._driver.delay(self._arrays) if self._driver else self.loop.delay,
            running=running,
            connected=running,  # a loop that the device has left ends at once, its words are there by then
            message=self._message,
            missed_lately=missed_lately,
        )

    def _priority_now(self) -> Priority:
        thread = self._thread
        if thread is None or not thread.is_alive() or thread.native_id is None:
            return self._priority
        return priority.held(self._priority, thread.native_id)

    @property
    def arrays(self) -> arrays.LoopArrays:
        """Return the loop's arrays, for tests and benchmarks."""
        return self._arrays

    @property
    def driver(self) -> Driver | None:
        """Return what moves the loop now, for tests and benchmarks."""
        return self._driver

    @property
    def lateness_bins(self) -> np.ndarray:
        """Return the lateness histogram since the start, int64 bins."""
        return self._late
