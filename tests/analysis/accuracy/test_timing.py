"""The shortest of several turns, by a clock that the work itself moves."""

import time

import pytest

from hapkit_studio.analysis.accuracy import timing


class Clock:
    """A clock that stands still but for the work done."""

    def __init__(self):
        self.now = 0
        self.order = []

    def __call__(self):
        return self.now

    def work(self, name, durations):
        """Return what prepares work that takes one duration after the other, the last for ever."""
        left = list(durations)

        def prepare():
            self.now += 1_000_000  # making ready costs, outside of the time

            def do():
                self.order.append(name)
                self.now += left.pop(0) if len(left) > 1 else left[0]

            return do

        return prepare


@pytest.fixture
def clock():
    return Clock()


def test_the_shortest_turn_counts_and_candidates_take_turns(clock):
    disturbed = clock.work("a", [90_000, 5000, 700, 80_000, 500, 600])
    steady = clock.work("b", [300])
    assert timing.shortest([disturbed, steady], clock)[1] == 300
    assert clock.order[:8] == ["a", "b", "a", "b", "b", "a", "a", "b"]
    assert len(clock.order) / 2 >= timing.LEAST_TURNS


def test_one_lucky_turn_is_not_believed_until_others_are_as_short(clock):
    """Slow for 60 turns but one: the turns go on until the short time came HITS times."""
    slow = clock.work("a", [1400] * 5 + [1000] + [1400] * 55 + [1010])
    steady = clock.work("b", [900])
    assert timing.shortest([slow, steady], clock) == [1000, 900]
    assert clock.order.count("a") - 1 == 60 + timing.HITS - 1


def test_turns_that_only_fall_end_all_the_same(clock):
    falling = clock.work("a", [int(1e7 * 0.97**n) for n in range(500)])
    timing.shortest([falling], clock)
    assert len(clock.order) == timing.MOST_TURNS + 1
    clock.order.clear()
    dear = clock.work("a", [int(1e9 * 0.9**n) for n in range(500)])
    timing.shortest([dear], clock)
    assert len(clock.order) == timing.LEAST_TURNS + 1


@pytest.mark.parametrize(("step", "fine"), [(1, True), (15_625_000, False)])
def test_a_thread_clock_of_long_steps_is_not_used(monkeypatch, step, fine):
    """Windows says that its steps are 0.1 µs long; they are 15.6 ms."""
    wall = iter(range(0, 10**9, 500))
    monkeypatch.setattr(time, "perf_counter_ns", lambda: next(wall))
    monkeypatch.setattr(time, "thread_time_ns", lambda: next(wall) // step * step)
    assert (timing.clock() is time.thread_time_ns) == fine


def test_sleep_is_not_counted_where_the_threads_own_time_is(clock):
    (cost,) = timing.shortest([lambda: lambda: None])
    assert 0 < cost < 1e5
