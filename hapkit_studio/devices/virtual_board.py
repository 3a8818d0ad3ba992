"""The firmware in a simulated chip with a simulated paddle: a Hapkit without hardware."""

import contextlib
import json
import os
import select
import subprocess
import tempfile
import time
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio import interrupts, resources
from hapkit_studio.devices import DeviceEntry, DeviceKind
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.dynamics.hand import ARRIVES, LEADS, Grip, grip_named
from hapkit_studio.errors import DeviceError

START_TIME = 10.0
"""s: time-out of a reply; a busy computer may need a while to start a program."""
END_TIME = 5.0
"""s: time for writing the log and counters at the end; the EEPROM is written at every change."""


class BoardProgram:
    """The process of the virtual board: it receives commands and sends lines, both with a time-out.

    It runs from construction to ``end``. If the program fails, methods raise DeviceError with the program's
    message.
    """

    def __init__(self, command: Sequence[str]):
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        self._rest = b""
        self._summary = ""
        self._lines: list[str] = []
        try:
            with interrupts.deferred():  # Ctrl+C goes to the studio, which stops the motor first
                self._child = subprocess.Popen(
                    command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, bufsize=0
                )
        except OSError as error:
            self._errors.close()
            raise DeviceError(f"The virtual board cannot be started: {error.strerror}.") from error
        self._in, self._out = (pipe.fileno() for pipe in (self._child.stdin, self._child.stdout) if pipe)
        os.set_blocking(self._in, False)

    @property
    def pid(self) -> int:
        return self._child.pid

    def send(self, command: str) -> bool:
        """Send one command without waiting; return False if the program ended or its pipe is full."""
        try:
            return os.write(self._in, command.encode() + b"\n") > 0
        except OSError:
            return False

    def reply(self, word: str, seconds: float = START_TIME) -> str:
        """Return the rest of the next line that begins with ``word``; raise DeviceError after a time-out."""
        deadline = time.monotonic() + seconds
        while True:
            for at, line in enumerate(self._lines):
                if line.startswith(word):
                    del self._lines[: at + 1]
                    return line[len(word) :].strip()
            if not self._read(deadline - time.monotonic()):
                raise DeviceError(f"The virtual board does not answer. {self.last_output()}".strip())

    def _read(self, seconds: float) -> bool:
        ready, _, _ = select.select([self._out], [], [], max(seconds, 0.0))
        data = os.read(self._out, 4096) if ready else b""
        *whole, self._rest = (self._rest + data).split(b"\n")
        self._lines += [line.decode("utf-8", "replace") for line in whole]
        return bool(data)

    def last_output(self) -> str:
        """Return the last line of the program's standard error."""
        self._errors.seek(0)
        lines = self._errors.read().decode("utf-8", "replace").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "")

    def end(self) -> str:
        """End the program; return its summary as JSON, "" if it wrote none. This may be repeated."""
        if self._errors.closed:
            return self._summary
        self.send("quit")
        try:
            self._child.wait(END_TIME)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()
        with contextlib.suppress(DeviceError):
            self._summary = "{" + self.reply("{", END_TIME)
        for stream in (self._child.stdin, self._child.stdout, self._errors):
            if stream:
                stream.close()
        return self._summary


VARIABLE = "HAPKIT_VIRTUAL_BOARD"
"""Environment variable with the path of the program, if it is not in the checkout."""

TRUTH_COLUMNS = (
    "time", "position", "velocity", "motor_force", "duty", "hand_force", "hand_target", "converter",
)  # fmt: skip
"""Columns of the truth log in SI units; ``duty`` is signed, out of 255, and ``converter`` is 0 to 1023."""

MODES = ("paced", "lockstep", "fast")
PATIENCE = 10.0
"""s: time-out of a reply; a busy computer simulates slowly, but never loses a byte."""
HAND_PERIOD = 1.0 / 60.0
"""s: duration of the hand's movement to a new target, equal to the duration of a frame of the window."""
HOOK_PERIOD = 0.5
"""s: duration for which an attached spring moves the handle to the middle."""


def program() -> Path:
    """Return the path of the virtual board's program, which may not exist."""
    named = os.environ.get(VARIABLE)
    checkout = Path(__file__).resolve().parents[2]
    return Path(named) if named else checkout / "firmware" / "build" / "virtual_board"


def firmware() -> Path:
    """Return the firmware to run: the one next to the program if it exists, else the shipped one."""
    beside = program().with_name("hapkit.elf")
    return beside if beside.is_file() else resources.path("firmware", "hapkit.hex")


def built() -> bool:
    """Return True if program and firmware exist."""
    return os.access(program(), os.X_OK) and firmware().is_file()


def truth(path: str | Path) -> np.ndarray:
    """Return the truth log as a record array with fields TRUTH_COLUMNS, one row per sample of the sensor."""
    data = np.fromfile(path, "<f8")
    whole = data[: len(data) // len(TRUTH_COLUMNS) * len(TRUTH_COLUMNS)]
    return whole.view([(name, "<f8") for name in TRUTH_COLUMNS]).view(np.recarray)


class VirtualBoard(HapkitBoard):
    """A board in a separate process, which ``open`` starts and ``close`` ends.

    The modes are: "paced" follows the clock; "lockstep" waits for every reply and otherwise runs at full
    speed; "fast" never waits. In lockstep a lone delimiter is treated as a reply and is not passed to the
    chip. ``log`` is the path of the truth log. ``script`` is the path of a file with commands and their board
    times. ``options`` are further command-line options of the program.
    """

    simulated_hand, usb_chip = True, False
    patience = PATIENCE

    def __init__(
        self,
        mode: str = "paced",
        log: str | Path | None = None,
        script: str | Path | None = None,
        options: Sequence[str] = (),
        firmware: str | Path | None = None,
    ):
        super().__init__("", "Virtual board")
        if mode not in MODES:
            raise DeviceError(
                f"The mode of the virtual board must be one of {', '.join(MODES)}, not {mode!r}."
            )
        self.summary: dict[str, Any] = {}
        self._options = [f"--{mode}", "--control", *options]
        self._options += ["--log", os.fspath(log)] if log else []
        self._options += ["--script", os.fspath(script)] if script else []
        self._firmware = firmware
        self._program: BoardProgram | None = None
        self._grip: Grip | None = grip_named("medium")
        self._target: float | None = None

    def open(self, handshake_time: float = PATIENCE) -> None:
        """Start the board and exchange Hello; raise DeviceError if this fails."""
        self.start()
        try:
            super().open(handshake_time)
        except BaseException:
            self.end()
            raise

    def close(self) -> None:
        """Set the force to zero, end the board and store its counters in ``summary``; this never fails."""
        super().close()
        self.end()

    @property
    def flash_port(self) -> str:
        return ""

    def unpaced(self) -> "VirtualBoard":
        """Return a board in lockstep, whose results do not depend on the machine's load."""
        return VirtualBoard("lockstep")

    # --- the program
    def start(self) -> None:
        """Start the program without opening its port; raise DeviceError if this fails."""
        if not program().is_file():
            raise DeviceError("The virtual board is not built. Run `make firmware`, then try again.")
        command = [os.fspath(program()), os.fspath(self._firmware or firmware()), *self._options]
        self._program = BoardProgram(command)
        try:
            self.port = self._program.reply("port")
        except DeviceError:
            self.end()
            raise

    def end(self) -> None:
        """End the program; its counters are in ``summary`` afterwards. This may be repeated."""
        if self._program is not None:
            self.summary = json.loads(self._program.end() or "{}")
            self._program = None

    @property
    def pid(self) -> int:
        """Process id of the running program; raise DeviceError if no program runs."""
        return self._running().pid

    def _running(self) -> BoardProgram:
        if self._program is None:
            raise DeviceError("The virtual board is not running.")
        return self._program

    def send(self, command: str) -> bool:
        """Send one command without waiting; return False if the program ended or its pipe is full."""
        return self._program is not None and self._program.send(command)

    def ask(self, command: str) -> str:
        """Send a command and return the reply; raise DeviceError without a reply."""
        self._running().send(command)
        return self._running().reply({"flush": "flushed", "plug": "port"}.get(command, command))

    # --- hand and cable
    def set_grip(self, grip: Grip | str | None) -> None:
        """Choose the grip by name or as three numbers; raise ParameterError for an unknown name."""
        self._grip = grip_named(grip) if isinstance(grip, str) else grip
        self._move()

    def move_hand(self, target: float | None) -> None:
        """Move the hand to a position in m, as fast as the window's simulated hand; None lets go."""
        self._target = target
        self._move()

    def _move(self) -> None:
        if self._grip is None or self._target is None:
            self.send("release")
            return
        g = self._grip
        numbers = (self._target, g.stiffness, g.damping, g.mass, HAND_PERIOD, ARRIVES, LEADS)
        self.send("hand " + " ".join(str(float(number)) for number in numbers))

    def hook_spring(self, stiffness: float | None) -> None:
        """Remove the hand and attach a spring to the handle; ``stiffness`` in N/m, None for no spring."""
        if stiffness is None:
            self._move()
        else:
            self.send(f"hand 0 {stiffness} 0 0 {HOOK_PERIOD}")

    def unplug(self) -> None:
        """Unplug the cable: the computer loses the port, and the firmware keeps running."""
        self.send("unplug")

    def plug(self) -> None:
        """Plug the cable in again, on a new port."""
        self.port = self.ask("plug")

    def status(self) -> dict[str, Any]:
        """Return the current time, position, velocity, forces and duty."""
        return json.loads(self.ask("status"))

    def flush(self) -> int:
        """Flush the truth log; return its number of rows."""
        return int(self.ask("flush"))


@cache
def _home() -> tempfile.TemporaryDirectory:
    return tempfile.TemporaryDirectory(prefix="hapkit-board-")


def listed() -> VirtualBoard:
    """Return the board of the device list, with a persistent EEPROM and a kit's end stops."""
    return VirtualBoard(options=["--eeprom", os.path.join(_home().name, "eeprom"), "--stop", "0.05"])


DEVICE = DeviceKind(1, lambda: [DeviceEntry("virtual-board", "Virtual board", listed)] if built() else [])
