"""What the studio knows besides the engine: how the device is reached, and the loop as chosen."""

from dataclasses import dataclass
from typing import Any

from hapkit_studio.devices.terms import MODELS
from hapkit_studio.dynamics.estimators import USUAL


@dataclass(frozen=True)
class Link:
    """How the device is reached: state is preparing, connecting, running, idle, gone or failed.

    step, command: the next step and the line to copy of a DeviceError.
    """

    state: str
    title: str = ""
    text: str = ""
    step: str = ""
    command: str = ""


@dataclass(frozen=True)
class LoopWish:
    """The loop as chosen: rate in Hz, added delay in s, estimator key and options, model, controller on.

    where: "computer" or "board" renders; board_rate in Hz, None: as fast as the law allows.
    """

    rate: float = 1000.0
    delay: float = 0.0
    estimator: str = USUAL
    options: tuple[tuple[str, float], ...] = ()
    model: str = MODELS[0]
    controller: bool = False
    where: str = "computer"
    board_rate: float | None = None

    @property
    def spec(self) -> Any:
        """Return the estimator as the engine takes it."""
        return (self.estimator, dict(self.options)) if self.options else self.estimator
