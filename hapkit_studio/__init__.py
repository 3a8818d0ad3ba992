"""Hapkit Studio: feel, tune and measure virtual environments on a real or simulated Hapkit."""

from importlib import import_module

from hapkit_studio.version import __version__

TYPE_CHECKING = False  # importing typing would take longer than all other imports here
if TYPE_CHECKING:
    from hapkit_studio import environments
    from hapkit_studio.analysis.stability.limits import stable_stiffnesses, stiffness_limit
    from hapkit_studio.analysis.stability.rendered import measured_stiffness_limit
    from hapkit_studio.api import Run, open_session, simulate
    from hapkit_studio.devices.simulated import SimulatedHapkit
    from hapkit_studio.dynamics.estimators import estimate_velocity
    from hapkit_studio.dynamics.hand import Hand, Prescribed
    from hapkit_studio.dynamics.integrators import integrate
    from hapkit_studio.dynamics.stick_slip import stick_slip
    from hapkit_studio.errors import LawError, ParameterError, StudioError
    from hapkit_studio.workshop import load_environment

_PLACES = {
    "Run": "api",
    "open_session": "api",
    "simulate": "api",
    "load_environment": "workshop",
    "stable_stiffnesses": "analysis.stability.limits",
    "stiffness_limit": "analysis.stability.limits",
    "measured_stiffness_limit": "analysis.stability.rendered",
    "estimate_velocity": "dynamics.estimators",
    "integrate": "dynamics.integrators",
    "stick_slip": "dynamics.stick_slip",
    "Hand": "dynamics.hand",
    "Prescribed": "dynamics.hand",
    "SimulatedHapkit": "devices.simulated",
    "LawError": "errors",
    "ParameterError": "errors",
    "StudioError": "errors",
}
__all__ = [
    "Hand",
    "LawError",
    "ParameterError",
    "Prescribed",
    "Run",
    "SimulatedHapkit",
    "StudioError",
    "__version__",
    "environments",
    "estimate_velocity",
    "integrate",
    "load_environment",
    "measured_stiffness_limit",
    "open_session",
    "simulate",
    "stable_stiffnesses",
    "stick_slip",
    "stiffness_limit",
]


def __getattr__(name: str):
    """Import a public name at its first use, so that the start is fast."""
    if name == "environments":
        return import_module("hapkit_studio.environments")  # this package can also be called
    if name in _PLACES:
        return getattr(import_module(f"hapkit_studio.{_PLACES[name]}"), name)
    raise AttributeError(f"module 'hapkit_studio' has no attribute {name!r}")
