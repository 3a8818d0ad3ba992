"""The recorder of a running loop misses no samples, stores every change, and keeps samples in memory."""

import os
import threading
import time

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.errors import DeviceError
from hapkit_studio.haptics import arrays, rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.tick import mark_stale
from hapkit_studio.sessions import settings_events
from hapkit_studio.sessions.file import MARKER, SETTINGS, STOP, SessionError, SessionWriter
from hapkit_studio.sessions.recorder import CLOCK_JUMPED, Recorder
from hapkit_studio.sessions.session import Session
from tests.waiting import wait_until


@pytest.fixture
def engine():
    engine = Engine(SimulatedHapkit(), "wall", realtime=False)
    engine.start()
    yield engine
    engine.close()


@pytest.fixture
def recorder(engine):
    recorder = Recorder(seconds=0.5)
    recorder.follow(engine)
    yield recorder
    recorder.close()


def collected(reader, pieces, samples):
    """Read rows in parallel with the recorder until ``samples`` more rows have arrived."""
    goal = sum(map(len, pieces)) + samples

    def enough():
        pieces.append(reader.read())
        return sum(map(len, pieces)) >= goal

    wait_until(enough)


def test_jumps_of_the_boards_clock_are_marked_in_the_session(engine, recorder, tmp_path):
    recorder.record(tmp_path / "a.hapkit")
    mark_stale(engine.arrays, 10.0, arrays.CLOCK_JUMP)
    collected(engine.reader(), [], 100)
    recorder.stop()
    found = [event.what for event in Session(tmp_path / "a.hapkit").events if event.kind == MARKER]
    assert found == [{"text": CLOCK_JUMPED}]


def test_events_noted_before_the_file_exists_are_recorded(engine, recorder, tmp_path):
    may_start = threading.Event()

    def path():
        may_start.wait()
        return tmp_path / "a.hapkit"

    recorder.note(MARKER, {"text": "before the request"})
    wait_for_start = recorder.request(path)
    recorder.note(MARKER, {"text": "first"})
    may_start.set()
    wait_for_start()
    recorder.note(MARKER, {"text": "second"})
    collected(engine.reader(), [], 100)
    recorder.stop()
    found = [event.what["text"] for event in Session(tmp_path / "a.hapkit").events if event.kind == MARKER]
    assert found == ["first", "second"]


@pytest.mark.slow
def test_a_recording_contains_every_sample_of_the_ring_and_every_change(engine, recorder, tmp_path):
    reader, pieces = engine.reader(), []
    recorder.record(tmp_path / "a.hapkit")
    engine.move_hand(0.02)
    collected(reader, pieces, 400)
    changed = time.perf_counter()
    engine.set_parameter("stiffness", 400.0)
    collected(reader, pieces, 400)
    recorder.note("marker", {"text": "stiffer"})
    engine.stop()
    collected(reader, pieces, 400)
    assert recorder.stop() == tmp_path / "a.hapkit"
    ring, session = np.concatenate(pieces), Session(tmp_path / "a.hapkit")
    found = session.read(("tick", "position", "applied_force"))
    assert (np.diff(found["tick"]) == 1.0).all()
    both, ours, theirs = np.intersect1d(found["tick"], ring[:, rows.TICK], return_indices=True)
    assert len(both) > 700
    assert np.abs(found["position"][ours] - ring[theirs, rows.POSITION]).max() < 1e-8
    assert np.abs(found["applied_force"][ours] - ring[theirs, rows.APPLIED_FORCE]).max() < 1e-6
    event = [e for e in session.events if e.kind == SETTINGS][-1]
    assert event.what["parameters"]["stiffness"] == 400.0
    assert 0.0 < event.time - changed < 5.0
    assert [e.what for e in session.events if e.kind == "marker"] == [{"text": "stiffer"}]
    assert session.latest(STOP) == {"stopped": True}


@pytest.mark.slow
def test_past_samples_can_be_saved_with_the_settings_of_their_time(engine, recorder, tmp_path):
    engine.set_environment("spring", {"stiffness": 123.0})
    pieces = []
    collected(engine.reader(), pieces, 2000)
    count = recorder.save(tmp_path / "a.hapkit")
    run = hs.open_session(tmp_path / "a.hapkit")
    assert len(run.time) == count
    kept = Session(tmp_path / "a.hapkit")
    assert kept.stops[0] >= kept.stops[-1] - 0.5  # no chunk is older than the duration that is kept in memory
    ring = np.concatenate(pieces)
    newest = ring[ring[:, rows.HOST_TIME] >= kept.stops[-1] - 0.5, rows.TICK]
    assert len(np.setdiff1d(newest, kept.read(("tick",))["tick"])) == 0
    assert run.settings["parameters"]["stiffness"] == 123.0


@pytest.mark.slow
def test_a_delayed_thread_makes_no_larger_chunks(engine, recorder, tmp_path):
    recorder.record(tmp_path / "a.hapkit")
    reader, go_on = engine.reader(), threading.Event()
    recorder._jobs.put(go_on.wait)
    collected(reader, [], 2000)
    go_on.set()
    recorder.stop()
    session = Session(tmp_path / "a.hapkit")
    assert session.counts.sum() > 2000
    assert (np.diff(session.read(("tick",))["tick"]) == 1.0).all()
    assert session.counts.max() <= 1000  # chunks stay small although 2000 samples were waiting


def test_saving_without_samples_is_refused(tmp_path):
    recorder = Recorder()
    with pytest.raises(SessionError, match="nothing to save"):
        recorder.save(tmp_path / "a.hapkit")
    recorder.close()
    assert not (tmp_path / "a.hapkit").exists()


@pytest.mark.slow
def test_a_recording_that_cannot_continue_ends_with_the_reason_and_is_readable(engine, recorder, tmp_path):
    recorder.record(tmp_path / "a.hapkit")
    recorder._writer._database.execute("PRAGMA max_page_count=8")
    wait_until(lambda: recorder.progress.error)
    assert recorder.progress.error == "The disk is full. The earlier samples are in a.hapkit."
    samples = recorder.progress.samples
    assert Session(tmp_path / "a.hapkit").counts.sum() == samples > 0
    assert recorder.stop() is None
    recorder.record(tmp_path / "b.hapkit")  # the next recording starts normally
    assert recorder.stop() == tmp_path / "b.hapkit"


@pytest.mark.skipif(os.name == "nt", reason="Windows keeps open files where they are")
def test_a_recording_whose_file_is_deleted_ends_and_the_samples_in_memory_can_be_saved(recorder, tmp_path):
    recorder.record(tmp_path / "a.hapkit")
    wait_until(lambda: recorder.progress.samples > 0)
    (tmp_path / "a.hapkit").unlink()
    wait_until(lambda: recorder.progress.error)
    assert recorder.progress.error == "a.hapkit was deleted or moved while it was written."
    assert recorder.stop() is None
    assert recorder.save(tmp_path / "b.hapkit") > 0
    assert Session(tmp_path / "b.hapkit").check() == ()


def test_a_file_deleted_just_before_the_end_is_not_called_saved(recorder, tmp_path):
    recorder.record(tmp_path / "a.hapkit")
    recorder._wait(lambda: (tmp_path / "a.hapkit").unlink())
    assert recorder.stop() is None
    assert recorder.progress.error == "a.hapkit was deleted or moved while it was written."


@pytest.mark.slow
def test_a_recording_continues_on_another_device(engine, recorder, tmp_path):
    recorder.record(tmp_path / "a.hapkit")
    wait_until(lambda: recorder.progress.samples > 100)
    other = Engine(SimulatedHapkit(mass=0.1), "damping", realtime=False)
    other.start()
    recorder.follow(other)
    before = recorder.progress.samples
    wait_until(lambda: recorder.progress.samples > before + 700)
    recorder.stop()
    other.close()
    session = Session(tmp_path / "a.hapkit")
    settings = [e.what for e in session.events if e.kind == SETTINGS]
    assert [s["environment"] for s in settings] == ["wall", "damping"]
    assert settings[-1]["device"]["mass"] == 0.1
    assert session.check() == ()


def test_a_fault_is_recorded_with_its_reason(engine, recorder, tmp_path):
    recorder.record(tmp_path / "a.hapkit")
    wait_until(lambda: recorder.progress.samples > 0)
    engine.arrays.control.fault[0] = arrays.DEVICE_GONE
    assert hs.open_session(recorder.stop()).faults == (engine.fault.text,)


def test_closing_the_device_loses_no_row_and_does_not_end_the_recording(
    engine, recorder, tmp_path, monkeypatch
):
    def closed(_engine):
        raise DeviceError("It is not open.")

    recorder.record(tmp_path / "a.hapkit")
    reader, pieces = engine.reader(), []
    collected(reader, pieces, 300)
    recorder._wait(recorder._take)
    monkeypatch.setattr(settings_events, "about_device", closed)
    collected(reader, pieces, 300)
    recorder.follow(None)
    recorder.stop()
    found = Session(tmp_path / "a.hapkit").read(("tick",))["tick"]
    wanted = np.concatenate(pieces)[:, rows.TICK]
    assert len(np.setdiff1d(wanted, found)) == 0
    recorder.follow(engine)  # the recorder is closed before it is first polled
    assert recorder.stop() is None


def test_a_full_disk_at_the_end_names_the_file_with_the_remaining_data(recorder, tmp_path, monkeypatch):
    def refuse(writer):
        writer._database.close()
        raise SessionError("The disk is full.")

    recorder.record(tmp_path / "a.hapkit")
    monkeypatch.setattr(SessionWriter, "close", refuse)
    monkeypatch.setattr(SessionWriter, "remains", "Both files.")
    with pytest.raises(SessionError, match=r"^The disk is full\. Both files\.$"):
        recorder.stop()


def test_a_recording_that_cannot_be_completed_is_over_nevertheless(recorder, tmp_path, monkeypatch):
    def refuse(_writer):
        raise SessionError("The disk is gone.")

    recorder.record(tmp_path / "a.hapkit")
    assert recorder.progress is not None
    monkeypatch.setattr(SessionWriter, "close", refuse)
    with pytest.raises(SessionError, match="gone"):
        recorder.stop()
    assert recorder.progress is None


def test_callers_do_not_wait_for_a_recorder_after_a_defect(capsys):
    recorder = Recorder()
    recorder._jobs.put(lambda: 1 / 0)
    with pytest.raises(SessionError, match="has failed"):
        recorder.stop()
    assert "ZeroDivisionError" in capsys.readouterr().err
