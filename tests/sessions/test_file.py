"""Sessions as files: what was written is read, even after failures of the program, the disk or the file."""

import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from contextlib import closing

import numpy as np
import pytest

from hapkit_studio.haptics import rows
from hapkit_studio.sessions import database
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.file import SETTINGS, Event, SessionError, SessionWriter
from hapkit_studio.sessions.session import Session, add_note
from tests.sessions.test_chunk import QUANTUM, table

CHUNKS = 20


def written(path, chunks=CHUNKS, close=True):
    made = table(chunks * 300)
    writer = SessionWriter(path)
    writer.note(Event(made[0, rows.HOST_TIME], SETTINGS, {"environment": "wall", "rate_Hz": 1000.0}))
    for first in range(0, len(made), 300):
        writer.add(pack(made[first : first + 300], QUANTUM, 0))
    if close:
        writer.close()
    return made


def test_all_samples_between_two_times_are_read(tmp_path):
    made = written(tmp_path / "a.hapkit")
    session = Session(tmp_path / "a.hapkit")
    time = made[:, rows.HOST_TIME]
    start, stop = time[450], time[1234]
    found = session.read(("time", "position", "true_position"), start - 1e-4, stop - 1e-4)
    assert np.allclose(found["time"], time[450:1234], atol=1e-6)
    assert np.array_equal(found["position"], made[450:1234, rows.POSITION])
    assert np.isnan(found["true_position"]).all()
    assert session.latest(SETTINGS)["environment"] == "wall"
    assert session.check() == ()
    assert not (tmp_path / "a.hapkit-wal").exists()


def test_a_file_that_exists_is_never_overwritten(tmp_path):
    path = tmp_path / "a.hapkit"
    path.write_text("mine")
    with pytest.raises(SessionError, match=r"a\.hapkit exists already"):
        SessionWriter(path)
    assert path.read_text() == "mine"


def test_a_missing_or_write_protected_folder_is_one_line(tmp_path):
    with pytest.raises(SessionError, match="cannot be written: No such file"):
        SessionWriter(tmp_path / "none" / "a.hapkit")


@pytest.mark.parametrize("content", [b"", b"SQLite format 3\0" + bytes(84), b"x,y\n1,2\n"])
def test_a_foreign_file_is_one_line(tmp_path, content):
    path = tmp_path / "a.hapkit"
    path.write_bytes(content)
    with pytest.raises(SessionError, match="is not a session"):
        Session(path)


@pytest.mark.parametrize(
    ("statement", "text"),
    [
        ("CREATE TRIGGER t AFTER INSERT ON event BEGIN DELETE FROM chunk; END", "is not a session"),
        ("CREATE VIEW v AS SELECT 1", "is not a session"),
        ("DROP TABLE event", "is not a session"),
        ("ALTER TABLE chunk ADD COLUMN more", "is not a session"),
        ("DROP TABLE signal", "is not a session"),
        (
            "UPDATE signal SET delta_to = 'energy' WHERE name = 'velocity'",
            "the list of its signals is damaged",
        ),
        ("DELETE FROM signal WHERE name = 'velocity'", "is not a session"),
        ("DELETE FROM signal WHERE name = 'time'", "the list of its signals has no time"),
        ("PRAGMA user_version=3", "version 3, not 2"),
    ],
)
def test_files_with_other_tables_or_a_newer_version_are_refused(tmp_path, statement, text):
    path = tmp_path / "a.hapkit"
    written(path, 1)
    with sqlite3.connect(path) as database:
        database.execute(statement)
    with pytest.raises(SessionError, match=text):
        Session(path)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ("position = NULL", "position is NULL; it must be BLOB."),
        ("position = 'text'", "position is TEXT; it must be BLOB."),
        ("count = 1000000000", "count is 1000000000; it must be a whole number from 1 to 65,536."),
        ("count = 'many'", "count is TEXT; it must be INTEGER."),
        ("states = -1", "states is -1; it must be a whole number from 0 to 16."),
        ("start = 1e300", "start is 1e+300; it must be a number from -1e+09 to 1e+09 s."),
        ("extremes = x'00'", "Samples cannot be read: "),
        ("extremes = NULL", "extremes is NULL; it must be BLOB."),
        ("crc = crc + 1", "its checksum is wrong."),
        ("tick = zeroblob(1000000)", "its checksum is wrong."),
        # the changed chunk would end after the next one starts
        ("stop = stop + 60.0", "its checksum is wrong."),
    ],
)
def test_only_the_damaged_chunk_is_skipped(tmp_path, change, reason):
    path = tmp_path / "a.hapkit"
    written(path)
    with sqlite3.connect(path) as database:
        database.execute(f"UPDATE chunk SET {change} WHERE id = 3")
    session = Session(path)
    assert (session.starts[1:] > session.stops[:-1]).all()
    assert len(session.read(("position",))["position"]) == 300 * (CHUNKS - 1)
    (damage,) = session.check()
    assert damage.startswith(f"a.hapkit is damaged. Skipped: chunk 3: {reason}")


def test_a_randomly_damaged_file_gives_one_line_or_the_data_written(tmp_path):
    """The test has 120 files with changed bits, a truncated end, or other values in their tables."""
    made = written(tmp_path / "whole.hapkit")
    whole, chance = (tmp_path / "whole.hapkit").read_bytes(), random.Random(3)
    known = set(map(tuple, made[:, [rows.TICK, rows.POSITION]].tolist()))
    readable, lines = 0, []
    for number in range(120):
        path = tmp_path / "damaged.hapkit"
        data = bytearray(whole)
        for _ in range(chance.choice([1, 3, 30])):
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        path.write_bytes(data[: chance.randrange(len(data))] if number % 3 == 0 else data)
        try:
            session = Session(path)
            found = session.read(("tick", "position"))
            session.close()
        except SessionError as error:
            lines.append(str(error))
            continue
        got = set(zip(found["tick"].tolist(), found["position"].tolist(), strict=True))
        assert got <= known
        assert got == known or session.damage, number
        readable += 1
    assert readable > 40  # many of the damaged files still return their intact parts
    assert all("damaged.hapkit" in line and "\n" not in line for line in lines)


def test_a_repaired_session_contains_the_intact_data(tmp_path):
    written(tmp_path / "a.hapkit")
    with sqlite3.connect(tmp_path / "a.hapkit") as database:
        database.execute("UPDATE chunk SET velocity = x'00' WHERE id = 7")
    before = (tmp_path / "a.hapkit").read_bytes()
    session = Session(tmp_path / "a.hapkit")
    assert session.repair(tmp_path / "b.hapkit")
    assert Session(tmp_path / "b.hapkit").check() == ()
    assert len(Session(tmp_path / "b.hapkit").read(("tick",))["tick"]) == 300 * (CHUNKS - 1)
    assert (tmp_path / "a.hapkit").read_bytes() == before


def test_a_full_disk_ends_in_one_line_and_keeps_the_data_written(tmp_path):
    writer = SessionWriter(tmp_path / "a.hapkit")
    writer._database.execute("PRAGMA max_page_count=40")
    chunk = pack(table(300), QUANTUM, 0)
    adding = (writer.add(chunk) for _ in range(100))
    with pytest.raises(SessionError, match=r"^The disk is full\.$"):
        list(adding)
    with closing(Session(tmp_path / "a.hapkit")) as session:
        assert session.counts[0] == 300
    assert writer.remains.startswith(
        "The earlier samples are in a.hapkit and a.hapkit-wal: keep both. To make one complete file of them, "
    )
    writer.close()
    assert writer.remains == "The earlier samples are in a.hapkit."


@pytest.fixture
def small_disk(tmp_path):
    """Return a file system of 1 MB in memory; skip the test if mounting one is not permitted."""
    place = tmp_path / "small disk"
    place.mkdir()
    mount = shutil.which("mount")
    if (
        mount is None
        or subprocess.run([mount, "-t", "tmpfs", "-o", "size=1m", "tmpfs", place], check=False).returncode
    ):
        pytest.skip("no right to mount")
    yield place
    subprocess.run(["umount", "--lazy", place], check=True)


def test_a_disk_that_fills_up_keeps_the_data_written(small_disk, tmp_path):
    made, path = table(300 * 200), small_disk / "a.hapkit"
    writer, added = SessionWriter(path), []
    chunks = (pack(made[first : first + 300], QUANTUM, 0) for first in range(0, len(made), 300))
    adding = (added.append(writer.add(chunk)) for chunk in chunks)
    with pytest.raises(SessionError, match=r"^The disk is full\.$"):
        list(adding)
    with pytest.raises(SessionError, match=r"^The disk is full\.$"):  # the log cannot be merged into the file
        writer.close()
    assert "a.hapkit-wal" in writer.remains
    session = Session(path)
    assert session.check() == ()
    assert len(added) > 20
    assert np.array_equal(session.read(("tick",))["tick"], made[: 300 * len(added), rows.TICK])
    session.close()
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    with pytest.raises(SessionError, match=r"b\.hapkit cannot be written: Read-only file system\.$"):
        SessionWriter(small_disk / "b.hapkit")
    with closing(Session(path)) as session:
        session.repair(tmp_path / "whole.hapkit")
    with closing(Session(tmp_path / "whole.hapkit")) as whole:
        assert (whole.complete, whole.unfinished, whole.check()) == (True, "", ())
        assert np.array_equal(whole.read(("tick",))["tick"], made[: 300 * len(added), rows.TICK])


# --- a recording was not ended


@pytest.fixture
def killed(tmp_path):
    """Return a folder with the files of a recording whose program was killed, and the recorded rows."""
    made = written(tmp_path / "a.hapkit", close=False)
    folder = tmp_path / "killed"
    folder.mkdir()
    for ending in ("", "-wal", "-shm"):
        shutil.copy(tmp_path / f"a.hapkit{ending}", folder)
    return folder, made


@pytest.fixture
def read_only(tmp_path):
    """Return a function that copies a folder to a file system on which not even root may write.

    The test is skipped if mounting one is not permitted.
    """
    mounted = []

    def make(folder):
        place = tmp_path / "read only"
        if os.geteuid():
            shutil.copytree(folder, place)
            place.chmod(0o555)
            return place
        place.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", place], check=False).returncode:
            pytest.skip("no right to mount")
        mounted.append(place)
        shutil.copytree(folder, place, dirs_exist_ok=True)
        subprocess.run(["mount", "-o", "remount,ro", place], check=True)
        return place

    yield make
    for place in mounted:
        subprocess.run(["umount", "--lazy", place], check=True)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.endswith("-shm")}


@pytest.mark.skipif(os.name == "nt", reason="folders have no such permissions")
@pytest.mark.parametrize("index", [True, False], ids=["with -shm", "without -shm"])
def test_a_killed_recording_opens_from_a_read_only_folder(killed, read_only, tmp_path, monkeypatch, index):
    folder, made = killed
    if not index:
        (folder / "a.hapkit-shm").unlink()
    place = read_only(folder)
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    with closing(Session(place / "a.hapkit")) as session:
        assert np.array_equal(session.read(("tick",))["tick"], made[:, rows.TICK])
        assert session.check() == ()
        one = "To make one complete file, save a copy (in a terminal: hapkit-studio sessions repair)."
        assert (
            session.unfinished
            == f"The recording is incomplete: its newest samples are in a.hapkit-wal. {one}"
        )
        session.repair(tmp_path / "whole.hapkit")
    assert contents(place) == contents(folder)
    assert list((tmp_path / "temporary").iterdir()) == []
    with closing(Session(tmp_path / "whole.hapkit")) as whole:
        assert (whole.unfinished, whole.check()) == ("", ())
        assert np.array_equal(whole.read(("tick",))["tick"], made[:, rows.TICK])
    assert not (tmp_path / "whole.hapkit-wal").exists()


def test_a_killed_recording_with_an_unusable_index_is_read_from_a_copy(killed, monkeypatch):
    """For example, SQLite may lack the permissions that it needs in the folder."""
    folder, made = killed
    connect = database._connect

    def refuse(path, *how):
        if path.parent == folder:
            raise cannot_open
        return connect(path, *how)

    cannot_open = sqlite3.OperationalError("unable to open database file")
    cannot_open.sqlite_errorname = "SQLITE_CANTOPEN"
    monkeypatch.setattr(database, "_connect", refuse)
    with closing(Session(folder / "a.hapkit")) as session:
        assert session.counts.sum() == len(made)
    cannot_open.sqlite_errorname = "SQLITE_IOERR_READ"
    with pytest.raises(SessionError, match=r"^a\.hapkit cannot be read: unable to open database file\.$"):
        Session(folder / "a.hapkit")


def test_reading_a_killed_recording_leaves_no_further_files(killed):
    folder, made = killed
    (folder / "a.hapkit-shm").unlink()
    before = sorted(folder.iterdir())
    with closing(Session(folder / "a.hapkit")) as session:
        assert session.counts.sum() == len(made)
    assert sorted(folder.iterdir()) == before


def test_a_copy_that_would_be_too_large_gives_advice(killed, monkeypatch):
    folder, _ = killed
    (folder / "a.hapkit-shm").unlink()
    monkeypatch.setattr(database, "_MOST_COPIED", 1000)
    with pytest.raises(
        SessionError, match=r"copy it and a\.hapkit-wal into a folder in which you may write\.$"
    ):
        Session(folder / "a.hapkit")


@pytest.mark.parametrize("moved", [0, 3], ids=["all of it was in the log", "some was in the file"])
def test_a_recording_without_its_log_reports_the_loss(tmp_path, moved):
    writer = SessionWriter(tmp_path / "a.hapkit")
    chunks = [pack(part, QUANTUM, 0) for part in np.split(table(1500), 5)]
    for chunk in chunks[:moved]:
        writer.add(chunk)
    if moved:
        writer._database.execute("PRAGMA wal_checkpoint(PASSIVE)")
    for chunk in chunks[moved:]:
        writer.add(chunk)
    path = tmp_path / "copied" / "a.hapkit"
    path.parent.mkdir()
    shutil.copy(tmp_path / "a.hapkit", path)
    if moved:
        with closing(Session(path)) as session:
            assert session.counts.sum() == 900
            assert (
                session.unfinished
                == "The recording is incomplete: its newest samples are lost, because a.hapkit-wal is "
                "missing."
            )
    else:
        with pytest.raises(
            SessionError, match=r"^a\.hapkit has lost its samples, which were in a\.hapkit-wal\.$"
        ):
            Session(path)
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("gone", ["deleted", "moved", "replaced", "with its folder"])
@pytest.mark.skipif(os.name == "nt", reason="Windows keeps open files where they are")
def test_a_file_deleted_during_a_recording_is_detected_and_not_called_saved(tmp_path, gone):
    path = tmp_path / "folder" / "a.hapkit"
    path.parent.mkdir()
    writer, chunk = SessionWriter(path), pack(table(300), QUANTUM, 0)
    writer.add(chunk)
    if gone == "with its folder":
        shutil.rmtree(path.parent)
    else:
        path.rename(tmp_path / "b.hapkit")
    if gone == "replaced":
        path.write_text("mine")
    for write in (lambda: writer.add(chunk), lambda: writer.note(Event(0.0, "marker", {})), writer.close):
        with pytest.raises(SessionError, match=r"^a\.hapkit was deleted or moved while it was written\.$"):
            write()
    assert writer.remains == ""


def test_a_session_written_at_once_is_complete_or_missing(tmp_path):
    chunk = pack(table(300), QUANTUM, 0)

    def fill():
        with SessionWriter.whole(tmp_path / "a.hapkit") as writer:
            writer._database.execute("PRAGMA max_page_count=12")
            for _ in range(100):
                writer.add(chunk)

    with pytest.raises(SessionError, match="The disk is full"):
        fill()
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "b.hapkit").write_text("mine")
    with pytest.raises(SessionError, match="exists already"), SessionWriter.whole(tmp_path / "b.hapkit"):
        pass
    assert (tmp_path / "b.hapkit").read_text() == "mine"


def test_a_repair_without_intact_data_leaves_no_file(tmp_path):
    written(tmp_path / "a.hapkit", 1)
    with sqlite3.connect(tmp_path / "a.hapkit") as damaged:
        damaged.execute("UPDATE chunk SET crc = crc + 1")
    with (
        closing(Session(tmp_path / "a.hapkit")) as session,
        pytest.raises(
            SessionError, match=r"its checksum is wrong\. There are no readable samples to write\.$"
        ),
    ):
        session.repair(tmp_path / "b.hapkit")
    assert not (tmp_path / "b.hapkit").exists()


_RECORD = """
import sys, time, numpy as np
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.sessions.recorder import Recorder
engine = Engine(SimulatedHapkit(), "spring", realtime=False)
engine.start()
recorder = Recorder()
recorder.follow(engine)
recorder.record(sys.argv[1])
reader = engine.reader()
while True:
    time.sleep(0.02)
    new = reader.read()
    if len(new):
        print(new[-1, 1], flush=True)
"""


def lost_by_kill(path, seconds):
    """Return how many seconds of data a recording loses if it is killed after a number of seconds."""
    process = subprocess.Popen([sys.executable, "-c", _RECORD, str(path)], stdout=subprocess.PIPE, text=True)
    lines = [process.stdout.readline()]
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        lines.append(process.stdout.readline())
    process.send_signal(signal.SIGKILL)
    lines += process.stdout.read().split()
    process.wait()
    return float(lines[-1]) - Session(path).stops[-1]


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="no SIGKILL")
def test_a_killed_recording_loses_at_most_half_a_second(tmp_path):
    assert lost_by_kill(tmp_path / "a.hapkit", 1.3) < 0.5
    assert Session(tmp_path / "a.hapkit").check() == ()


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="no SIGKILL")
def test_recordings_killed_at_random_times_lose_at_most_half_a_second(tmp_path):
    chance = random.Random(5)
    lost = [lost_by_kill(tmp_path / f"{n}.hapkit", chance.uniform(0.8, 2.5)) for n in range(15)]
    assert max(lost) < 0.5


@pytest.mark.parametrize("state", ["damaged", "being written"])
def test_no_note_is_added_to_a_damaged_or_unfinished_session(tmp_path, state):
    path = tmp_path / "a.hapkit"
    written(path)
    database = sqlite3.connect(path, isolation_level=None)
    change = "UPDATE chunk SET velocity = x'00'" if state == "damaged" else "PRAGMA journal_mode=WAL"
    database.execute(change)
    before = path.read_bytes()
    with pytest.raises(SessionError, match=r"o note was saved\.$"):
        add_note(path, "a word")
    assert path.read_bytes() == before
    database.close()
    assert not list(tmp_path.glob("*part*"))
