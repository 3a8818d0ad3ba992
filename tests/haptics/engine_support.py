"""Waiting for what a running loop does, never for a time."""

import threading

import numpy as np

from tests.waiting import wait_until


def read(reader, enough):
    """Return rows once enough(rows) holds."""
    parts = []

    def came():
        parts.append(reader.read())
        found = np.concatenate(parts)
        return len(found) and enough(found)

    wait_until(came)
    return np.concatenate(parts)


def rest(reader, count):
    """Return the next rows, at least count of them."""
    reader.read()
    return read(reader, lambda found: len(found) >= count)


def loop_threads():
    return [t for t in threading.enumerate() if t.name == "hapkit-loop"]
