"""C functions by symbol, and ordered loads and stores, for code compiled with numba.

A compiled function that refers to a ctypes pointer contains an address, so numba does not cache the function.
It caches a function that refers to a symbol, because the symbol is resolved each time the machine code is
loaded. Addresses are integers, e.g. ``array.ctypes.data``.

Two threads share words by ordered loads and stores. Without these, LLVM would hoist the load of a flag out of
a loop. Words are elements of one-dimensional int64 arrays. In interpreted mode Python's lock orders all
accesses.
"""

import ctypes
import sys
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic

from hapkit_studio.dynamics.jit import compiled

_TO_CTYPES = {
    types.int32: ctypes.c_int32,
    types.uint32: ctypes.c_uint32,
    types.int64: ctypes.c_int64,
    types.uint64: ctypes.c_uint64,
    types.void: None,
}
_ADDRESS = types.uint64
_int, _uint, _long, _ulong = types.int32, types.uint32, types.int64, types.uint64


def declare(symbol, result, *arguments):
    """Return the C function for compiled code, or for Python if compilation is disabled."""
    if not config.DISABLE_JIT:
        return types.ExternalFunction(symbol, result(*arguments))
    function = getattr(ctypes.CDLL(None, use_errno=True), symbol, None)
    if function is not None:
        function.restype = _TO_CTYPES[result]
        function.argtypes = [_TO_CTYPES[kind] for kind in arguments]
    return function


poll = declare("poll", _int, _ADDRESS, _ulong, _int)
read = declare("read", _long, _int, _ADDRESS, _ulong)
write = declare("write", _long, _int, _ADDRESS, _ulong)
# on Windows the upper half of recv's result is undefined
recv = declare("recv", _long, _int, _ADDRESS, _ulong, _int)
clock_gettime = declare("clock_gettime", _int, _int, _ADDRESS)
clock_nanosleep = declare("clock_nanosleep", _int, _int, _int, _ADDRESS, _ADDRESS)
sched_setscheduler = declare("sched_setscheduler", _int, _int, _int, _ADDRESS)

mach_absolute_time = declare("mach_absolute_time", _ulong)
mach_timebase_info = declare("mach_timebase_info", _int, _ADDRESS)
mach_wait_until = declare("mach_wait_until", _int, _ulong)
pthread_self = declare("pthread_self", _ADDRESS)
pthread_mach_thread_np = declare("pthread_mach_thread_np", _uint, _ADDRESS)
thread_policy_set = declare("thread_policy_set", _int, _uint, _int, _ADDRESS, _uint)

# functions of kernel32
QueryPerformanceCounter = declare("QueryPerformanceCounter", _int, _ADDRESS)
QueryPerformanceFrequency = declare("QueryPerformanceFrequency", _int, _ADDRESS)
CreateWaitableTimerExW = declare("CreateWaitableTimerExW", _ADDRESS, _ADDRESS, _ADDRESS, _uint, _uint)
SetWaitableTimer = declare("SetWaitableTimer", _int, _ADDRESS, _ADDRESS, _int, _ADDRESS, _ADDRESS, _int)
WaitForSingleObject = declare("WaitForSingleObject", _uint, _ADDRESS, _uint)
CloseHandle = declare("CloseHandle", _int, _ADDRESS)
GetCurrentThread = declare("GetCurrentThread", _ADDRESS)
GetThreadTimes = declare("GetThreadTimes", _int, _ADDRESS, _ADDRESS, _ADDRESS, _ADDRESS, _ADDRESS)
SetThreadPriority = declare("SetThreadPriority", _int, _ADDRESS, _int)


def add_symbols(library, names) -> None:
    """Register a library's functions by name for compiled code."""
    for name in names:
        llvm.add_symbol(name, ctypes.cast(getattr(library, name), ctypes.c_void_p).value)


if sys.platform == "win32":
    _names = "QueryPerformanceCounter QueryPerformanceFrequency CreateWaitableTimerExW SetWaitableTimer "
    _names += "WaitForSingleObject CloseHandle GetCurrentThread GetThreadTimes SetThreadPriority"
    add_symbols(ctypes.windll.kernel32, _names.split())  # type: ignore[attr-defined]
    add_symbols(ctypes.windll.ws2_32, ["recv"])  # type: ignore[attr-defined]

_I64 = ir.IntType(64)


@intrinsic
def word_pair(typingctx):
    """Return the address of two zeroed int64 words on the caller's stack, valid until the caller returns."""

    def codegen(context, builder, signature, args):
        pair = cgutils.alloca_once(builder, _I64, size=2)
        for i in (0, 1):
            builder.store(_I64(0), builder.gep(pair, [ir.IntType(32)(i)]))
        return builder.ptrtoint(pair, _I64)

    return types.uint64(), codegen


@intrinsic
def get_word(typingctx, address, index):
    """Return the int64 at address + 8 index."""

    def codegen(context, builder, signature, args):
        pointer = builder.inttoptr(args[0], _I64.as_pointer())
        return builder.load(builder.gep(pointer, [args[1]]))

    return types.int64(types.uint64, types.int64), codegen


@intrinsic
def set_word(typingctx, address, index, value):
    """Store an int64 at address + 8 index."""

    def codegen(context, builder, signature, args):
        pointer = builder.inttoptr(args[0], _I64.as_pointer())
        builder.store(args[2], builder.gep(pointer, [args[1]]))
        return context.get_dummy_value()

    return types.void(types.uint64, types.int64, types.int64), codegen


@intrinsic
def last_error(typingctx):
    """Return the errno of the preceding C function."""
    symbol = (
        "__error" if sys.platform == "darwin" else "_errno" if sys.platform == "win32" else "__errno_location"
    )

    def codegen(context, builder, signature, args):
        i32 = ir.IntType(32)
        kind = ir.FunctionType(i32.as_pointer(), [])
        function = cgutils.get_or_insert_function(builder.module, kind, symbol)
        return builder.load(builder.call(function, []))

    return types.int32(), codegen


def _word(context, builder, kind, array, index):
    data = cgutils.create_struct_proxy(kind)(context, builder, array).data
    return builder.gep(data, [index])


@intrinsic
def _load(typingctx, words, index):
    def codegen(context, builder, signature, args):
        pointer = _word(context, builder, signature.args[0], *args)
        return builder.load_atomic(pointer, "acquire", 8)

    return types.int64(words, types.int64), codegen


@intrinsic
def _store(typingctx, words, index, value):
    def codegen(context, builder, signature, args):
        pointer = _word(context, builder, signature.args[0], *args[:2])
        builder.store_atomic(args[2], pointer, "release", 8)
        return context.get_dummy_value()

    return types.void(words, types.int64, types.int64), codegen


@intrinsic
def _assign(typingctx, to, source):
    def codegen(context, builder, signature, args):
        cgutils.raw_memcpy(builder, *args, _I64(signature.args[0].size), 1)
        return context.get_dummy_value()

    return types.void(to, source), codegen


@intrinsic
def _fence(typingctx):
    def codegen(context, builder, signature, args):
        builder.fence("seq_cst")
        return context.get_dummy_value()

    return types.void(), codegen


if config.DISABLE_JIT:

    def load_acquire(words, index):
        return words[index]

    def store_release(words, index, value):
        words[index] = value

    def fence():
        pass

    def assign(to, source):
        for name in source.dtype.names:
            to[name] = source[name]

else:

    @compiled
    def load_acquire(words: np.ndarray, index: int) -> int:
        """Return words[index]; no later read is moved before this read."""
        return _load(words, index)

    @compiled
    def store_release(words: np.ndarray, index: int, value: int) -> None:
        """Set words[index]; all earlier writes become visible before this write."""
        _store(words, index, value)

    @compiled
    def fence() -> None:
        """Issue a full memory barrier."""
        _fence()

    @compiled
    def assign(to: Any, source: Any) -> None:
        """Copy the fields of a record to another record."""
        _assign(to, source)
