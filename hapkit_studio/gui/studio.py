"""What the person has chosen, and the engine that plays it: the window's only way to the engine."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.gui.device_link import Build, Linked, LoopWish, build_engine

if TYPE_CHECKING:
    from hapkit_studio.devices import DeviceEntry
    from hapkit_studio.haptics.engine import Engine
    from hapkit_studio.haptics.health import Fault, Health

ANSWER_MS = 30
"""How often it is looked for what the board says to a law that is being translated for it."""


class Studio(Linked):
    """Keeps every choice over a change of device; values are SI and checked before they are kept."""

    loop_changed = Signal()
    stop_changed = Signal()

    def __init__(
        self,
        entries: Callable[[], Sequence["DeviceEntry"]],
        build: Build = build_engine,
        parent: QObject | None = None,
    ):
        super().__init__(entries, build, parent)
        self.loop = LoopWish()
        self.grip = "medium"
        self.stopped = False
        self._board_said: tuple = ()
        self._answer = QTimer(self, interval=ANSWER_MS, singleShot=True)
        self._answer.timeout.connect(self._hear_board)
        for changed in (self.values_changed, self.loop_changed, self.engine_changed):
            changed.connect(self._answer.start)

    # loop and hand

    def set_loop(self, **changes: Any) -> None:
        """Change rate, delay, estimator, options, model or controller; raise ParameterError if refused."""
        wish = replace(self.loop, **changes)
        if self.engine is not None:
            plain = ("rate", "delay", "controller")
            changed: dict[str, Any] = {k: getattr(wish, k) for k in plain if k in changes}
            if "estimator" in changes or "options" in changes:
                changed["estimator"] = wish.spec
            self.engine.set_loop(**changed)
            self.engine.set_model(wish.model)
            if "where" in changes or "board_rate" in changes:
                self.engine.set_where(wish.where, wish.board_rate)
        self.loop = wish
        self.loop_changed.emit()

    def set_grip(self, grip: str) -> None:
        """Choose how firmly the simulated hand holds."""
        self.grip = grip
        if self.engine is not None:
            self.engine.set_grip(grip)
        self.loop_changed.emit()

    def move_hand(self, target: float | None) -> None:
        """Pull the handle towards a place in m; None lets go."""
        if self.engine is not None:
            self.engine.move_hand(target)

    # stopping

    def stop(self) -> None:
        """Put the force to zero at the next tick, whatever else is going on."""
        if self.engine is not None:
            self.engine.stop()
        if not self.stopped:
            self.stopped = True
            self.stop_changed.emit()

    def release_stop(self) -> None:
        """Let the force come back, faded in."""
        self.stopped = False
        if self.engine is not None:
            self.engine.release_stop()
        self.stop_changed.emit()

    @property
    def fault(self) -> "Fault | None":
        """Return the latched fault of the running engine."""
        return self.engine.fault if self.engine is not None else None

    def clear_fault(self) -> None:
        """Unlatch the fault; the force fades in again."""
        if self.engine is not None:
            self.engine.clear_fault()

    # devices

    def note_health(self, health: "Health") -> None:
        super().note_health(health)
        self._hear_board()  # it may have refused what it was sent

    def _hear_board(self) -> None:
        """Tell that the loop is another one as soon as it is known how the board would render, or why not."""
        engine = self.engine
        if engine is None or engine.device.simulated:
            return
        if not self.board_answered:
            self._answer.start()
            return
        way = engine.possible_plan
        said = (engine.where, way and (way.rate, way.share), engine.board_refusal())
        if said != self._board_said:
            self._board_said = said
            self.loop_changed.emit()

    @property
    def board_answered(self) -> bool:
        """Say whether it is known how a board renders what is in force, or why not, and the loop knows it."""
        engine = self.engine
        if engine is None or engine.board_refusal():
            return engine is not None
        way = engine.possible_plan
        return way is not None and (engine.where != "board" or engine.board_plan == way)

    @property
    def simulated(self) -> bool:
        """Say whether the device is embedded: its rate is ours, and there is nothing to calibrate."""
        return self.engine is not None and bool(self.engine.device.simulated)

    @property
    def hand_is_ours(self) -> bool:
        """Say whether mouse and keys are the hand; on a real board a person's is."""
        return self.simulated or (self.engine is not None and getattr(self.engine.device, "hand", False))

    def zero_here(self) -> None:
        """Make the present position of a real board its zero."""
        if self.engine is not None:
            self.engine.zero_here()

    def flip_direction(self) -> None:
        """Turn a real board's positive direction around."""
        if self.engine is not None:
            self.engine.flip_direction()

    # what the device in use is told

    def _set_up(self, engine: "Engine") -> None:
        super()._set_up(engine)
        self._hold(engine)

    def _hold(self, engine: "Engine") -> None:
        if self.stopped:
            engine.stop()

    def _take_over(self, engine: "Engine") -> None:
        self._hold(engine)
        engine.set_environment(self.environment, self.values)
        loop = self.loop
        engine.set_loop(delay=loop.delay, estimator=loop.spec, controller=loop.controller)
        if engine.device.simulated:
            engine.set_loop(rate=self.loop.rate)
        engine.set_grip(self.grip)
        engine.set_model(self.loop.model)
        engine.prefer(loop.where, loop.board_rate)
