"""Demote a real-time thread that holds the processor, from a signal handler that needs no Python.

The kernel sends SIGXCPU once a real-time thread has run for RLIMIT_RTTIME without blocking (setrlimit(2)).
A Python handler would have to wait for the main thread and the GIL; this one is compiled.
"""

import ctypes
import functools
import resource
import signal

import llvmlite.binding as llvm
from llvmlite import ir
from numba import cfunc, config, types
from numba.core import cgutils
from numba.extending import intrinsic

from hapkit_studio.haptics import clib

SOFT_LIMIT_US = 100_000
_SLOTS = 16
_SYMBOL = "hapkit_studio_realtime_threads"
_OTHER_RESET_ON_FORK = 0x40000000

# word 0 counts the demotions, the others hold thread ids or 0; a symbol keeps the handler cacheable
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
    """Compile or load the handler; only system calls in it, so it is safe at any instant."""

    @cfunc(types.void(types.int32), cache=True)
    def on_overrun(number):
        table, zero = _table_address(), clib.word_pair()
        for slot in range(1, 1 + _SLOTS):
            thread = clib.get_word(table, slot)
            if thread != 0:
                clib.sched_setscheduler(thread, _OTHER_RESET_ON_FORK, zero)
                clib.set_word(table, 0, clib.get_word(table, 0) + 1)

    return on_overrun


def prepare() -> None:
    """Compile or load the handler; under an inherited limit a real-time thread has no time for it."""
    if not config.DISABLE_JIT:
        _handler()


def watch(thread: int, hard_limit_us: int | None = None) -> None:
    """Have a thread demoted after 100 ms without blocking; optionally lower the hard limit for good."""
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


def forget(thread: int) -> None:
    """Stop watching a thread."""
    for slot in range(1, 1 + _SLOTS):
        if _table[slot] == thread:
            _table[slot] = 0


def demotions() -> int:
    """Return how often a thread was demoted since the program started."""
    return _table[0]
