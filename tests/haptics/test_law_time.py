"""A law slower than a period causes a fault within 0.1 s of processor time.

The law is called by a live loop, in a headless run, and by the passivity observer.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio import api, interrupts
from hapkit_studio.analysis.stability.verdict import VerdictInput, unstable_ranges, verdict
from hapkit_studio.dynamics.hand import Prescribed
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError
from hapkit_studio.haptics import arrays, cell_batch, headless, passivity, patience, rows, tick
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter
from tests.haptics.support import CONSTANT, LoopHarness, read
from tests.waiting import wait_until

MS = 1e-3


@law
def far_too_slow(p, s, x, v, dt):
    total = 0.0
    if x > p.beyond:
        for _ in range(19000):
            total += math.sin(total) + math.sin(total + 1.0) + math.sin(total + 2.0) + math.sin(total + 3.0)
            total += math.sin(total) + math.sin(total + 1.0) + math.sin(total + 2.0) + math.sin(total + 3.0)
            total += math.sin(total) + math.sin(total + 1.0) + math.sin(total + 2.0) + math.sin(total + 3.0)
    return -p.stiffness * x + 1e-12 * total


SLOW = Environment(
    "far_too_slow",
    "Far too slow",
    "",
    (
        Parameter("stiffness", "Stiffness", "N/m", 200.0, 0.0, 500.0),
        Parameter("beyond", "Beyond", "m", 0.002, -1.0, 1.0),
    ),
    far_too_slow,
    impedance=lambda values: (values["stiffness"], 0.0),
)
EVERYWHERE = {"beyond": -1.0}


@law(state={"turned": 0.0})
def turning(p, s, x, v, dt):
    for i in range(10_000):
        if i >= p.turns:
            break
        s.turned += 1.0
    return 1.0


TURNING = Environment(
    "turning",
    "Turning",
    "",
    (Parameter("turns", "Turns", "", 10_000.0, 0.0, 10_000.0), Choice("place", "Place", ("a", "b"))),
    turning,
)


def latched(spent, period, calls=1000, pause=0.0):
    """Return the number of calls and the time in s until a law that takes ``spent`` s causes a fault."""
    r, now = LoopHarness(CONSTANT).r, 100.0
    for call in range(1, calls + 1):
        now += max(spent, period) + pause
        if tick.note_law_time(r, now, spent, period, 1):
            assert r.control.fault[0] == arrays.SLOW_LAW
            assert (r.tick.fault_value, r.tick.fault_position) == (spent, period)
            return call, now - 100.0
    assert r.control.fault[0] == arrays.NO_FAULT
    return None


@pytest.mark.parametrize("period", [MS / 16, MS / 4, MS, 20 * MS])
@pytest.mark.parametrize("over", [1.001, 1.5, 3.0, 20.0])
def test_a_law_below_its_period_runs_and_one_above_it_is_latched_within_a_tenth_of_a_second(period, over):
    assert latched(period, period) is None
    assert latched(period * over, period)[1] <= max(0.1, period * over + 1e-9)


@pytest.mark.parametrize(
    ("spent", "pause", "calls"),
    [
        (1.2 * MS, 0.0, 5),  # the five calls take 6 ms in total
        (4.9 * MS, 0.0, 2),
        (49.0 * MS, 0.0, 2),
        (50.0 * MS, 0.0, 1),  # a single call of 50 ms is too long
        (49.0 * MS, 0.2, None),  # the law is slow once, and again long after that
        (1.2 * MS, 0.02, 5),
        (1.2 * MS, 0.03, None),  # within 0.1 s there are four calls, which take 4.8 ms
    ],
)
def test_one_long_call_is_tolerated_and_several_within_a_tenth_of_a_second_are_not(spent, pause, calls):
    found = latched(spent, MS, pause=pause)
    assert (found and found[0]) == calls


class Clocks:
    """A clock of wall-clock time and one of processor time; each advances by a fixed time in s per tick."""

    def __init__(self, wall, processor):
        self.time, self.used, self.step = 50.0, 3.0, (wall, processor)
        self.looks = 0

    def now(self):
        self.looks += 1
        if self.looks % 2 == 0:  # the loop reads the clock twice per tick
            self.time, self.used = self.time + self.step[0], self.used + self.step[1]
        return self.time

    def thread_time(self):
        return self.used


@pytest.fixture
def lasting(monkeypatch):
    """Return a function that renders ticks of a harness, each with a given duration on the loop's clocks."""

    def render(harness, wall, processor, count):
        monkeypatch.setattr(tick, "clock", Clocks(wall, processor))
        found = headless.new_rows(count)
        for row in found:
            tick.live_tick.py_func(harness.r, 0.0, MS, 0.0, row)
        return found

    return render


def test_a_thread_that_waited_for_a_processor_has_no_slow_law(lasting):
    harness = LoopHarness(TURNING)
    out = lasting(harness, 15.0 * MS, 0.9 * MS, 300)
    assert harness.r.control.fault[0] == arrays.NO_FAULT
    assert np.all(out[:, rows.APPLIED_FORCE] == 1.0)
    assert harness.r.tick.law_time == pytest.approx(0.9 * MS)


def test_the_tick_that_latches_a_slow_law_gives_no_force(lasting):
    harness = LoopHarness(TURNING)
    out = lasting(harness, 1.5 * MS, 1.5 * MS, 5)
    np.testing.assert_array_equal(out[:, rows.APPLIED_FORCE], [1.0, 1.0, 1.0, 0.0, 0.0])
    np.testing.assert_array_equal(
        out[:, rows.FLAGS].astype(int) & rows.FAULT, [0, 0, 0, rows.FAULT, rows.FAULT]
    )
    assert harness.r.control.fault[0] == arrays.SLOW_LAW
    assert harness.r.tick.slow_law == TURNING.force.compiled().address


def test_two_laws_in_a_cross_fade_have_a_period_each(lasting):
    for spent, fault in ((1.9 * MS, arrays.NO_FAULT), (2.1 * MS, arrays.SLOW_LAW)):
        harness = LoopHarness(TURNING, {"place": "a"})
        harness.tick(0.0)
        harness.set(TURNING, {"place": "b"})
        harness.tick(0.0)
        assert harness.r.tick.blend < 1.0
        lasting(harness, spent, spent, 20)
        assert harness.r.control.fault[0] == fault


@pytest.mark.parametrize(("turns", "fault"), [(0, False), (47, False), (49, True)])
def test_a_call_is_charged_at_most_20_microseconds_per_iteration(lasting, turns, fault):
    """The host of a virtual machine may interrupt a short call for 4 ms, which the thread's clock includes.

    Therefore the number of iterations limits the time charged. The iteration that leaves the loop counts too.
    """
    harness = LoopHarness(TURNING, {"turns": turns})
    lasting(harness, 4.0 * MS, 4.0 * MS, 300)
    assert harness.r.control.fault[0] == (arrays.SLOW_LAW if fault else arrays.NO_FAULT)
    assert harness.r.tick.law_time == pytest.approx(0.02 * MS * (2 + turns), rel=1e-6)


# --- the observer calls the law


@law
def looped(p, s, x, v, dt):
    total = 0.0
    if x >= p.beyond:
        for i in range(251):
            total += i
    return -p.stiffness * x + 1e-9 * total


LOOPED = Environment("looped", "Looped", "", SLOW.parameters, looped)


def observed(environment, values, ticks=200, law_time=0.0):
    """Return the loop after some ticks at rest at 0 m; ``law_time`` is the duration of a call in s."""
    harness = LoopHarness(environment, values)
    harness.r.tick.law_time = law_time
    harness.ticks(ticks / 1000.0)
    return harness.r


def test_the_observer_calls_a_law_everywhere_unless_a_call_takes_more_than_250_iterations():
    r = observed(LOOPED, {"beyond": 1.0})
    assert (r.watch.cells_known, r.watch.opaque) == (passivity.CELLS + 1, 0)
    r = observed(LOOPED, {"beyond": 0.01})
    assert r.watch.opaque == 1
    assert r.watch.cells_known == 0.01 / passivity.CELL
    before = r.watch.calls
    r = observed(LOOPED, {"beyond": 0.01}, 400)
    assert r.watch.calls == before  # no further calls are made
    assert r.control.fault[0] == arrays.NO_FAULT


@pytest.mark.parametrize(
    ("each", "cells"),
    [(1e-6, 4), (0.5 * MS / 9.0, 4), (0.5 * MS / 8.99, 3), (0.5 * MS / 8.0, 3), (0.5 * MS / 2.9, 0), (MS, 0)],
)
def test_a_live_loop_gives_the_observer_at_most_half_a_period(each, cells):
    """The tick needs one call of the law, and each cell of the observer needs two.

    For example, if half a period suffices for nine calls, the observer can evaluate four cells.
    """
    each *= 1.0 - 1e-9
    r = observed(CONSTANT, None, 2, law_time=each)
    assert r.watch.cells_known == 1 + 2 * cells


# --- the law in a live loop


def test_a_law_slower_than_its_period_is_named_and_gives_no_force(started):
    engine = started(environment=SLOW)
    reader = engine.reader()
    engine.set_parameter("beyond", -1.0)
    wait_until(lambda: engine.fault is not None)
    assert engine.fault.code == arrays.SLOW_LAW
    assert engine.fault.text.startswith("Fault: the law of Far too slow takes ")
    assert engine.fault.text.endswith(" ms, but the period is 1 ms.")
    found = read(reader, lambda found: int(found[-1, rows.FLAGS]) & rows.FAULT)
    assert not found[-1, rows.APPLIED_FORCE].any()
    engine.set_environment("wall")
    wait_until(lambda: engine.renders(engine.environment))
    assert "Far too slow" in engine.fault.text  # the law is named, not the environment "wall"
    engine.clear_fault()
    wait_until(lambda: engine.fault is None)


# --- the law in a headless run


def scene(values):
    return headless.Scene(SLOW, SLOW.values(values))


def test_a_headless_run_ends_when_its_law_takes_too_long_and_not_before():
    done = api.simulate(SLOW, {"beyond": 1.0}, hand="press", seconds=0.5)
    assert len(done.time) == 500
    with pytest.raises(
        LawError, match=r"^The law of Far too slow takes \d.* ms for one sample, the limit is 1 ms\."
    ):
        api.simulate(SLOW, EVERYWHERE, hand="press", seconds=100.0)
    with pytest.raises(LawError, match="Far too slow"):
        headless.render(scene(EVERYWHERE), Prescribed(lambda t: 0.0), 2000)


def test_a_law_may_take_a_whole_period_of_a_slow_loop():
    done = api.simulate(SLOW, EVERYWHERE, rate=10.0, seconds=3.0)
    assert len(done.time) == 30


def test_no_verdict_is_given_on_a_handle_whose_law_is_too_slow(monkeypatch):
    monkeypatch.setattr(Environment, "curve", lambda _, values, x, v=0.0: -values["stiffness"] * x)
    asked = VerdictInput(SLOW, SLOW.values(EVERYWHERE), LoopSettings(hand="medium"))
    found = verdict(asked)
    assert (found.headline, found.calm, found.margins) == ("Not judged", False, {})
    assert found.lines == (
        "In your hand, the stability is not judged.",
        "After you let go, the stability is not judged.",
    )
    assert found.unknown.startswith("The law of Far too slow takes ")
    assert unstable_ranges(asked) == {}
    assert not verdict(replace(asked, values=SLOW.values({"beyond": 1.0}))).not_judged


@pytest.mark.slow
def test_an_interrupt_ends_compiled_loops_at_once():
    """Python writes a byte to a socket when a signal arrives; only a new call of ``listen`` removes it."""
    interrupts.listen()
    interrupts._ends[1].send(b"\2")
    r, body = scene({"beyond": 1.0}).prepare()
    count = 10_000_000
    same_row = np.lib.stride_tricks.as_strided(np.zeros(rows.ROW_WIDTH), (count, rows.ROW_WIDTH), (0, 8))
    zeros = np.zeros(count + 1)
    done = headless.run_batch(r, body, np.zeros(3), zeros, zeros[:-1].astype(np.int64), same_row)
    assert 0 < done < 10_000
    with pytest.raises(KeyboardInterrupt):
        patience.check(r, SLOW.title)
    cells = cell_batch.Cells(np.array([[200.0, 1.0]]), np.full(1, 1e-3), np.full(1, count), np.zeros(1))
    limits = cell_batch.Limits(1.0, cell_batch.NEVER_STILL, cell_batch.NEVER_FAINT, cell_batch.NEVER_SMALL)
    with pytest.raises(KeyboardInterrupt):
        cell_batch.run_cells(scene({"beyond": 1.0}), None, cells, limits)
    interrupts.listen()
    assert len(headless.render(scene({"beyond": 1.0}), None, 20_000)[0]) == 20_000
