"""The engine connects the window to the loop: it passes parameters, never forces, and never waits."""

import math
import threading
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hapkit_studio import environments, lab
from hapkit_studio.devices import delays
from hapkit_studio.devices.base import Device
from hapkit_studio.devices.delays import MeasuredDelay
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import BOARD, COMPUTER, GRIP, RENDERERS, LoopSettings
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.errors import ParameterError, StudioError
from hapkit_studio.haptics import arrays, block, board_plan, health, link, passivity, priority
from hapkit_studio.haptics.block_content import BlockContent
from hapkit_studio.haptics.board_plan import (
    BackgroundPlanner,
    BoardPlan,
    BoardPlanner,
    PlanRequest,
    RenderingDecision,
)
from hapkit_studio.haptics.clib import load_acquire, store_release
from hapkit_studio.haptics.drivers import Driver, driver_for, no_board
from hapkit_studio.haptics.health import Fault, Health, Watch
from hapkit_studio.haptics.priority import Priority
from hapkit_studio.haptics.rows import RingReader, new_ring

STARTING = Priority("Starting")
JOIN_SECONDS = 2.0
LATELY = 2000  # number of newest delays that are evaluated; they span one or two seconds
FIRST_LOOP = LoopSettings(hand=GRIP.default_option, viscous=0.0, coulomb=0.0)
"""Settings before a device is open."""


def _environment(named: str | Environment) -> Environment:
    return named if isinstance(named, Environment) else environments.named(named)


class Engine:
    """Runs one device's loop in a thread and passes settings to the loop."""

    def __init__(self, device: Device, environment: str | Environment = "wall", realtime: bool = True):
        self.device = device
        self._realtime = realtime
        self.arrays = arrays.new_arrays(block.new_block())
        self._ring = new_ring(self.arrays.control)
        self.lateness_bins = health.new_histogram()
        """The lateness histogram since the start, int64 bins."""
        self._health_monitor = Watch()
        self.driver: Driver | None = None
        self._thread: threading.Thread | None = None
        self._priority = STARTING
        self._message = ""
        self._lock = threading.RLock()
        # compiled laws by address, each with the last settings generation that used the law
        self.retained_laws: dict[int, tuple[int, object]] = {}
        self._titles: dict[int, str] = {}  # titles of environments, by the address of their law
        self._planning = BackgroundPlanner(self._planned)
        chosen = _environment(environment)
        self._content = BlockContent(chosen, chosen.values(), FIRST_LOOP)

    # --- start and end
    def start(self) -> None:
        """Open the device and start the loop; raise DeviceError if this fails.

        The very first start compiles the loop.
        """
        self.close()
        self.driver, self._message = driver_for(self.device), ""
        try:
            self._begin(self.driver)
        except BaseException:
            self.driver.close()
            raise

    def _begin(self, driver: Driver) -> None:
        self._content.decision = RenderingDecision()  # discard the decision for the previous device
        known = {key: getattr(self.device, key) for key in ("mass", "viscous", "quantum")}
        known["max_force"] = self._highest_limit()
        self._change_loop(rate=driver.rate or self.loop.rate, **known)
        # compile or load the loop; ``quit`` is set, so it renders nothing
        store_release(self.arrays.control.quit, 0, 1)
        driver.run(self.arrays, new_ring(self.arrays.control, 2), self.lateness_bins)
        self.lateness_bins[:] = 0
        arrays.restart(self.arrays, driver.zero_force_seconds)
        self._health_monitor.forget()
        self._thread = threading.Thread(
            target=self._own_thread, args=(driver,), name="hapkit-loop", daemon=True
        )
        self._thread.start()

    def _own_thread(self, driver: Driver) -> None:
        self._priority = priority.obtain() if self._realtime else Priority("Normal priority")
        try:
            driver.run(self.arrays, self._ring, self.lateness_bins)
        except StudioError as error:
            if self.fault is None:
                store_release(self.arrays.control.fault, 0, arrays.DEVICE_GONE)
            self._message = str(error)
        finally:
            priority.release()

    def close(self) -> None:
        """Stop the loop and disconnect the device; the last force that the loop sends is zero."""
        store_release(self.arrays.control.quit, 0, 1)
        if self._thread is not None:
            self._thread.join(JOIN_SECONDS)
            self._thread = None
        if self.driver is not None:
            self.driver.close()
            self.driver = None
        self._planning.close()

    def use(self, device: Device) -> None:
        """Change to a different device; settings and readers stay the same.

        If DeviceError is raised, the force is zero.
        """
        self.close()
        self.device = device
        self.start()

    # --- settings are checked here and used from the next tick on
    def _change(self, **changes: Any) -> None:
        """Publish the block's content with some values replaced."""
        with self._lock:
            content = replace(self._content, **changes, generation=self._content.generation + 1)
            device = self._modelled(content.environment, content.values, content.settings.model)
            if device is not None:
                content.settings = replace(
                    content.settings, mass=device.mass, viscous=device.viscous, coulomb=device.coulomb_force,
                    quantum=device.quantum,
                )  # fmt: skip
            content.decision = self._decide(content, self._content.decision)
            self._write(content)
            self._content = content

    def _change_loop(self, **changes: Any) -> None:
        with self._lock:
            self._change(settings=replace(self.loop, **changes))

    def _write(self, content: BlockContent) -> None:
        """Write settings to the loop's block; keep every law in memory as long as the loop may call it."""
        encoded, law = content.encode(), content.environment.force.compiled()
        accepted = int(load_acquire(self.arrays.control.accepted, 0))
        self.retained_laws[law.address] = content.generation, law
        self._titles[law.address] = content.environment.title
        block.publish(self.arrays.block, encoded)
        self.retained_laws = {key: law for key, law in self.retained_laws.items() if law[0] >= accepted}

    @property
    def environment(self) -> Environment:
        return self._content.environment

    @property
    def values(self) -> dict[str, float]:
        return dict(self._content.values)

    @property
    def loop(self) -> LoopSettings:
        """Return the current loop settings, with the device's properties that the loop uses."""
        return self._content.settings

    @property
    def grip(self) -> str:
        """Return the grip of the simulated hand."""
        return self.loop.hand

    @property
    def modelled(self) -> SimulatedHapkit | None:
        """Return the device model with the terms that are simulated now; None for hardware."""
        return self._modelled(self.environment, self._content.values, self.loop.model)

    def _modelled(self, environment: Environment, values: Values, terms: str) -> SimulatedHapkit | None:
        model: SimulatedHapkit | None = self.device.model
        if model is None:
            return None
        if terms == "scene":
            return model.reduced(environment.needed_at(values))
        return model.without(("coulomb",) if terms == "frictionless" else ())

    @property
    def max_force(self) -> float:
        """Return the current force limit in N; it is at most the device's force limit."""
        return self.loop.max_force

    def set_environment(self, key: str | Environment, values: Mapping[str, object] | None = None) -> None:
        """Switch to an environment with a cross-fade of 30 ms.

        Raise ParameterError for a wrong key or value.
        """
        chosen = _environment(key)
        self._change(environment=chosen, values=chosen.values(values))

    def replace_environment(
        self, present: Environment, its_values: Mapping[str, float], key: str | Environment, values: Mapping
    ) -> bool:
        """Switch to an environment only if ``present`` is still rendered with the given values.

        Return True if the environment was switched.
        """
        with self._lock:
            still = self.environment is present and self.values == its_values
            if still:
                self.set_environment(key, values)
            return still

    def set_parameter(self, key: str, value: object) -> None:
        """Change one parameter; if ParameterError is raised, the loop keeps the last valid value."""
        self.put_values(self.environment.changed(self._content.values, {key: value}))

    def put_values(self, values: Mapping[str, float]) -> None:
        """Change the environment's parameters to values that were already checked."""
        self._change(values=values)

    def set_loop(self, **changes: Any) -> None:
        """Change loop settings, except the choice of renderer (see ``set_where``).

        Raise ParameterError for a wrong setting.
        """
        checked = self.loop.changed(**changes)
        self.change_loop({key: getattr(checked, key) for key in changes})

    def change_loop(self, changes: Mapping[str, Any]) -> None:
        """Change checked loop settings; raise ParameterError if the device has a different rate."""
        rate = changes.get("rate")
        own_rate = self.driver.rate if self.driver is not None else None
        if rate is not None and own_rate not in (None, rate):
            raise ParameterError(
                f"{self.device.title} sets the rate itself: {own_rate:,g} Hz, not {rate:,g} Hz."
            )
        self._change_loop(**changes)
        if rate is not None:
            self._health_monitor.forget()
        if "hand" in changes:
            self._apply_hand()

    def limit_force(self, newtons: float) -> None:
        """Limit the force to a value in N, which may not exceed the highest permitted limit.

        Raise ParameterError for a value that is too high or not positive, and DeviceError if the lab's limit
        is unknown.
        """
        most = self._highest_limit()
        if not 0.0 < newtons <= most:
            raise ParameterError(f"The force limit must be 0 to {most:g} N, not {newtons:g} N.")
        self._change_loop(max_force=newtons)

    def _highest_limit(self) -> float:
        """Return the lower one of the device's force limit and the lab's limit in N.

        Raise DeviceError if the lab's limit is unknown.
        """
        return min(self.device.max_force, lab.force_limit())

    def move_hand(self, target: float | None) -> None:
        """Move the hand's target to a position in m; None releases the handle.

        Raise ParameterError for a position that is not finite.
        """
        if target is not None and not math.isfinite(target):
            raise ParameterError(f"The hand's target must be a finite number in m, not {target:g}.")
        self._change(target=target)
        self._apply_hand()

    def release_at_rest(self) -> None:
        """Release a simulated handle at its current position with zero speed."""
        with self._lock:
            self._change(target=None, releases=self._content.releases + 1)

    def _apply_hand(self) -> None:
        """Pass the hand's target and grip to the driver of a device that has a simulated hand."""
        if self.driver is not None:
            self.driver.move_hand(self._content.target, self.grip)

    # --- where rendering happens, on the computer or the board: changes take effect after the handover
    @property
    def where(self) -> str:
        """Return which of "computer" and "board" shall render."""
        return self.decision().where

    @property
    def rendering(self) -> str:
        """Return where rendering happens now; during a handover this is "computer"."""
        on_board = self.driver is not None and self.driver.conn.state.handover == link.ON_BOARD
        return BOARD if on_board else COMPUTER

    def set_where(self, where: str, rate: float | None = None) -> None:
        """Let the "computer" or the "board" render.

        ``rate`` is the board's rate in Hz; None selects the fastest rate for the law. The force fades out and
        in again. Raise ParameterError if it is known that the board cannot render.
        """
        if where not in RENDERERS:
            raise ParameterError(
                f"The force must be computed by the {' or the '.join(RENDERERS)}, not by {where!r}."
            )
        if where == BOARD and (refusal := self.decision().refusal):
            raise ParameterError(refusal)
        self.prefer(where, rate)
        if where == BOARD and self.arrays.control.fault[0] == arrays.SLOW_LINK:
            self.clear_fault()  # a slow link is no problem for rendering on the board

    def prefer(self, where: str, rate: float | None = None) -> None:
        """Choose who renders all scenes for which this is possible; raise ParameterError for a wrong rate."""
        board_plan.check_rate(rate)
        self._change_loop(where=where, board_rate=rate)

    def decision(self, wait: bool = False) -> RenderingDecision:
        """Return the decision whether computer or board renders the current settings.

        A law that is new to the board is compiled in the background. Until this is done the decision is
        pending, unless ``wait`` is true.
        """
        known = self._content.decision
        decided = self._decide(self._content, known, wait)
        # the loop has not received the plan yet
        if decided.where == BOARD and decided.in_force != known.in_force:
            return replace(decided, pending=True, in_force=known.in_force)
        return decided

    def _decide(
        self, content: BlockContent, last: RenderingDecision, wait: bool = False
    ) -> RenderingDecision:
        """Decide who renders the given content; while the decision is pending, return ``last``."""
        answer, wanted = self._plan(content, wait), content.settings.where == BOARD
        if isinstance(answer, BoardPlan):
            refusal = self.driver.refusal(answer) if self.driver is not None else ""
        else:
            refusal = last.refusal if answer is None else answer
        on_board, plan = wanted and not refusal, answer if isinstance(answer, BoardPlan) else None
        in_force = last.in_force if answer is None else plan
        return RenderingDecision(
            BOARD if on_board else COMPUTER, plan, refusal, answer is None, in_force if on_board else None
        )

    def _plan(self, content: BlockContent, wait: bool) -> BoardPlan | str | None:
        """Return the board's plan for a block's content, or the reason why the board cannot render it.

        Return None while the plan is being computed.
        """
        driver = self.driver
        if driver is None:
            return "No device is open." if self.device.has_board else no_board(self.device)
        if driver.planner is None:
            return driver.no_planner
        # a board reports its limit as a 32-bit number, which may exceed the same decimal number
        if np.float32(content.settings.max_force) < np.float32(self.device.max_force):
            return (
                "The force limit is set below the board's limit. Only the computer can apply a lower limit."
            )
        request = self._request(content)
        return driver.planner.plan(request) if wait else self._planning.plan(driver.planner, request)

    def _request(self, content: BlockContent) -> PlanRequest:
        scene, loop = (content.environment, dict(content.values)), content.settings
        return PlanRequest(*scene, loop.estimator, self.device.quantum, loop.board_rate)

    @property
    def plan_request(self) -> PlanRequest:
        """Return the request for the board to render the current settings."""
        return self._request(self._content)

    def _planned(self, planner: BoardPlanner) -> None:
        """Use a plan from the background thread."""
        with self._lock:
            if self.driver is None or self.driver.planner is not planner:
                return
            if self.loop.where == BOARD:
                self._change()
            else:
                self._content.decision = self._decide(self._content, self._content.decision)

    def delay_of(self, where: str) -> MeasuredDelay | None:
        """Return the recently measured delay in s of the computer or the board.

        Return None if it is not measured yet.
        """
        if self.driver is None:
            return None
        which = delays.OF_BOARD if where == BOARD else delays.OF_COMPUTER
        return delays.measured_delay(self.driver.conn.delays, which, LATELY)

    def loop_of(self, where: str, delay: float, hand: str = "released") -> LoopSettings | None:
        """Return the loop settings for rendering by the "computer" or the "board".

        Return None if the board cannot render the law, or if its plan is not known yet.
        """
        loop, modelled, decision = self.loop, self.modelled or self.device, self.decision()
        rate, estimator, controller = loop.rate, loop.estimator, loop.controller
        if where == BOARD and self.device.has_board:
            plan = decision.in_force or decision.plan
            if plan is None:
                return None
            rate, estimator, controller = plan.rate, board_plan.spec_on_board(estimator), False
        return replace(
            loop, rate=rate, delay=delay, estimator=estimator, controller=controller, hand=hand,
            mass=self.device.mass, viscous=modelled.viscous, coulomb=modelled.coulomb_force,
            quantum=modelled.quantum,
        )  # fmt: skip

    def missed_of(self, where: str) -> int:
        """Return the number of late answers of the computer, or of ticks that the board skipped."""
        skipped = 0 if self.driver is None else int(self.driver.conn.state.skipped)
        return skipped if where == BOARD else max(int(self.arrays.control.missed[0]) - skipped, 0)

    def zero_here(self) -> None:
        """Set a real board's zero to the current position; the force fades in again."""
        self._count_up(self.arrays.control.zero)

    def flip_direction(self) -> None:
        """Reverse the positive direction of a real board; the force fades in again."""
        self._count_up(self.arrays.control.flip)

    def _count_up(self, word: np.ndarray) -> None:
        store_release(word, 0, int(word[0]) + 1)

    def stop(self) -> None:
        """E-stop: the force is zero from the next tick on until the stop is released."""
        store_release(self.arrays.control.stop, 0, 1)

    def release_stop(self) -> None:
        """Release the E-stop; the force fades in from zero."""
        store_release(self.arrays.control.stop, 0, 0)

    @property
    def stopped(self) -> bool:
        return bool(load_acquire(self.arrays.control.stop, 0))

    @property
    def fault(self) -> Fault | None:
        code = int(load_acquire(self.arrays.control.fault, 0))
        title = self._titles.get(int(self.arrays.tick.slow_law))
        return health.describe_fault(code, self.arrays, f"the law of {title}" if title else "the law")

    @property
    def clock_jumps(self) -> int:
        """Return how often the board's clock jumped back, stopped or jumped ahead."""
        return health.count_link(self.arrays.control).clock_jumps

    def clear_fault(self) -> None:
        """Clear a latched fault.

        The law restarts from its initial state, and the force fades in from zero.
        """
        self._count_up(self.arrays.control.clear)

    # --- measurements
    def reader(self) -> RingReader:
        """Return an independent reader of all rows that are written from now on."""
        return RingReader(self._ring)

    def renders(self, environment: Environment) -> bool:
        """Return True if the newest rows contain this environment's state.

        This means that the tick has switched to the environment.
        """
        law = int(self.arrays.laws[self.arrays.tick.slot])
        return environment is self.environment and law == environment.force.compiled().address

    @property
    def settled(self) -> bool:
        """Return True if the cross-fade has ended.

        The newest rows then come only from the environment's law.
        """
        r = self.arrays
        if not self.renders(self.environment) or r.tick.blend < 1.0:
            return False
        if self.driver is None or self.rendering != BOARD:
            return True
        known = r.settings.code_id == self.driver.conn.state.code_id
        return bool(known and r.settings.board_law == r.settings.law)

    @property
    def excess(self) -> tuple[float, float]:
        """Return the law's energy beyond its limit in J, and the threshold in J above which this is felt."""
        watch, quantum = self.arrays.watch, float(self.arrays.settings.quantum)
        felt = passivity.FELT + passivity.COUNTS * quantum * float(watch.peak)
        return float(watch.alarm.excess), felt

    def health(self) -> Health:
        """Return the loop's health; call this method a few times per second.

        If the device disconnects, the loop ends at once. From then on ``message`` describes the reason.
        """
        control, thread, current = self.arrays.control, self._thread, self._priority
        rate, late, missed_lately = self._health_monitor.poll(control, self.lateness_bins)
        running = thread is not None and thread.is_alive()
        delay: float | None = self.loop.delay
        if self.driver is not None and self.device.measures_delay:
            measured = self.delay_of(self.rendering)
            delay = None if measured is None else measured.mean
        if thread is not None and running and thread.native_id is not None:
            current = priority.current(current, thread.native_id)
        return Health(
            rate=rate,
            lateness_us=late,
            missed=int(control.missed[0]),
            stale=health.stale_reason(self.arrays),
            link=health.count_link(control),
            priority=current,
            delay=delay,
            running=running,
            message=self._message,
            missed_lately=missed_lately,
        )
