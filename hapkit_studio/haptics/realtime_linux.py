"""Real-time priority on Linux for the calling thread: SCHED_FIFO, RealtimeKit, nice.

The module also sets timer slack, locks memory and keeps processors out of sleep states. These functions need
no real-time priority.

A signal handler demotes a thread that does not block: the kernel sends SIGXCPU once a real-time thread has
run for RLIMIT_RTTIME without blocking (setrlimit(2)). The handler is compiled, because a Python handler would
have to wait for the main thread and the GIL.
"""

import ctypes
import functools
import os
import resource
import shutil
import signal
import struct
import subprocess
import threading
from pathlib import Path

import llvmlite.binding as llvm
from llvmlite import ir
from numba import cfunc, config, types
from numba.core import cgutils
from numba.extending import intrinsic

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import clib

SOFT_LIMIT_US = 100_000
_SLOTS = 16
_SYMBOL = "hapkit_studio_realtime_threads"
_OTHER_RESET_ON_FORK = 0x40000000

# Word 0 counts demotions; the other words are thread ids or 0. The handler refers to the table by a symbol,
# so numba can cache the handler.
_table = (ctypes.c_int64 * (1 + _SLOTS))()
llvm.add_symbol(_SYMBOL, ctypes.addressof(_table))


@intrinsic
def _table_address(typingctx):
    def codegen(context, builder, signature, args):
        i64 = ir.IntType(64)
        variable = cgutils.add_global_variable(builder.module, i64, _SYMBOL)
        variable.linkage = "external"
        return builder.ptrtoint(variable, i64)

    return types.uint64(), codegen


@functools.cache
def _handler():
    """Compile or load the handler; it makes only system calls, so it is async-signal-safe."""

    @cfunc(types.void(types.int32), cache=True)
    def on_overrun(number):
        table, zero = _table_address(), clib.word_pair()
        for slot in range(1, 1 + _SLOTS):
            thread = clib.get_word(table, slot)
            if thread != 0:
                clib.sched_setscheduler(thread, _OTHER_RESET_ON_FORK, zero)
                clib.set_word(table, 0, clib.get_word(table, 0) + 1)

    return on_overrun


def watch_overrun(thread: int, hard_limit_us: int | None = None) -> None:
    """Demote a thread after 100 ms without blocking; optionally lower the hard limit permanently."""
    if thread not in _table[1:]:
        _table[1 + list(_table[1:]).index(0)] = thread
    if config.DISABLE_JIT:
        return
    libc = ctypes.CDLL(None)
    libc.signal.argtypes = [ctypes.c_int, ctypes.c_void_p]
    libc.signal(signal.SIGXCPU, _handler().address)
    hard = resource.getrlimit(resource.RLIMIT_RTTIME)[1]
    if hard_limit_us is not None and (hard == resource.RLIM_INFINITY or hard > hard_limit_us):
        hard = hard_limit_us
    resource.setrlimit(resource.RLIMIT_RTTIME, (SOFT_LIMIT_US, hard))


def forget_overrun(thread: int) -> None:
    """Stop monitoring a thread."""
    for slot in range(1, 1 + _SLOTS):
        if _table[slot] == thread:
            _table[slot] = 0


FIFO_LEVEL = 80
HOW_TO_GET_MORE = (
    f"Add the line '{os.environ.get('USER', 'your-user')} - rtprio {FIFO_LEVEL}' to "
    "/etc/security/limits.conf and log in again, or install the package rtkit. The command 'make realtime' "
    "shows more."
)
_NICE = -11
_PR_SET_TIMERSLACK = 29
_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_CAP_IPC_LOCK = 14
_WAKE_LATENCY = Path("/dev/cpu_dma_latency")
_thread_data = threading.local()
_KIT = ("org.freedesktop.RealtimeKit1", "/org/freedesktop/RealtimeKit1", "org.freedesktop.RealtimeKit1")


def obtain() -> tuple[str, int]:
    """Raise the calling thread's priority as far as allowed; return a description and the level (0: refused).

    Compile everything first, because the thread loses its priority after 100 ms without blocking.
    """
    thread = threading.get_native_id()
    if not config.DISABLE_JIT:
        # compile the handler first: an inherited limit leaves a real-time thread no time to compile it
        _handler()
    set_timer_slack(1)
    lock_memory()
    keep_processors_awake()
    for attempt in (_take_fifo, _ask_realtime_kit, _take_nice):
        obtained = attempt(thread)
        if obtained:
            return obtained
    return "Normal priority", 0


def release() -> None:
    """Restore the calling thread's normal priority and default timer slack."""
    thread = threading.get_native_id()
    os.sched_setscheduler(0, os.SCHED_OTHER | os.SCHED_RESET_ON_FORK, os.sched_param(0))
    if os.getpriority(os.PRIO_PROCESS, thread) < 0:
        os.setpriority(os.PRIO_PROCESS, thread, 0)
    forget_overrun(thread)
    set_timer_slack(0)
    let_processors_sleep()


@compiled
def demote() -> None:
    """Restore the calling thread's normal priority at once, from compiled code."""
    clib.sched_setscheduler(0, _OTHER_RESET_ON_FORK, clib.word_pair())


def set_timer_slack(nanoseconds: int) -> None:
    """Set by how much the kernel may delay the end of the calling thread's sleeps; 0 restores the default."""
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(nanoseconds), 0, 0, 0)


def lock_memory() -> None:
    """Lock the process's pages in memory, unless a limit could make a later allocation fail."""
    status = Path("/proc/thread-self/status").read_text().splitlines()
    capabilities = next((int(line.split()[1], 16) for line in status if line.startswith("CapEff:")), 0)
    unlimited = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY
    if unlimited or capabilities >> _CAP_IPC_LOCK & 1:
        ctypes.CDLL(None).mlockall(_MCL_CURRENT | _MCL_FUTURE | _MCL_ONFAULT)


def keep_processors_awake() -> bool:
    """Request a wake-up latency of 0 µs until released, if permitted (the kernel's PM QoS interface).

    A host resumes a halted virtual processor late: the 99.9th percentile of the lateness is 3 ms without the
    request, and 0.18 ms with it.
    """
    let_processors_sleep()
    try:
        _thread_data.file = _WAKE_LATENCY.open("wb", buffering=0)
        _thread_data.file.write(struct.pack("i", 0))
    except OSError:
        return False
    return True


def let_processors_sleep() -> None:
    """Withdraw the request of ``keep_processors_awake`` in this thread."""
    file = getattr(_thread_data, "file", None)
    if file is not None:
        file.close()
        _thread_data.file = None


def is_realtime(thread: int) -> bool:
    """Return True if a thread of this process has real-time scheduling."""
    policy = os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK
    return policy in (os.SCHED_FIFO, os.SCHED_RR)


def _take_fifo(thread: int) -> tuple[str, int] | None:
    allowed = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    for level in (level for level in (FIFO_LEVEL, min(allowed, FIFO_LEVEL)) if level > 0):
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(level))
        except OSError:
            continue
        watch_overrun(thread)
        return f"Real-time priority (level {level} of 99)", level
    return None


def _ask_realtime_kit(thread: int) -> tuple[str, int] | None:
    """Ask RealtimeKit, which requires a hard RLIMIT_RTTIME and grants a limited priority."""
    if shutil.which("busctl") is None:
        return None
    bounds = _busctl("get-property", *_KIT, "MaxRealtimePriority", "RTTimeUSecMax")
    try:
        level, limit_us = (int(line.split()[1]) for line in bounds.splitlines())
    except ValueError:
        return None
    watch_overrun(thread, limit_us)
    level = min(level, 20)
    _busctl("call", *_KIT, "MakeThreadRealtimeWithPID", "ttu", str(os.getpid()), str(thread), str(level))
    if is_realtime(thread):
        return f"Real-time priority (level {level} of 99)", level
    forget_overrun(thread)
    return None


def _busctl(verb: str, *arguments: str) -> str:
    """Return the output of busctl, "" if the bus, the service or the permission is missing."""
    command = ["busctl", "--system", "--timeout=2", "--auto-start=yes", verb, *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=5, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout if done.returncode == 0 else ""


def _take_nice(thread: int) -> tuple[str, int] | None:
    try:
        os.setpriority(os.PRIO_PROCESS, thread, _NICE)
    except OSError:
        return None
    return f"Raised priority (nice {_NICE})", 0
