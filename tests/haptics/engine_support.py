"""Waiting for what a running loop does, never for a time."""

import threading
import time

import numpy as np


def read(reader, enough, seconds=5.0):
    """Return rows once enough(rows) holds; fail after so many seconds."""
    found = reader.read()
    limit = time.monotonic() + seconds
    while not (len(found) and enough(found)):
        assert time.monotonic() < limit, f"not so within {seconds:g} s"
        time.sleep(0.002)
        found = np.concatenate((found, reader.read()))
    return found


def rest(reader, count):
    """Return the next rows, at least count of them."""
    reader.read()
    return read(reader, lambda found: len(found) >= count)


def wait_for(condition, seconds=5.0):
    limit = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < limit, f"not so within {seconds:g} s"
        time.sleep(0.002)


def loop_threads():
    return [t for t in threading.enumerate() if t.name == "hapkit-loop"]
