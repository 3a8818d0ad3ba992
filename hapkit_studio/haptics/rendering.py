"""Who renders, the computer or the board: chosen here, in force once the loop has handed over."""

import threading
from typing import Any

from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, board_plan
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest
from hapkit_studio.haptics.drivers import Driver, SimulatedDriver
from hapkit_studio.haptics.link import MeasuredDelay
from hapkit_studio.haptics.settings_writer import BoardWay, Wanted

WAYS = COMPUTER, BOARD = "computer", "board"


class Rendering:
    """The part of an engine's settings that says who renders."""

    device: Any
    _wanted: Wanted
    _driver: Driver | None
    _lock: threading.RLock
    _rig: arrays.LoopArrays
    _where = COMPUTER
    _board_rate: float | None = None
    _next: tuple[BoardPlanner, PlanRequest] | None = None
    _worker: threading.Thread | None = None

    def _changed(self, **changes: Any) -> None:
        raise NotImplementedError

    def clear_fault(self) -> None:
        raise NotImplementedError

    @property
    def where(self) -> str:
        """Return who is to render, "computer" or "board"; what the board cannot render stays here."""
        if self._where == BOARD and self.renders_on_boards and not self.board_refusal():
            return BOARD
        return COMPUTER

    @property
    def where_wanted(self) -> str:
        """Return who is to render wherever that is possible."""
        return self._where

    @property
    def board_way(self) -> BoardWay | None:
        """Return how the board is to render the scene in force, None while the computer renders."""
        way = self._wanted.board
        refused = way is not None and self._driver is not None and self._driver.refusal(way)
        return None if refused else way

    @property
    def offered_way(self) -> BoardWay | None:
        """Return how the board would render the scene in force; None where it cannot, or nobody knows yet."""
        offer = self._offer()
        found = None if isinstance(offer, str) else self._answer(offer, self._wanted)
        return found if isinstance(found, BoardWay) else None

    def board_refusal(self, wait: bool = False) -> str:
        """Return in one line why the board cannot render the scene in force; "" if it can.

        A law that is new to it is compiled in the background: "" until that is done, unless one can wait.
        """
        offer, driver = self._offer(), self._driver
        if isinstance(offer, str):
            return offer
        found = self._answer(offer, self._wanted, wait)
        if isinstance(found, BoardWay):
            return "" if driver is None else driver.refusal(found)
        return found or ""

    def _offer(self) -> BoardPlanner | str:
        """Return what the open board offers, or in one line why there is none for any law."""
        driver = self._driver
        if driver is None:
            return SimulatedDriver.no_offer if self.device.simulated else "No device is open."
        if driver.offer is None:
            return driver.no_offer
        if self._wanted.max_force < self.device.max_force:
            return "The force limit is lowered, which only the computer keeps to."
        return driver.offer

    @property
    def renders_on_boards(self) -> bool:
        """Return whether the open device is a board that renders laws."""
        return self._driver is not None and self._driver.offer is not None

    def set_where(self, where: str, rate: float | None = None) -> None:
        """Let the "computer" or the "board" render, the latter at a rate in Hz or the law's fastest.

        The force fades out and in again. Raise ParameterError where the board is known not to be able to.
        """
        if where not in WAYS:
            raise ParameterError(f"{' or '.join(WAYS)} renders, not {where!r}.")
        refusal = self.board_refusal() if where == BOARD else ""
        if refusal:
            raise ParameterError(refusal)
        self.prefer(where, rate)
        if where == BOARD and self._arrays.control[arrays.FAULT] == arrays.SLOW_LINK:
            self.clear_fault()  # the board needs no fast link

    def prefer(self, where: str, rate: float | None = None) -> None:
        """Let one of them render every scene that it can; raise ParameterError for a rate no board has."""
        board_plan.check_rate(rate)
        with self._lock:
            self._where, self._board_rate = where, rate
            self._changed()

    def _board_way(self, wanted: Wanted) -> BoardWay | None:
        """Return how the board is to render what is wanted, None where the computer does.

        While a law is compiled the board goes on with the one that it has.
        """
        offer = self._offer()
        if self._where != BOARD or isinstance(offer, str) or wanted.max_force < self.device.max_force:
            return None
        found = self._answer(offer, wanted)
        if found is None:
            return self._wanted.board
        return found if isinstance(found, BoardWay) else None

    def _answer(self, offer: BoardPlanner, wanted: Wanted, wait: bool = False) -> BoardWay | str | None:
        """Return what the board says to something wanted, None while that is being worked out."""
        quantum, rate = self.device.quantum, self._board_rate
        wish = PlanRequest(wanted.environment, wanted.values, wanted.loop.estimator, quantum, rate)
        if wait:
            return offer.answer(wish)
        found = offer.known(wish)
        if found is None:
            self._work_out(offer, wish)
        return found

    def _work_out(self, offer: BoardPlanner, wish: PlanRequest) -> None:
        """Have a wish answered in the background; of several that wait the newest."""
        with self._lock:
            self._next = (offer, wish)
            if self._worker is None or not self._worker.is_alive():
                self._worker = threading.Thread(target=self._answer_all, name="hapkit-law", daemon=True)
                self._worker.start()

    def _answer_all(self) -> None:
        while True:
            with self._lock:
                if self._next is None:
                    self._worker = None
                    return
                (offer, wish), self._next = self._next, None
            offer.answer(wish)
            with self._lock:
                if self._where == BOARD and self._offer() is offer:
                    self._changed()

    # --- what comes back
    @property
    def rendering(self) -> str:
        """Return who renders at this moment; while one hands over to the other, the computer."""
        return BOARD if self._driver is not None and self._driver.on_board() else COMPUTER

    def delay_of(self, where: str) -> MeasuredDelay | None:
        """Return the delay in s of one way as measured lately, None where it was not yet."""
        return None if self._driver is None else self._driver.measured(where == BOARD)

    @property
    def overruns(self) -> int:
        """Return how many ticks the board has skipped since it was opened."""
        return 0 if self._driver is None else self._driver.overruns()

    def missed_of(self, where: str) -> int:
        """Return how many ticks one way has missed: answers too late, or ticks that the board skipped."""
        total = int(self._arrays.control[arrays.MISSED])
        return self.overruns if where == BOARD else max(total - self.overruns, 0)
