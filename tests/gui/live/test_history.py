"""The history agrees with the simplest possible computation on the same samples."""

import itertools
import math
import tracemalloc

import numpy as np
import pytest

from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import COLUMN

RATE = 4000.0
PLOTTED = ("position", "velocity", "force", "applied_force")


def telemetry(count, seed=0, start=0, rate=RATE):
    """Return rows of noise at a steady rate."""
    random = np.random.default_rng(seed)
    table = np.zeros((count, rows.ROW_WIDTH))
    table[:, rows.TICK] = start + np.arange(count)
    table[:, rows.HOST_TIME] = table[:, rows.TICK] / rate
    table[:, rows.POSITION : rows.APPLIED_FORCE + 1] = random.normal(size=(count, 4))
    return table


def feed(history, table):
    """Append samples in chunks of varying size, as the window does in its frames."""
    cuts = np.cumsum(np.random.default_rng(1).integers(1, 900, len(table) // 300))
    for part in np.split(table, cuts[cuts < len(table)]):
        history.append(part)


def brute(table, t0, t1, columns):
    """Return the columns that contain samples, and their minima and maxima for each channel."""
    edges, time = np.linspace(t0, t1, columns + 1), table[:, rows.HOST_TIME]
    inside = [(time >= a) & (time < b) for a, b in itertools.pairwise(edges)]
    filled = [n for n in range(columns) if inside[n].any()]
    return filled, {
        name: [(table[inside[n], i].min(), table[inside[n], i].max()) for n in filled]
        for name, i in ((n, COLUMN[n]) for n in PLOTTED)
    }


def extremes(window, name):
    return np.sort(window.y[name].reshape(-1, 2), axis=1)


@pytest.mark.parametrize(("columns", "span"), [(7, 12.0), (61, 0.9), (61, 12.0)])
def test_each_column_has_the_extremes_of_its_samples(span, columns):
    history = LiveHistory(seconds=8.0, rate=RATE)
    table = telemetry(40_000)
    feed(history, table)
    table = table[table[:, rows.HOST_TIME] >= history.now - 8.0]
    t1 = history.now - 0.013
    shown = history.window(np.linspace(t1 - span, t1, columns + 1))
    filled, expected = brute(table, t1 - span, t1, columns)
    assert shown.dense
    for name in PLOTTED:
        np.testing.assert_array_equal(extremes(shown, name), expected[name])
    column = np.floor((shown.x - (t1 - span)) / (span / columns)).astype(int)
    np.testing.assert_array_equal(column, np.repeat(filled, 2))


def test_few_samples_are_returned_unchanged_with_one_neighbour_on_each_side():
    history = LiveHistory(seconds=8.0, rate=RATE)
    table = telemetry(5000)
    history.append(table)
    shown = history.window(np.linspace(0.5, 0.6, 451))
    assert not shown.dense
    np.testing.assert_array_equal(shown.x, table[1999:2401, rows.HOST_TIME])
    np.testing.assert_array_equal(shown.y["applied_force"], table[1999:2401, rows.APPLIED_FORCE])


@pytest.mark.parametrize(("t0", "t1", "dense"), [(0.0, 2.0, True), (0.99, 1.03, False)])
@pytest.mark.parametrize("how", ["jump", "flag"])
def test_lost_frames_are_a_gap(how, t0, t1, dense):
    table = telemetry(8000)
    if how == "jump":
        table[4000:, rows.TICK] += 40
        table[4000:, rows.HOST_TIME] += 0.01
    else:
        table[4000, rows.FLAGS] = rows.GAP | rows.CLAMPED
    table[0, rows.FLAGS] = rows.GAP  # a gap before the first sample has no effect
    history = LiveHistory(seconds=8.0, rate=RATE)
    feed(history, table)
    shown = history.window(np.linspace(t0, t1, 101))
    assert shown.dense is dense
    (gap,) = np.flatnonzero(np.isnan(shown.x))
    assert np.isnan(shown.y["position"][gap])
    width = (t1 - t0) / 100
    assert shown.x[gap - 1] <= 1.0
    assert shown.x[gap + 1] >= table[4000, rows.HOST_TIME] - width


def test_only_the_last_seconds_are_stored():
    history = LiveHistory(seconds=2.0, rate=RATE)
    for part in range(40):
        history.append(telemetry(1500, seed=part, start=1500 * part))
    assert history.now == pytest.approx((60_000 - 1) / RATE)
    assert history.start == pytest.approx(history.now - 2.0)
    last = telemetry(1500, seed=39, start=58_500)
    newest = history.between((60_000 - 10) / RATE, np.inf)
    np.testing.assert_array_equal(newest.x, last[-10:, rows.HOST_TIME])
    np.testing.assert_array_equal(newest.y["position"], last[-10:, rows.POSITION])
    assert history.latest()["applied_force"] == last[-1, rows.APPLIED_FORCE]


def test_appending_samples_needs_no_memory_for_a_copy():
    history = LiveHistory(seconds=6.0, rate=RATE)
    history.append(telemetry(30_000))
    tracemalloc.start()
    for start in range(30_000, 110_000, 500):  # the history moves its stored half to the front twice
        history.append(telemetry(500, start=start))
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < len(history) * 8  # the size of one channel in bytes


def test_a_copy_does_not_change_with_the_original():
    history = LiveHistory(seconds=3.0, rate=RATE)
    table = telemetry(20_000)
    feed(history, table)
    kept = history.copy()
    feed(history, telemetry(20_000, seed=5, start=20_000))
    _, expected = brute(table, kept.now - 2.5, kept.now, 80)
    shown = kept.window(np.linspace(kept.now - 2.5, kept.now, 81))
    np.testing.assert_array_equal(extremes(shown, "velocity"), expected["velocity"])


def test_a_clock_that_goes_back_restarts_the_history():
    history = LiveHistory(seconds=3.0, rate=RATE)
    history.append(telemetry(1000, start=5000))
    history.append(telemetry(10))
    assert len(history) == 10
    assert history.start == 0.0
    assert history.at(-0.1) is None
    assert history.at(0.00101)["force"] == telemetry(10)[4, rows.FORCE]


def test_an_empty_history_draws_nothing():
    history = LiveHistory(seconds=3.0)
    history.append(np.empty((0, rows.ROW_WIDTH)))
    assert len(history.window(np.linspace(0.0, 1.0, 101)).x) == 0
    assert np.isnan(history.now)
    assert np.isnan(history.latest()["position"])


def test_changes_are_stored_as_long_as_their_samples():
    history = LiveHistory(seconds=2.0, rate=RATE)
    history.divide("Nothing came before")
    history.append(telemetry(4000))
    history.divide("Spring")
    history.divide("Wall")  # no sample was taken with the spring
    history.end_environment()
    at = 3999 / RATE
    assert history.dividers == [(at, "Wall")]
    assert not len(history.between(history.begin, np.inf).x)
    kept, begin = history.copy(), history.begin
    history.append(telemetry(4000, start=4000))
    assert len(history.between(history.begin, np.inf).x) == 4000
    history.divide("Stiffness 300 N/m")
    assert history.dividers == [(at, "Wall"), (7999 / RATE, "Stiffness 300 N/m")]
    assert history.begin == begin
    history.append(telemetry(4001, start=8000))
    assert [text for _, text in history.dividers] == ["Stiffness 300 N/m"]
    assert kept.dividers == [(at, "Wall")]
    history.clear()
    assert (history.dividers, history.begin) == ([], -np.inf)


def test_a_signal_that_starts_late_is_drawn_from_its_first_value():
    """One example is the observer's energy, which is NaN before its first value."""
    table = telemetry(4000)
    table[:, COLUMN["energy_given"]] = math.nan
    table[3000:, COLUMN["energy_given"]] = 1.0
    history = LiveHistory(10.0, RATE)
    feed(history, table[:2000])
    assert np.isnan(history.window(np.linspace(0.0, 0.5, 11)).y["energy_given"]).all()
    history.append(table[2000:])
    values = history.window(np.linspace(0.0, 1.0, 11)).y["energy_given"]
    # the column with the first value also contains NaN
    np.testing.assert_array_equal(values, [math.nan] * 16 + [1.0] * 4)
    history.clear()
    history.append(table[:2000])
    assert np.isnan(history.window(np.linspace(0.0, 0.5, 11)).y["energy_given"]).all()
