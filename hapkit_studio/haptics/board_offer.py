"""What a board can render by itself, and how a scene is to be rendered there."""

import threading
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from hapkit_studio import environments
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.dynamics import estimators, filters
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.errors import DeviceError, ParameterError
from hapkit_studio.haptics import way
from hapkit_studio.haptics.line import Line
from hapkit_studio.haptics.settings_writer import BoardWay
from hapkit_studio.protocol.messages import VALUES, Board, Estimator, LawName, MotorMap, Origin, Settings

RATES = (4000, 2000, 1000, 500)
"""Hz at which a board renders, the fastest first."""

ESTIMATORS = {"difference": Estimator.DIFFERENCE, "iir": Estimator.IIR, "kalman": Estimator.KALMAN}
INSTEAD = "kalman"
"""The estimator of a board that does not have the one that was chosen."""


@dataclass(frozen=True)
class Offer:
    """The laws on a board by their keys, and its settings."""

    laws: Mapping[str, LawName]
    settings: Settings

    def refusal(self, environment: Environment) -> str:
        """Return in one line why the board cannot render an environment; nothing where it can."""
        title, name = environment.title, self.laws.get(environment.key)
        if not self.laws:
            return "This firmware has no laws of its own. Update firmware."
        if name is None or len(environment.parameters) > VALUES:
            return f"{title} is not on the board. Export it as a sketch, or build the firmware with it."
        if name.fingerprint != fingerprint(environment):
            return f"{title} on the board is another version than the studio's. Update firmware."
        return ""

    def way(
        self, environment: Environment, values: Values, spec: Spec, quantum: float, rate: float | None = None
    ) -> BoardWay:
        """Return how the board is to render it, at a rate in Hz or the fastest; raise ParameterError."""
        refusal = self.refusal(environment)
        if refusal:
            raise ParameterError(refusal)
        hertz = board_rate(environment, values, rate)
        kind, first, second = coefficients(spec, hertz, quantum)
        return BoardWay(self.laws[environment.key].law, hertz, kind, first, second)


def offered(device: HapkitBoard) -> Offer | None:
    """Return what an open board offers; None for one whose firmware renders nothing, or does not answer."""
    if device.hello.laws == 0:
        return None
    try:
        offer = Offer(device.laws(), device.settings())
    except DeviceError:
        return None
    threading.Thread(target=_know_versions, name="hapkit-versions", daemon=True).start()
    return offer


def _know_versions() -> None:
    """Translate every law once: a second in all, which a person who switches scenes should not wait for."""
    for environment in environments.discover().values():
        fingerprint(environment)


def board_rate(environment: Environment, values: Values, wish: float | None = None) -> int:
    """Return the rate in Hz at which the board renders a law: the wish, but no faster than it can."""
    fastest = environment.board_rate(values)
    return next(r for r in RATES if r <= fastest and (wish is None or r <= max(wish, RATES[-1])))


def check_rate(wish: float | None) -> None:
    """Raise ParameterError for a rate that no board has."""
    if wish is not None and wish not in RATES:
        rates = ", ".join(f"{rate:,}" for rate in reversed(RATES))
        raise ParameterError(f"A board renders at {rates} Hz, not at {wish:g} Hz.")


def spec_on_board(spec: Spec) -> Spec:
    """Return the velocity estimator that a board uses for the one chosen: its own, or Kalman."""
    return spec if estimators.parse(spec)[0].key in ESTIMATORS else INSTEAD


def coefficients(spec: Spec, rate: float, quantum: float) -> tuple[int, float, float]:
    """Return estimator and coefficients as the board takes them, the second one in 1/s."""
    code, coefs = estimators.design(spec_on_board(spec), rate, quantum)
    if code == filters.KALMAN:
        return int(Estimator.KALMAN), float(coefs[0]), float(coefs[1] * rate)
    if code == filters.IIR:
        return int(Estimator.IIR), float(coefs[0]), 0.0
    return int(Estimator.DIFFERENCE), 0.0, 0.0


def tell(line: Line, settings: Settings, pwm_top: int) -> None:
    """Let a connection know what the board says of its kit."""
    line.motor[: pwm_top + 1] = motor_forces(settings, pwm_top)
    body = Board(**{w.name: getattr(settings, w.name) for w in Board.layout()}).pack()
    line.settings[:] = np.frombuffer(body, np.uint8)
    line.words[way.CONFIGURABLE] = 1
    line.words[way.CALIBRATED] = settings.origin == Origin.STORED


@cache
def fingerprint(environment: Environment) -> int:
    """Return what tells one version of a law from another."""
    from hapkit_studio.laws.cpp import CppLaw  # off the first sample's way
    from hapkit_studio.laws.cpp_words import mangled

    return CppLaw(environment.force, mangled(environment.key)).fingerprint


def motor_forces(kit: Settings, top: int) -> np.ndarray:
    """Return the force in N at the handle for each duty from 0 to top, (top + 1,), by the kit's map."""
    share = np.clip((np.arange(top + 1) - kit.dead_band) / (top - kit.dead_band), 0.0, 1.0)
    if kit.motor_map == MotorMap.SQUARE:
        torque = share**2
    elif kit.motor_map == MotorMap.TABLE:
        torque = np.interp(share, np.linspace(0.0, 1.0, 9), (0, *kit.table)) / 255.0
    else:
        torque = share
    return torque * kit.motor_constant * kit.sector_radius / (kit.handle_radius * kit.pulley_radius)
