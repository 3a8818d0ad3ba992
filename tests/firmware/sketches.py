"""Arduino sketches as the Arduino IDE builds them, and what they render in the virtual board."""

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio.devices import virtual_board
from hapkit_studio.dynamics.estimators import estimate_velocity
from hapkit_studio.environments.base import Environment
from hapkit_studio.workshop import own
from tests.firmware.vb import FULL_FORCE, QUANTUM, run

ARDUINO = Path("/usr/share/arduino/hardware/arduino/avr")
CORE, VARIANT = ARDUINO / "cores" / "arduino", ARDUINO / "variants" / "standard"
needs_ide = pytest.mark.skipif(
    not (virtual_board.built() and shutil.which("avr-g++") and CORE.is_dir()),
    reason="no virtual board, no avr-gcc or no Arduino core",
)

_CHIP = [
    "-mmcu=atmega328p",
    "-DF_CPU=16000000L",
    "-DARDUINO=10819",
    "-DARDUINO_AVR_UNO",
    "-DARDUINO_ARCH_AVR",
]
# the options of the core's platform.txt
_COMMON = ["-c", "-Os", "-ffunction-sections", "-fdata-sections", "-flto", f"-I{CORE}", f"-I{VARIANT}"]
_CXX = ["-std=gnu++11", "-fpermissive", "-fno-exceptions", "-fno-threadsafe-statics"]
_LANGUAGES = {
    ".c": ["avr-gcc", "-std=gnu11", "-fno-fat-lto-objects"],
    ".S": ["avr-gcc", "-x", "assembler-with-cpp"],
    ".cpp": ["avr-g++", *_CXX],
    ".ino": ["avr-g++", *_CXX, "-x", "c++", "-include", "Arduino.h"],
}
_STRICT = ["-Wall", "-Wextra", "-Werror"]
FADE = 0.5
"""s in which a sketch's force comes up."""


def core(folder: Path) -> Path:
    """Compile the Arduino core, all of it; return its archive."""
    # avr-libc 2.0 keeps this one from C++ before 2011
    options = ["-w", "-DDECIMAL_DIG=9"]
    made = [_compiled(s, folder, options) for s in sorted([*CORE.glob("*.c"), *CORE.glob("*.cpp")])]
    archive = folder / "core.a"
    subprocess.run(["avr-gcc-ar", "rcs", archive, *made], check=True)
    return archive


def build(text: str, archive: Path, folder: Path) -> Path:
    """Compile a sketch with every warning an error; return its .elf."""
    ino = folder / "sketch.ino"
    ino.write_text(text, encoding="utf-8")
    return _linked([_compiled(ino, folder, _STRICT)], archive, folder)


def build_folder(sketch: Path, archive: Path, folder: Path) -> Path:
    """Compile all files of a sketch's folder with every warning an error; return its .elf."""
    sources = [path for path in sorted(sketch.iterdir()) if path.suffix in _LANGUAGES]
    return _linked([_compiled(source, folder, _STRICT) for source in sources], archive, folder)


def _compiled(source: Path, folder: Path, options: Sequence[str]) -> Path:
    made = folder / f"{source.name}.o"
    subprocess.run([*_LANGUAGES[source.suffix], *_COMMON, *_CHIP, *options, "-o", made, source], check=True)
    return made


def _linked(objects: Sequence[Path], archive: Path, folder: Path) -> Path:
    elf = folder / "sketch.elf"
    options = ["-w", "-Os", "-flto", "-fuse-linker-plugin", "-Wl,--gc-sections"]
    subprocess.run(["avr-gcc", *options, *_CHIP, "-o", elf, *objects, archive, "-lm"], check=True)
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
    state, fault = own.law_memory(law)
    p = np.array([values[q.key] for q in environment.parameters] + [0.0])
    force = np.empty(len(position))
    assert own.call_law(law.address, p, state, position, velocity, 1.0 / rate, fault, force) == own.NO_FAULT
    fade = np.minimum(np.arange(len(force)) / rate / FADE, 1.0)
    return np.clip(force * fade, -3.0, 3.0)


def pwm_step(duty: np.ndarray) -> np.ndarray:
    """Return half a step of the duty in N, and a rounding more: at duty d, (2 d + 1) / 2 of 255^2."""
    return FULL_FORCE * (np.abs(duty) + 1.0) / 255.0**2
