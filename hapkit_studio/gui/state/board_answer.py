"""Polls the board's plan for the current settings, or the reason why the board refuses them."""

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.gui.state.device_link import DeviceLink

POLL_MS = 30


class BoardAnswer(QObject):
    """Emits ``changed`` when the board's rate, its processor load or its refusal has changed."""

    changed = Signal()

    def __init__(self, device: DeviceLink):
        super().__init__(device)
        self._device = device
        self._answer: tuple = ()
        self._timer = QTimer(self, interval=POLL_MS, singleShot=True)
        self._timer.timeout.connect(self.poll)
        device.engine_changed.connect(self.poll_soon)

    def poll_soon(self) -> None:
        """Poll after POLL_MS, because a setting has changed."""
        self._timer.start()

    def poll(self) -> None:
        """Poll once. If the answer is known and new, emit ``changed``; if it is unknown, poll again later."""
        engine = self._device.engine
        if engine is None or not engine.device.has_board:
            return
        decision = engine.decision()
        if decision.pending:
            self._timer.start()
            return
        plan = decision.plan
        answer = (decision.where, plan and (plan.rate, plan.share), decision.refusal)
        if answer != self._answer:
            self._answer = answer
            self.changed.emit()
