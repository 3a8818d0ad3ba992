"""Run the compiled loop and the real firmware in board time, so that a script and a seed determine a run.

The loop's system calls (poll, read, write, clock_gettime) are redirected to this module by their symbols
before compilation, so this module needs its own process. The loop and the board take turns, so results do not
depend on the speed of either of them.
"""

import ctypes
import json
import os
import select
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np

from hapkit_studio.devices import virtual_board
from hapkit_studio.devices.virtual_board import BoardProgram
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Message
from tests.waiting import PATIENCE, write_all

_POLLIN, _POLLHUP = 1, 16
_EDGE = 1e-9


class Turns:
    """One board, and the operating system that the loop sees. Times are in s of the board's clock.

    - ``until`` is the time at which ``quit`` is called.
    - ``killed`` is the time at which the computer dies and its port is closed.
    - ``spam`` is called with the time before each reply, and returns bytes that another program writes to the
    port.
    """

    def __init__(self, folder: Path, script, options=(), firmware=None, log_period=1e-4):
        log, commands = folder / "truth.f64", folder / "script.txt"
        commands.write_text("\n".join(script))
        command = [virtual_board.program(), firmware or virtual_board.firmware(), "--turns", "--await", "0"]
        command += ["--log", log, "--script", commands, "--log-period", log_period, *options]
        self.board = BoardProgram([str(w) for w in command])
        self.log = log
        self.time = 0.0
        self.until = self.killed = np.inf
        self.quit = lambda: None
        self.spam = lambda time: b""
        self.sent: list[tuple[float, bytes]] = []
        self._handed = self._taken = self._written = 0
        self.fd, self.port = -1, self.board.reply("port")
        self.plug_in()
        self._hear()

    def plug_in(self) -> None:
        """Open the port that the board announced last."""
        self.fd = os.open(self.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self._handed = self._taken = self._written = 0

    def unplug(self) -> None:
        """Close the port without a message."""
        if self.fd >= 0:
            os.close(self.fd)
        self.fd = -1
        self._written = 0

    def _hear(self) -> None:
        word, first, *rest = self.board.reply("").split()
        while word != "turn":
            if word == "port":
                self.port = first
            word, first, *rest = self.board.reply("").split()
        self.time, self._handed = float(first), int(rest[0])

    def turn(self) -> None:
        """Run the board until a frame has arrived or 20 ms have passed."""
        spam = self.spam(self.time) if self.fd >= 0 else b""
        if spam:
            self._write(spam)
        self.board.send(f"go {self._written}")
        self._hear()
        if self.time >= self.killed:
            self.unplug()
        if self.time >= self.until:
            self.quit()

    def ask(self, message: Message, kind: type[Message]) -> Message:
        """Send a message before the loop runs; return the board's reply."""
        decoder, found = Decoder(), []
        self.send(encode(message))
        while not found:
            self.turn()
            found = [m for m in decoder.feed(self.take(4096)) if isinstance(m, kind)]
        return found[0]

    def alone(self, until: float) -> None:
        """Run the board without a computer until a time."""
        while self.time < until:
            self.turn()

    def end(self) -> dict:
        self.unplug()
        return json.loads(self.board.end())

    def fail(self) -> None:
        """Disconnect and end the loop, because exceptions in callbacks do not reach the caller."""
        self.unplug()
        self.quit()

    # --- the loop calls these functions
    def poll(self, spec: int, _count: int, timeout_ms: int) -> int:
        word = ctypes.c_int64.from_address(spec)
        before = self.time
        while True:
            if self.fd < 0 or self._hung_up():
                word.value |= _POLLHUP << 48
                return 1
            if self._handed > self._taken:
                word.value |= _POLLIN << 48
                return 1
            if self.time - before >= 1e-3 * timeout_ms - _EDGE:
                return 0
            self.turn()

    def _hung_up(self) -> bool:
        watch = select.poll()
        watch.register(self.fd, 0)
        return any(event & _POLLHUP for _, event in watch.poll(0))

    def read(self, _fd: int, address: int, size: int) -> int:
        data = self.take(size)
        ctypes.memmove(address, data, len(data))
        return len(data)

    def take(self, size: int) -> bytes:
        want, data = min(size, self._handed - self._taken), b""
        while len(data) < want:
            select.select([self.fd], [], [], PATIENCE)
            data += os.read(self.fd, want - len(data))
        self._taken += len(data)
        return data

    def write(self, _fd: int, address: int, size: int) -> int:
        try:
            self.send(ctypes.string_at(address, size))
        except OSError:
            return -1
        return size

    def send(self, data: bytes) -> None:
        """Send bytes to the board in its next turn."""
        self._write(data)
        self.sent.append((self.time, data))

    def _write(self, data: bytes) -> None:
        write_all(self.fd, data)
        self._written += len(data)

    def clock(self, _which: int, address: int) -> int:
        words = (ctypes.c_int64 * 2).from_address(address)
        words[0], words[1] = divmod(round(self.time * 1e9), 1_000_000_000)
        return 0


_now: Turns | None = None
_long, _ulong, _int, _address = ctypes.c_long, ctypes.c_ulong, ctypes.c_int, ctypes.c_uint64


def _led(name: str, result, *arguments):
    def call(*given):
        try:
            return getattr(_now, name)(*given)
        except BaseException:
            _now.fail()
            raise

    return ctypes.CFUNCTYPE(result, *arguments)(call)


_SYMBOLS = {
    "poll": _led("poll", _int, _address, _ulong, _int),
    "read": _led("read", _long, _int, _address, _ulong),
    "write": _led("write", _long, _int, _address, _ulong),
    "clock_gettime": _led("clock", _int, _int, _address),
}


def lead(turns: Turns) -> None:
    """Redirect the compiled loop's system calls to this board."""
    global _now
    _now = turns
    for symbol, function in _SYMBOLS.items():
        llvm.add_symbol(symbol, ctypes.cast(function, ctypes.c_void_p).value)
