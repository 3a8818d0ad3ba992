"""Ordered loads and stores for what two threads share: without them LLVM hoists a flag out of a loop.

Words are elements of one-dimensional int64 arrays. Interpreted, Python's own lock orders everything.
"""

import numpy as np
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic

from hapkit_studio.dynamics.jit import compiled


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
def _fence(typingctx):
    def codegen(context, builder, signature, args):
        builder.fence("seq_cst")
        return context.get_dummy_value()

    return types.void(), codegen


def _plain_load(words, index):
    return words[index]


def _plain_store(words, index, value):
    words[index] = value


def _plain_fence():
    pass


if config.DISABLE_JIT:
    load_acquire, store_release, fence = _plain_load, _plain_store, _plain_fence
else:

    @compiled
    def load_acquire(words: np.ndarray, index: int) -> int:
        """Return words[index]; nothing that follows is read before it."""
        return _load(words, index)

    @compiled
    def store_release(words: np.ndarray, index: int, value: int) -> None:
        """Set words[index]; everything written before is seen first."""
        _store(words, index, value)

    @compiled
    def fence() -> None:
        """Order everything before against everything after."""
        _fence()
