"""Laws that misbehave on demand, a tick driven sample by sample, and helpers that wait for a running loop."""

import ctypes
import math
import threading
from dataclasses import fields

import numpy as np

from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics import arrays, block, clib, headless, tick
from hapkit_studio.haptics.block_content import BlockContent
from hapkit_studio.haptics.clib import store_release
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter
from tests.waiting import wait_until

FADE = 0.030


@law
def constant(p, s, x, v, dt):
    if p.place == "a":
        return p.level
    if p.place == "b":
        return 2.0 + p.level
    if p.place == "c":
        return 100.0
    return -1.0


@law(state={"count": 0.0, "twice": 5.0})
def counting(p, s, x, v, dt):
    s.count += 1.0
    s.twice += 2.0
    if p.sign == "minus":
        return -p.gain * s.count
    return p.gain * s.count


@law(state={"calls": 0.0, "cells": (0.0, 0.0)})
def broken(p, s, x, v, dt):
    s.calls += 1.0
    if x < 0.005:
        return 1.0
    if p.how == "nan":
        return 1e308 * 1e10 * 0.0
    if p.how == "inf":
        return 1e308 * 1e10
    if p.how == "minus inf":
        return -1e308 * 1e10
    if p.how == "index":
        s.cells[int(x * 1000.0)] = 1.0
        return 1.0
    total = 0.0
    for i in range(1000):
        for j in range(1000):
            total += i - j
    return total


@law
def slow(p, s, x, v, dt):
    total = 0.0
    for i in range(18000):
        total += math.sin(total + x + i)
    return 1e-9 * total


CONSTANT = Environment(
    "constant",
    "Constant",
    "",
    (Parameter("level", "Level", "N", 1.0, -5.0, 5.0), Choice("place", "Place", ("a", "b", "c", "d"))),
    constant,
)
COUNTING = Environment(
    "counting",
    "Counting",
    "",
    (Parameter("gain", "Gain", "N", 1e-3, -5.0, 5.0), Choice("sign", "Sign", ("plus", "minus"))),
    counting,
)
BROKEN = Environment(
    "broken", "Broken", "", (Choice("how", "How", ("nan", "inf", "minus inf", "index", "fuel")),), broken
)


def slow_environment():
    """Return an environment whose law takes longer than a period of 0.1 ms."""
    return Environment("slow", "Slow", "", (), slow)


class LoopHarness:
    """A harness that runs ticks without a clock; it receives settings and positions and returns rows."""

    def __init__(self, environment, values=None, rate=1000.0, full=True, **wanted):
        self.block = block.new_block()
        self.r = arrays.new_arrays(self.block)
        self.wanted = dict(wanted)
        self.rate = rate
        self.set(environment, values)
        self.r.tick.gain = 1.0 if full else 0.0

    def set(self, environment, values=None, **wanted):
        """Publish an environment, its values, and settings of the loop."""
        self.wanted.update(wanted)
        names = {field.name for field in fields(LoopSettings)}
        loop = {"viscous": 0.0, "coulomb": 0.0} | {k: v for k, v in self.wanted.items() if k in names}
        others = {k: v for k, v in self.wanted.items() if k not in names}
        settings = LoopSettings(self.rate, **loop)
        content = BlockContent(environment, environment.values(values), settings, **others)
        self.kept = content.environment.force.compiled()
        block.publish(self.block, content.encode())

    def tick(self, position=0.0, effect=0.0, period=None):
        """Render one sample; return its row."""
        row = headless.new_rows(1)[0]
        tick.tick(self.r, position, period or 1.0 / self.rate, effect, row)
        return row

    def run(self, positions, effects=None):
        """Render samples; return their rows."""
        effects = np.zeros(len(positions)) if effects is None else effects
        return np.array([self.tick(float(x), float(f)) for x, f in zip(positions, effects, strict=True)])

    def ticks(self, seconds):
        """Render some seconds with the handle at rest; return the rows."""
        return self.run(np.zeros(round(seconds * self.rate)))

    def clear_fault(self):
        store_release(self.r.control.clear, 0, int(self.r.control.clear[0]) + 1)

    def stop(self, on=True):
        store_release(self.r.control.stop, 0, int(on))


def read(reader, enough):
    """Return all rows as soon as enough(rows) is true; fail at once if the loop ends before."""
    parts = []

    def came():
        ended = reader._ring.control.done[0]
        parts.append(reader.read())
        found = np.concatenate(parts)
        came = len(found) and enough(found)
        assert came or not ended, "the loop has ended"
        return came

    wait_until(came)
    return np.concatenate(parts)


def rest(reader, count):
    """Return the next rows, at least ``count`` of them."""
    reader.read()
    return read(reader, lambda found: len(found) >= count)


def loop_threads():
    return [t for t in threading.enumerate() if t.name == "hapkit-loop"]


class FakeLibrary:
    """C functions written in Python that compiled code can call by name; they record their arguments."""

    def __init__(self):
        self.calls = []
        self.keep = []

    def add(self, name, result, *arguments):
        def wrap(function):
            kind = ctypes.CFUNCTYPE(result, *arguments)
            callback = kind(lambda *given: (self.calls.append((name, *given)), function(*given))[1])
            self.keep.append(callback)
            setattr(self, name, callback)
            clib.add_symbols(self, [name])
            return function

        return wrap
