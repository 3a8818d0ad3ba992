"""The loop's priority: ask for the most the system grants, say in words what was obtained.

``obtain`` and ``release`` are called in the thread they concern, ``demote`` from compiled code.
"""

import sys
import threading
from dataclasses import dataclass

if sys.platform == "darwin" or sys.platform == "win32":
    pass
else:
    from hapkit_studio.haptics import realtime_linux

demote = realtime_linux.demote


@dataclass(frozen=True)
class Priority:
    """What was obtained, e.g. "Real-time, FIFO 80", and in one sentence how to get more (may be empty)."""

    text: str
    realtime: bool
    how: str
    level: int = 0


def obtain() -> Priority:
    """Raise the calling thread's priority; call it once everything is compiled, right before the loop."""
    text, level = realtime_linux.obtain()
    return Priority(text, level > 0, realtime_linux.how_to_get_more(level), level)


def held(obtained: Priority, thread: int) -> Priority:
    """Return what is left of an obtained priority: a thread that did not let go was demoted meanwhile."""
    if not obtained.realtime or realtime_linux.is_realtime(thread):
        return obtained
    return Priority("Normal priority, demoted", False, "Lower the rate, then connect again.")


def release() -> None:
    """Give the calling thread normal priority back."""
    realtime_linux.release()


def probe() -> Priority:
    """Return what a loop started now would obtain, from a thread of its own."""
    found = []

    def ask() -> None:
        found.append(obtain())
        release()

    thread = threading.Thread(target=ask, name="hapkit-priority")
    thread.start()
    thread.join()
    return found[0]


def report() -> str:
    """Return what this user's loop obtains, and what to do for more."""
    now = probe()
    lines = [f"The loop of this user obtains: {now.text}."]
    if now.how:
        lines.append(now.how)
    if sys.platform == "linux" and now.how:
        lines += [
            "",
            "Either (takes effect at the next login):",
            '    echo "$USER - rtprio 80" | sudo tee /etc/security/limits.d/hapkit-studio.conf',
            '    echo "$USER - memlock unlimited" | sudo tee -a /etc/security/limits.d/hapkit-studio.conf',
            "or (at once, up to priority 20, needs a desktop session):",
            "    sudo apt-get install rtkit",
        ]
    return "\n".join(lines)
