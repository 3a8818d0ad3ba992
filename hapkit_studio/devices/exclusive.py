"""Keep other programs off an open port: a serial monitor would take half of the frames and restart the board.

pyserial's own lock is only heeded by those who ask for it.
"""

import contextlib
import sys
from typing import Any


def claim(line: Any) -> None:
    """Let the system refuse whoever else opens the port, but root; where it cannot, nothing changes."""
    _set(line, "TIOCEXCL")


def give_back(line: Any) -> None:
    """Let others open the port again; a pseudo-terminal would remember it after the end."""
    _set(line, "TIOCNXCL")


def _set(line: Any, request: str) -> None:
    if sys.platform == "win32":  # there a port has one owner anyway
        return
    import fcntl
    import termios

    with contextlib.suppress(OSError, AttributeError, ValueError, TypeError):
        fcntl.ioctl(line.fileno(), getattr(termios, request))
