"""The history of a recorded session agrees with the samples that were written."""

import math
import sqlite3

import numpy as np
import pytest

from hapkit_studio.dynamics.loop_settings import RATE
from hapkit_studio.environments import discover
from hapkit_studio.gui.live import recorded as module
from hapkit_studio.gui.live.plots.declared import OBJECT
from hapkit_studio.gui.live.recorded import Recorded
from hapkit_studio.haptics import rows
from hapkit_studio.sessions.chunk import BLOCK, pack
from hapkit_studio.sessions.file import SETTINGS, Event, SessionWriter
from hapkit_studio.sessions.session import Session
from tests.sessions.test_chunk import QUANTUM, table
from tests.sessions.test_overview import motion, write

SECONDS = 4.0


@pytest.fixture
def written():
    """Return rows at 1 kHz with a random position and a law without state."""
    made = motion(SECONDS)
    made[:, rows.POSITION] = QUANTUM * np.cumsum(np.random.default_rng(3).integers(-9, 10, len(made)))
    made[:, rows.FORCE] = np.sin(made[:, rows.HOST_TIME])
    return made


@pytest.fixture
def recorded(tmp_path, written):
    write(tmp_path / "a.hapkit", written)
    return Recorded(Session(tmp_path / "a.hapkit"))


def extremes(written, edges, reach=0.0):
    """Return the extreme positions in each interval between edges, widened by ``reach`` s on both sides."""
    time, position = written[:, rows.HOST_TIME], written[:, rows.POSITION]
    pairs = zip(edges[:-1] - reach, edges[1:] + reach, strict=True)
    parts = [position[(time >= a) & (time < b)] for a, b in pairs]
    return np.array([(part.min(), part.max()) for part in parts]).T


def drawn(window):
    pairs = window.y["position"].reshape(-1, 2)
    return pairs.min(axis=1), pairs.max(axis=1)


def test_each_column_contains_its_extreme_samples(recorded, written):
    edges = 100.0005 + np.linspace(0.4, 3.6, 101)  # no sample lies on an edge
    window = recorded.window(edges)
    assert window.dense
    assert np.allclose(drawn(window), extremes(written, edges), atol=1e-9)


def test_a_long_stretch_is_drawn_from_block_extremes(recorded, written, monkeypatch):
    """A block of 64 ms belongs to the column that contains its middle, so columns may differ by one block."""
    monkeypatch.setattr(module, "PICTURED", 0)
    edges = 100.0 + np.linspace(0.0, SECONDS, 11)
    window = recorded.window(edges)
    (low, high), block = drawn(window), 1e-3 * BLOCK
    for reach, wider in ((block, True), (-block, False)):
        least, greatest = extremes(written, edges, reach)
        assert np.all((least - 1e-9 <= low) if wider else (low <= least + 1e-9))
        assert np.all((greatest + 1e-9 >= high) if wider else (high >= greatest - 1e-9))
    assert max(high) == pytest.approx(written[:, rows.POSITION].max(), rel=1e-6)
    assert min(low) == pytest.approx(written[:, rows.POSITION].min(), rel=1e-6)


@pytest.mark.parametrize("slope", [1.0, -1.0])
def test_blocks_follow_the_trend(tmp_path, monkeypatch, slope):
    monkeypatch.setattr(module, "PICTURED", 0)
    made = motion(SECONDS)
    made[:, rows.POSITION] = slope * QUANTUM * np.arange(len(made))
    write(tmp_path / "a.hapkit", made)
    window = Recorded(Session(tmp_path / "a.hapkit")).window(np.linspace(100.0, 103.9, 400))
    assert not window.dense
    assert np.all(slope * np.diff(window.y["position"]) > 0.0)


def test_the_sample_at_a_time_is_the_last_one_before_it(recorded, written):
    times = written[:, rows.HOST_TIME]
    for number in (0, 1, 299, 300, 301, 2500, 3998):
        for after in (1e-6, 5e-4, 9.99e-4):
            recorded.move_to(times[number] + after)
            assert recorded.row()[rows.TICK] == number
            assert recorded.latest()["position"] == pytest.approx(written[number, rows.POSITION])
            assert recorded.before(recorded.now) == pytest.approx(times[number], abs=1e-7)
            assert recorded.after(recorded.now) == pytest.approx(times[number + 1], abs=1e-7)
        exact = recorded.before(recorded.now)
        recorded.move_to(exact)
        assert recorded.row()[rows.TICK] == number
        assert recorded.after(exact) > exact
    assert recorded.at(99.9) is None
    assert math.isnan(recorded.before(recorded.start))
    assert math.isnan(recorded.after(recorded.stop))


def test_samples_between_two_times_do_not_depend_on_earlier_reads(recorded, written):
    for start, stop in ((1.0, 1.5), (1.4, 2.2), (0.2, 0.3), (3.0, 9.0), (0.0, 4.0)):
        found = recorded.between(100.0005 + start, 100.0005 + stop).known()
        first, last = (min(round(1000 * at) + 1, len(written)) for at in (start, stop))
        assert np.allclose(found.y["position"], written[first:last, rows.POSITION], atol=1e-9)
    recorded.move_to(102.0005)
    assert len(recorded.between(101.0005, math.inf).x) == 1000


def test_too_many_samples_are_not_returned(recorded, monkeypatch):
    monkeypatch.setattr(module, "READ_AT_ONCE", 1000)
    assert len(recorded.between(100.0, 100.2).x)
    assert not len(recorded.between(100.0, 104.0).x)


@pytest.mark.parametrize("pictured", [module.PICTURED, 0], ids=["samples", "blocks"])
def test_a_gap_is_not_bridged(tmp_path, monkeypatch, pictured):
    monkeypatch.setattr(module, "PICTURED", pictured)
    write(tmp_path / "a.hapkit", motion(2.0), motion(2.0, 110.0))
    window = Recorded(Session(tmp_path / "a.hapkit")).window(np.linspace(100.0, 112.0, 25))
    (gap,) = np.flatnonzero(np.isnan(window.x))
    assert window.x[gap - 1] <= 102.0
    assert window.x[gap + 1] >= 110.0


def test_damaged_chunks_are_left_out(tmp_path):
    path = tmp_path / "a.hapkit"
    write(path, motion(2.0))
    history = Recorded(Session(path))
    database = sqlite3.connect(path)
    database.execute("UPDATE chunk SET velocity = x'00' WHERE id = 3")
    database.commit()
    assert len(history.between(100.0, 102.1).known().x) == 1700
    history.move_to(100.7)
    assert history.row() is None
    assert math.isnan(history.latest()["position"])


def test_environments_settings_and_markers_come_from_the_session(recorded):
    found = []
    for after in (0.0, 0.499, 0.501, 0.699, 0.701):
        recorded.move_to(100.0 + after)
        found.append((recorded.settings()["environment"], round(recorded.begin - 100.0, 3)))
    assert found == [("wall", -1.0), ("wall", -1.0), ("spring", 0.5), ("spring", 0.5), ("wall", 0.7)]
    assert [(round(when - 100.0, 3), text) for when, text in recorded.markers] == [(0.25, "a quarter")]


def test_clamped_forces_since_a_time_are_reported(tmp_path):
    made = table(300)
    made[:, rows.FLAGS] = 0.0
    made[100, rows.FLAGS] = rows.CLAMPED
    write(tmp_path / "a.hapkit", made)
    history = Recorded(Session(tmp_path / "a.hapkit"))
    times = made[:, rows.HOST_TIME] + 1e-5
    for before, now, clamped in ((98, 99, False), (99, 100, True), (50, 250, True), (100, 101, False)):
        history.move_to(times[now])
        assert history.clamped_since(times[before]) == clamped


def test_the_object_position_follows_state_or_handle(tmp_path):
    """The cases are a mass with a stored state, a button's cap at rest at 8 mm, and a missing law."""
    made, mass = motion(1.5), discover()["mass_spring_damper"]
    column = rows.STATE + mass.state_names.index("object")
    made[:, column] = 0.01 * np.cos(made[:, rows.HOST_TIME])
    made[:, rows.POSITION] = QUANTUM * np.arange(len(made))
    writer = SessionWriter(tmp_path / "a.hapkit")
    for after, key, values in (
        (-1.0, mass.key, {}),
        (0.45, "button", {"position": 0.008}),
        (1.0, "lost", {}),
    ):
        writer.note(Event(100.0 - 1e-4 + after, SETTINGS, {"environment": key, "parameters": values}))
    for part in np.split(made, 5):
        writer.add(pack(part, QUANTUM, len(mass.state_names)))
    writer.close()
    history = Recorded(Session(tmp_path / "a.hapkit"), discover())
    expected = np.maximum(made[:, rows.POSITION], 0.008)
    expected[:450], expected[1000:] = made[:450, column], np.nan
    np.testing.assert_allclose(history.between(0.0, 200.0).y[OBJECT], expected, rtol=2.0**-23)
    for number in (449, 450, 999, 1000):
        found = history.at(made[number, rows.HOST_TIME] + 1e-5)[OBJECT]
        assert found == pytest.approx(expected[number], rel=1e-6, nan_ok=True)


@pytest.mark.slow
def test_the_object_is_drawn_over_a_minute_at_the_highest_rate(tmp_path):
    """The object oscillates by 10 mm at 1 Hz; each of 240 columns spans 0.25 s and has its own extremes."""
    seconds, rate, mass = 60.0, RATE.high, discover()["mass_spring_damper"]
    made = np.zeros((round(seconds * rate), rows.ROW_WIDTH))
    made[:, rows.TICK] = np.arange(len(made))
    made[:, rows.HOST_TIME] = 100.0 + made[:, rows.TICK] / rate
    made[:, rows.STATE + mass.state_names.index("object")] = 0.01 * np.sin(
        2 * np.pi * made[:, rows.TICK] / rate
    )
    writer = SessionWriter(tmp_path / "a.hapkit")
    writer.note(Event(99.0, SETTINGS, {"environment": mass.key, "parameters": {}}))
    for part in np.split(made, 150):
        writer.add(pack(part, QUANTUM, len(mass.state_names)))
    writer.close()
    edges = 100.0 - 0.5 / rate + np.linspace(0.0, seconds, 241)
    found = Recorded(Session(tmp_path / "a.hapkit"), discover()).window(edges).y[OBJECT].reshape(-1, 2)
    assert found.max(axis=1) == pytest.approx(np.tile([0.01, 0.01, 0.0, 0.0], 60), abs=1e-5)
    assert found.min(axis=1) == pytest.approx(np.tile([0.0, 0.0, -0.01, -0.01], 60), abs=1e-5)
