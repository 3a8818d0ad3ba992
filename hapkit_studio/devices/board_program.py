"""The virtual board's program as a child process: commands in, lines out, both with a time-out."""

import contextlib
import os
import select
import subprocess
import tempfile
import time
from collections.abc import Sequence

from hapkit_studio.errors import DeviceError

START_TIME = 10.0
"""s to wait for an answer; a loaded machine may take a while to start a program."""
END_TIME = 5.0
"""s that it has to write its log and counters out; its EEPROM is written as soon as it changes."""


class BoardProgram:
    """Runs from construction to ``end``; raises DeviceError with the program's own words if it fails."""

    def __init__(self, words: Sequence[str]):
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        self._rest = b""
        self._summary = ""
        self._lines: list[str] = []
        try:
            self._child = subprocess.Popen(
                words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, bufsize=0
            )
        except OSError as error:
            self._errors.close()
            raise DeviceError(f"The virtual board does not start: {error.strerror}.") from error
        self._in, self._out = (pipe.fileno() for pipe in (self._child.stdin, self._child.stdout) if pipe)
        os.set_blocking(self._in, False)

    @property
    def pid(self) -> int:
        return self._child.pid

    def send(self, command: str) -> bool:
        """Send one command without waiting; False if the program is gone or does not keep up."""
        try:
            return os.write(self._in, command.encode() + b"\n") > 0
        except OSError:
            return False

    def reply(self, word: str, seconds: float = START_TIME) -> str:
        """Return what follows the word in the next line that begins with it; raise DeviceError."""
        deadline = time.monotonic() + seconds
        while True:
            for at, line in enumerate(self._lines):
                if line.startswith(word):
                    del self._lines[: at + 1]
                    return line[len(word) :].strip()
            if not self._read(deadline - time.monotonic()):
                raise DeviceError(f"The virtual board does not answer. {self.last_words()}".strip())

    def _read(self, seconds: float) -> bool:
        ready, _, _ = select.select([self._out], [], [], max(seconds, 0.0))
        data = os.read(self._out, 4096) if ready else b""
        *whole, self._rest = (self._rest + data).split(b"\n")
        self._lines += [line.decode("utf-8", "replace") for line in whole]
        return bool(data)

    def last_words(self) -> str:
        """Return the last line that the program wrote to its standard error."""
        self._errors.seek(0)
        lines = self._errors.read().decode("utf-8", "replace").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "")

    def end(self) -> str:
        """End the program and reap it; return its summary, a JSON object, or nothing. May be called twice."""
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
