"""Every field of the records of a loop's state is accessible by name, in Python and in compiled code."""

import numpy as np
import pytest

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import arrays, block, link


@pytest.mark.parametrize(
    "dtype", [arrays.TICK, arrays.WATCH, arrays.LIMIT, arrays.CONTROL, block.SETTINGS, link.STATE]
)
def test_no_field_has_the_name_of_an_attribute_of_numpy_s_records(dtype):
    """A field with the name ``flags`` or ``real`` would be hidden by numpy's attribute of that name."""
    assert not set(dtype.fields) & set(dir(np.record))


def test_words_shared_between_threads_are_on_separate_cache_lines():
    offsets = sorted(offset for _, offset, *_ in arrays.CONTROL.fields.values())
    assert np.all(np.diff(offsets) >= 64)


@compiled
def write(tick, watch):
    tick.gain, tick.slot, tick.stale_times[2] = 0.5, 7, 1.5
    watch.strict.excess, watch.work[-1] = 2.5, 3.5


def test_compiled_code_writes_to_the_memory_that_python_reads():
    memory, observed = np.zeros(1, arrays.TICK), np.zeros(1, arrays.WATCH)
    write(memory[0], observed[0])
    assert (memory[0].gain, memory[0].slot, list(memory[0].stale_times)) == (0.5, 7, [0.0, 0.0, 1.5])
    assert (observed[0].strict.excess, observed[0].alarm.excess, observed[0].work[-1]) == (2.5, 0.0, 3.5)
