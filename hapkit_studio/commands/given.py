"""Words of the command line turned into what the studio takes."""

import argparse
from collections.abc import Sequence
from typing import Any

from hapkit_studio import environments
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.dynamics.estimators import ESTIMATORS, Spec
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.workshop import asking

ESTIMATOR_HELP = f"{', '.join(ESTIMATORS)}; options as iir:cutoff=20"


def environment(wanted: str, trust: bool) -> Environment:
    """Return an environment by its key or its Python file; raise ParameterError."""
    return asking.environment(wanted, trust) if wanted.endswith(".py") else environments.named(wanted)


def key_values(
    pairs: Sequence[str], what: str = "A parameter", like: str = "stiffness=400"
) -> dict[str, object]:
    """Return {key: number or word} of KEY=VALUE pairs; raise ParameterError that names what they are."""
    found: dict[str, object] = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key or not value:
            raise ParameterError(f"{what} is given as KEY=VALUE, e.g. {like}, not {pair!r}.")
        try:
            found[key] = float(value)
        except ValueError:
            found[key] = value
    return found


def estimator_spec(text: str) -> Spec:
    """Return an estimator of ``iir`` or ``iir:cutoff=20``; raise ParameterError."""
    name, colon, options = text.partition(":")
    if not colon:
        return name
    numbers = key_values(options.split(","), "An option", "cutoff=20")
    for key, value in numbers.items():
        if not isinstance(value, float):
            raise ParameterError(f"The estimator's {key} takes a number, not {value!r}.")
    return name, numbers  # type: ignore[return-value]


SETTING = {
    "mass": ("kg", "of the handle"),
    "viscous": ("N·s/m", "the handle's own damping"),
    "coulomb": ("N", "the handle's friction"),
    "quantum": ("m", "the sensor's steps"),
    "rate": ("Hz", "of the loop"),
    "delay": ("s", "from a sample to its force"),
}


def setting_options(command: argparse.ArgumentParser) -> None:
    """Declare what a Setting is made of; what is not given is None."""
    usual = Setting()
    for name, (unit, words) in SETTING.items():
        shown = f"{words}; {getattr(usual, name):g}"
        command.add_argument(f"--{name}", type=float, metavar=unit, help=shown)
    command.add_argument("--estimator", metavar="NAME", help=ESTIMATOR_HELP)
    command.add_argument("--hand", metavar="GRIP", help=", ".join(GRIPS))
    command.add_argument("--controller", action="store_true", help="with the passivity controller")


def of_options(options: argparse.Namespace, names: Sequence[str]) -> dict[str, Any]:
    """Return {name: value} of the options that were given, the estimator read; raise ParameterError."""
    found = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    if "estimator" in found:
        found["estimator"] = estimator_spec(found["estimator"])
    return found


def setting(options: argparse.Namespace) -> Setting:
    """Return the Setting of what was given; raise ParameterError."""
    given = of_options(options, (*SETTING, "estimator", "hand"))
    return Setting(**given, controller=options.controller)
