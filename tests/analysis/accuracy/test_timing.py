"""The shortest of several turns, by a clock that the work itself moves."""

import pytest

from hapkit_studio.analysis.accuracy import timing


class Clock:
    """A clock that stands still but for the work done."""

    def __init__(self):
        self.now = 0
        self.order = []

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
def clock(monkeypatch):
    made = Clock()
    monkeypatch.setattr(timing.time, "perf_counter_ns", lambda: made.now)
    return made


def test_the_shortest_turn_counts_and_candidates_take_turns(clock):
    disturbed = clock.work("a", [90_000, 5000, 700, 80_000, 500, 600])
    steady = clock.work("b", [300])
    assert timing.shortest([disturbed, steady]) == [500, 300]
    assert clock.order[:4] == ["a", "b", "a", "b"]
    assert len(clock.order) / 2 >= timing.LEAST_TURNS


def test_turns_go_on_while_they_get_shorter_but_not_for_ever(clock):
    falling = clock.work("a", [int(1e6 * 0.98**n) for n in range(500)])
    timing.shortest([falling])
    assert len(clock.order) == timing.MOST_TURNS + 1
