"""Who renders, the computer or the board: chosen here, in force once the loop has handed over."""

import threading
from typing import Any

from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import board_offer, rig
from hapkit_studio.haptics.delays import Measured
from hapkit_studio.haptics.drivers import Driver
from hapkit_studio.haptics.settings_writer import BoardWay, Wanted

WAYS = COMPUTER, BOARD = "computer", "board"


class Rendering:
    """The part of an engine's settings that says who renders."""

    device: Any
    _wanted: Wanted
    _driver: Driver | None
    _lock: threading.RLock
    _rig: rig.Rig
    _where = COMPUTER
    _board_rate: float | None = None

    def _changed(self, **changes: Any) -> None:
        raise NotImplementedError

    @property
    def where(self) -> str:
        """Return who is to render, "computer" or "board"; a scene that the board has not stays here."""
        return COMPUTER if self._wanted.board is None else BOARD

    @property
    def where_wanted(self) -> str:
        """Return who is to render wherever that is possible."""
        return self._where

    @property
    def board_way(self) -> BoardWay | None:
        """Return how the board is to render the scene in force, None while the computer renders."""
        return self._wanted.board

    def board_refusal(self, environment: Environment | None = None) -> str:
        """Return in one line why the board cannot render a scene, by default that in force; "" if it can."""
        if self.device.simulated:
            return "The simulated Hapkit has no board: the computer renders."
        if self._driver is None:
            return "No device is open."
        if self._driver.offer is None:
            return "This firmware has no laws of its own. Update firmware."
        if self._wanted.max_force < self.device.max_force:
            return "The force limit is lowered, which only the computer keeps to."
        return self._driver.offer.refusal(environment or self._wanted.environment)

    @property
    def renders_on_boards(self) -> bool:
        """Return whether the open device is a board with laws of its own."""
        return self._driver is not None and self._driver.offer is not None

    def set_where(self, where: str, rate: float | None = None) -> None:
        """Let the "computer" or the "board" render, the latter at a rate in Hz or the law's fastest.

        The force fades out and in again. Raise ParameterError where the board cannot.
        """
        if where not in WAYS:
            raise ParameterError(f"{' or '.join(WAYS)} renders, not {where!r}.")
        refusal = self.board_refusal() if where == BOARD else ""
        if refusal:
            raise ParameterError(refusal)
        self.prefer(where, rate)

    def prefer(self, where: str, rate: float | None = None) -> None:
        """Let one of them render every scene that it can; raise ParameterError for a rate no board has."""
        board_offer.check_rate(rate)
        with self._lock:
            self._where, self._board_rate = where, rate
            self._changed()

    def _board_way(self, wanted: Wanted) -> BoardWay | None:
        """Return how the board is to render what is wanted, None where the computer does."""
        if self._where != BOARD or self._driver is None or self._driver.offer is None:
            return None
        if wanted.max_force < self.device.max_force or self._driver.offer.refusal(wanted.environment):
            return None
        environment, values = wanted.environment, wanted.values
        spec = wanted.loop.estimator
        return self._driver.offer.way(environment, values, spec, self.device.quantum, self._board_rate)

    # --- what comes back
    @property
    def rendering(self) -> str:
        """Return who renders at this moment; while one hands over to the other, the computer."""
        return BOARD if self._driver is not None and self._driver.on_board() else COMPUTER

    def delay_of(self, where: str) -> Measured | None:
        """Return the delay in s of one way as measured lately, None where it was not yet."""
        return None if self._driver is None else self._driver.measured(where == BOARD)

    @property
    def overruns(self) -> int:
        """Return how many ticks the board has skipped since it was opened."""
        return 0 if self._driver is None else self._driver.overruns()

    def missed_of(self, where: str) -> int:
        """Return how many ticks one way has missed: answers too late, or ticks that the board skipped."""
        total = int(self._rig.control[rig.MISSED])
        return self.overruns if where == BOARD else max(total - self.overruns, 0)
