"""Arduino sketches as the Arduino IDE builds them, and what they render in the virtual board."""

import subprocess
from pathlib import Path

import numpy as np

from hapkit_studio.dynamics.estimators import estimate_velocity
from hapkit_studio.environments.base import Environment
from hapkit_studio.workshop import calls
from tests.firmware.vb import FULL_FORCE, QUANTUM, run

ARDUINO = Path("/usr/share/arduino/hardware/arduino/avr")
CORE, VARIANT = ARDUINO / "cores" / "arduino", ARDUINO / "variants" / "standard"
_CHIP = [
    "-mmcu=atmega328p",
    "-DF_CPU=16000000L",
    "-DARDUINO=10819",
    "-DARDUINO_AVR_UNO",
    "-DARDUINO_ARCH_AVR",
]
_COMMON = ["-c", "-Os", "-ffunction-sections", "-fdata-sections", *_CHIP, f"-I{CORE}", f"-I{VARIANT}"]
_CXX = ["-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics", "-fpermissive"]
FADE = 0.5
"""s in which a sketch's force comes up."""


def core(folder: Path) -> Path:
    """Compile the Arduino core, all of it; return its archive."""
    made = []
    for source in sorted([*CORE.glob("*.c"), *CORE.glob("*.cpp")]):
        made.append(folder / f"{source.name}.o")
        plain = source.suffix == ".c"
        # avr-libc 2.0 keeps this one from C++ before 2011
        words = ["avr-gcc", "-std=gnu11"] if plain else ["avr-g++", *_CXX, "-DDECIMAL_DIG=9"]
        subprocess.run([*words, *_COMMON, "-w", "-o", made[-1], source], check=True)
    archive = folder / "core.a"
    subprocess.run(["avr-gcc-ar", "rcs", archive, *made], check=True)
    return archive


def build(text: str, archive: Path, folder: Path) -> Path:
    """Compile a sketch with every warning an error; return its .elf."""
    ino, made, elf = folder / "sketch.ino", folder / "sketch.o", folder / "sketch.elf"
    ino.write_text(text, encoding="utf-8")
    strict = ["-Wall", "-Wextra", "-Werror", "-include", "Arduino.h", "-x", "c++"]
    subprocess.run(["avr-g++", *_CXX, *_COMMON, *strict, "-o", made, ino], check=True)
    subprocess.run(
        ["avr-gcc", *_CHIP, "-Os", "-Wl,--gc-sections", "-o", elf, made, archive, "-lm"], check=True
    )
    return elf


def rendered(elf: Path, folder: Path, script: tuple[str, ...], seconds: float, *options: str) -> np.ndarray:
    """Return the truth log of a sketch, a row a tick, from the first one on."""
    outcome = run(elf, folder, "--seconds", str(seconds), *options, script=script)
    assert (outcome.code, outcome.errors) == (0, "")
    return outcome.truth[1:]  # setup() reads the sensor once


def positions(truth: np.ndarray, counts: int = 921, quantum: float = QUANTUM) -> np.ndarray:
    """Return where the handle is by the converter's readings alone, the first one being 0."""
    steps = np.diff(truth.converter)
    steps -= counts * np.round(steps / counts)
    return quantum * np.concatenate([[0.0], np.cumsum(steps)])


def asked(environment: Environment, values, position: np.ndarray, rate: float, spec) -> np.ndarray:
    """Return the forces of the Python law, faded in and cut as a sketch does."""
    velocity = estimate_velocity(position, rate, spec, QUANTUM)
    law = environment.force.compiled()
    state, fault = calls.memory(law)
    p = np.array([values[q.key] for q in environment.parameters] + [0.0])
    force = np.empty(len(position))
    assert calls.run(law.address, p, state, position, velocity, 1.0 / rate, fault, force) == calls.ALL
    fade = np.minimum(np.arange(len(force)) / rate / FADE, 1.0)
    return np.clip(force * fade, -3.0, 3.0)


def pwm_step(duty: np.ndarray) -> np.ndarray:
    """Return half a step of the duty in N, and a rounding more: at duty d, (2 d + 1) / 2 of 255^2."""
    return FULL_FORCE * (np.abs(duty) + 1.0) / 255.0**2
