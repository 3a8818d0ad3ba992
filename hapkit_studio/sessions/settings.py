"""What is set on an engine, and what its device is, by the names that a run's settings have."""

import math
from typing import Any

from hapkit_studio import __version__
from hapkit_studio.environments.base import Environment
from hapkit_studio.formatting import plain
from hapkit_studio.haptics.engine import Engine


def of_scene(environment: Environment, values: dict[str, float]) -> dict[str, Any]:
    """Return environment, its values in SI, choices by name, and their units."""
    parameters = environment.parameters
    return {
        "environment": environment.key,
        "parameters": {p.key: p.text(values[p.key]) if p.discrete else values[p.key] for p in parameters},
        "units": {p.key: p.unit for p in parameters if p.unit},
    }


def in_force(engine: Engine) -> dict[str, Any]:
    """Return what is set at this moment, as JSON has it."""
    modelled, loop = engine.modelled, engine.loop
    device = {} if modelled is None else vars(modelled)
    return {
        **of_scene(engine.environment, engine.values),
        "state_names": list(engine.environment.state_names),
        "grip": engine.grip,
        "render": engine.where,
        "rate_Hz": loop.rate,
        "delay_s": loop.delay,
        "estimator": plain(loop.estimator),
        "controller": loop.controller,
        "max_force_N": engine.max_force,
        "device": {k: repr(v) if math.isinf(v) else v for k, v in device.items()} or engine.device.title,
    }


def about_device(engine: Engine) -> dict[str, Any]:
    """Return what the device is: its name, its sensor; of a board firmware and calibration too."""
    device = engine.device
    found = {"device": device.title, "quantum_m": device.quantum, "studio": __version__}
    hello = getattr(device, "hello", None)
    if hello is not None:
        found |= {"firmware": hello.build, "protocol": hello.version}
    return found
