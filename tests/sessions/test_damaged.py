"""Hostile and damaged sessions are listed with the reason, next to intact ones, and never changed."""

import gc
import json
import math
import os
import random
import re
import sqlite3
import sys
import time
import warnings
import zlib
from contextlib import closing, suppress
from pathlib import Path

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import environments
from hapkit_studio.charts.session import draw
from hapkit_studio.charts.style import save
from hapkit_studio.cli import main
from hapkit_studio.errors import FileError, StudioError
from hapkit_studio.gui.live.recorded import Recorded
from hapkit_studio.gui.pages.sessions import read_overviews
from hapkit_studio.haptics import rows
from hapkit_studio.sessions import database, session, settings_events
from hapkit_studio.sessions.chunk import MOST_SAMPLES, pack
from hapkit_studio.sessions.columns import DamagedError, decode, encode
from hapkit_studio.sessions.event_values import checked_event
from hapkit_studio.sessions.file import (
    ABOUT,
    FAULT,
    MARKER,
    NOTE,
    SETTINGS,
    STOP,
    TABLES,
    Event,
    SessionError,
    SessionWriter,
)
from hapkit_studio.sessions.layout import LAYOUT
from hapkit_studio.sessions.overview import overview
from hapkit_studio.sessions.session import Session
from tests.sessions.damaged import BOMB, ESCAPES, HEAD, mutate, set_value
from tests.sessions.test_chunk import QUANTUM, table

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no FIFO in its file system")
EVENTS = {
    ABOUT: {"device": "Simulated Hapkit", "quantum_m": QUANTUM, "studio": "1", "protocol": 3},
    SETTINGS: {
        "environment": "puck", "parameters": {"mass": 0.2, "method": "exact"}, "units": {"mass": "kg"},
        "state_names": ["place", "speed"], "hand": "own", "grip": "firm", "render": "computer",
        "rate_Hz": 1000.0, "delay_s": 0.004, "estimator": ["iir", {"cutoff": 20.0}], "controller": True,
        "max_force_N": 2.0, "device": {"mass": 0.044, "end_stops": "inf"}, "seed": 0,
    },
    STOP: {"stopped": False},
    FAULT: {"text": ""},
    MARKER: {"text": "here"},
    NOTE: {"text": "in the lab"},
}  # fmt: skip
"""Every kind of event with all its possible values, in rows 1 to 6 of the file below."""
CHUNKS = 4


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> bytes:
    """Return the bytes of a session with every kind of event and four chunks."""
    path = tmp_path_factory.mktemp("whole") / "whole.hapkit"
    made = table(100 * CHUNKS)
    begin = made[0, rows.HOST_TIME]
    with SessionWriter.whole(path) as writer:
        for kind, what in EVENTS.items():
            writer.note(Event(begin + 0.1 if kind == MARKER else begin - 1.0, kind, what))
        for part in np.split(made, CHUNKS):
            writer.add(pack(part, QUANTUM, 2))
    return path.read_bytes()


@pytest.fixture
def path(tmp_path, whole) -> Path:
    """Return the path of a file with that session, next to an intact session."""
    (tmp_path / "neighbour.hapkit").write_bytes(whole)
    found = tmp_path / "bad.hapkit"
    found.write_bytes(whole)
    return found


def listed(folder, capsys) -> dict[str, str]:
    """Return each file's line in the command's list; assert that the page lists the same files."""
    assert main(["sessions", "list", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert all(c.isprintable() or c == "\n" for c in out)
    lines = {f"{line.split()[0]}.hapkit": line.partition(" ")[2].strip() for line in out.splitlines()[1:]}
    shown = read_overviews(sorted(folder.glob("*.hapkit")), {}, lambda _done, _of: None)
    assert {row.path.name for row in shown.values()} == set(lines)
    assert all(row.error in lines[row.path.name] for row in shown.values())
    return lines


WRONG_VALUES = [
    ("chunk", 2, "extremes", None, "chunk 2: extremes is NULL; it must be BLOB."),
    ("chunk", 4, "stop", 1e308, "chunk 4: stop is 1e+308; it must be a number from 100"),
    ("chunk", 4, "stop", 9e8, "chunk 4: stop is 900000000.0; it must be a number from 100"),
    ("chunk", 1, "start", -math.inf, "chunk 1: start is -inf; it must be a number from -1e+09 to 1e+09 s."),
    ("chunk", 2, "states", 17, "chunk 2: states is 17; it must be a whole number from 0 to 16."),
    ("event", 1, "what", "[1]", "event 1 is [1]; it must be a table."),
    ("event", 1, "what", "7", "event 1 is 7; it must be a table."),
    ("event", 1, "what", "{", "event 1: Expecting"),
    ("event", 1, "what", "[" * 60_000, "event 1, line 1: brackets are nested deeper than 32."),
    ("event", 1, "what", f'{{"a": {"9" * 9000}}}', "event 1, line 1: a key or number has 9,000 characters"),
    ("event", 1, "what", " " * 70_000, "event 1 has 70,000 characters; the limit is 65,536."),
    ("event", 1, "what", '{"device": 7}', "event 1: device is 7; it must be a line of at most 200 printable"),
    ("event", 1, "what", '{"quantum_m": NaN}', "event 1: quantum_m is nan; it must be a number from 0 to"),
    ("event", 1, "time", math.inf, "event 1: time is inf; it must be a number from -1e+09 to 1e+09 s."),
    ("event", 1, "kind", "a\x1b[2J", "event 1: kind is 'a\\x1b[2J'; it must be a line of at most 40"),
    ("event", 2, "what", '{"parameters": [1]}', "event 2: parameters is [1]; it must be a table."),
    ("event", 2, "what", '{"parameters": {"mass": [1]}}', "event 2: parameters.mass is [1]; it must be a n"),
    ("event", 2, "what", '{"units": null}', "event 2: units is None; it must be a table."),
    ("event", 2, "what", '{"rate_Hz": "fast"}', "event 2: rate_Hz is 'fast'; it must be a number from 1"),
    ("event", 2, "what", '{"rate_Hz": 1e308}', "event 2: rate_Hz is 1e+308; it must be a number from 1"),
    ("event", 2, "what", '{"delay_s": -1}', "event 2: delay_s is -1; it must be a number from 0 to 1,000 s."),
    ("event", 2, "what", '{"state_names": 5}', "event 2: state_names is 5; it must be a list of at most"),
    ("event", 2, "what", '{"estimator": ["iir", 7]}', "event 2: estimator is 7; it must be a table."),
    ("event", 2, "what", '{"controller": "yes"}', "event 2: controller is 'yes'; it must be true or false."),
    ("event", 2, "what", '{"max_force_N": -1}', "event 2: max_force_N is -1; it must be a number from 0"),
    ("event", 2, "what", '{"device": [7]}', "event 2: device is [7]; it must be a table."),
    ("event", 3, "what", '{"stopped": 1}', "event 3: stopped is 1; it must be true or false."),
    ("event", 4, "what", "{}", "event 4: a fault has no text."),
    ("event", 5, "what", '{"text": 7}', "event 5: text is 7; it must be a line of at most 2000 printable"),
    ("event", 6, "what", None, "event 6: what is NULL; it must be TEXT."),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "row", "name", "value", "reason"), WRONG_VALUES)
def test_one_wrong_value_is_reported_with_its_limit_and_the_rest_is_read(
    path, whole, capsys, kind, row, name, value, reason
):
    set_value(path, kind, row, name, value)
    lines = listed(path.parent, capsys)
    assert "damaged" not in lines["neighbour.hapkit"]
    assert f"bad.hapkit is damaged. Skipped: {reason}" in lines["bad.hapkit"]
    with closing(Session(path)) as found:
        assert len(found.read(("tick",))["tick"]) == 100 * (CHUNKS - (kind == "chunk"))
        assert len(found.events) == len(EVENTS) - (kind == "event")
        assert len(found.check()) == 1


@pytest.mark.parametrize(
    ("name", "value"), [("extremes", None), ("stop", 1e308), ("stop", None), ("stop", -1.0), ("count", 2**40)]
)
def test_a_session_without_a_readable_chunk_is_refused_with_the_reason(path, capsys, name, value):
    for row in range(1, CHUNKS + 1):
        set_value(path, "chunk", row, name, value)
    lines = listed(path.parent, capsys)
    assert f"bad.hapkit has no readable samples. chunk 1: {name} is " in lines["bad.hapkit"]
    for action in ("show", "export", "check", "repair"):
        assert main(["sessions", action, str(path)]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert len(list(path.parent.iterdir())) == 2  # no file was exported or repaired


@pytest.mark.parametrize(
    "head", [(8, math.nan, 0), (8, math.inf, 0), (8, 0.0, 0), (8, -1.0, 0), (8, 1e300, 0),
             (8, 1.0, 2**63 - 1), (1, 1.0, -(2**63)), (3, 1.0, 0), (255, 1.0, 0)],
)  # fmt: skip
def test_a_compressed_column_with_an_invalid_head_is_damaged(path, head):
    set_value(path, "chunk", 2, "position", zlib.compress(HEAD.pack(*head) + bytes(head[0] * 99)))
    with closing(Session(path)) as found:
        assert len(found.read(("position",))["position"]) == 100 * (CHUNKS - 1)
        assert "Skipped: chunk 2: Samples cannot be read: " in found.damage[0]
    assert overview(path).damage == found.damage


def test_integers_that_overflow_64_bits_are_damaged():
    bytes_of = np.frombuffer(np.full(9, 2**62, "<i8").tobytes(), np.uint8).reshape(9, 8).T.tobytes()
    with pytest.raises(DamagedError, match="too large"):
        decode(zlib.compress(HEAD.pack(8, 1.0, 0) + bytes_of), 10)


@pytest.mark.parametrize("column", ["time", "tick", "flags"])
def test_times_and_integers_must_be_finite_and_in_order(path, column):
    for values in (np.arange(100.0)[::-1], np.full(100, math.nan), np.full(100, 1e30)):
        set_value(path, "chunk", 2, column, encode(values))
        with closing(Session(path)) as found:
            found.read(("time", "tick", "flags"))
            assert (found.damage != ()) == (column == "time" or not values[0] < 2**53)


def test_non_finite_values_are_exported_unchanged_and_drawn_as_a_gap(path, tmp_path):
    values = np.array([math.nan, math.inf, -math.inf, 3e38, 1.0] * 20)
    for name in ("position", "velocity", "force", "energy", "lateness", "board_time", "compute"):
        set_value(path, "chunk", 2, name, encode(values))
    set_value(path, "chunk", 2, "extremes", encode(np.repeat(values, 4)[: 4 * len(LAYOUT.with_extremes)]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = overview(path)
        assert not np.isinf(found.trace).any()
        save(lambda figure, c: draw(figure, c, found.trace, found.markers), tmp_path / "a.png", (600, 190))
        run = hs.open_session(path)
        assert np.array_equal(run.velocity[100:200], values.astype(np.float32), equal_nan=True)
        with closing(Session(path)) as whole:
            history = Recorded(whole)
            history.move_to(history.stop)
            edges = np.linspace(history.start, history.stop, 50)
            for stretch in (history.window(edges), history.drawn(0, 1e9)):
                assert not any(np.isinf(values).any() for values in stretch.y.values())
            history.complete = False  # an incomplete history is drawn from the extremes of blocks
            assert not any(np.isinf(values).any() for values in history.window(edges).y.values())
    assert found.damage == ()


def test_control_characters_reach_neither_terminal_nor_window(path, capsys):
    text = json.dumps({"text": ESCAPES, "device": ESCAPES}, ensure_ascii=False)
    for row in (1, 5, 6):
        set_value(path, "event", row, "what", text)
    hidden = json.dumps(
        {"environment": ESCAPES, "parameters": {ESCAPES: ESCAPES}, "more": [{ESCAPES: ESCAPES}]}
    )
    set_value(path, "event", 2, "what", hidden)
    assert "\\u001b[2J" in listed(path.parent, capsys)["bad.hapkit"]
    for args in (["show", str(path)], ["show", str(path), "--json"]):
        assert main(["sessions", *args]) == 0
        out = capsys.readouterr().out
        assert "\\u001b[2J" in out
        assert all(c.isprintable() or c == "\n" for c in out)
    found = overview(path)
    shown = [found.device, *found.environments, *found.notes, *(message for _, message in found.markers)]
    assert len(shown) == 4
    assert all(message.isprintable() and "next" in message for message in shown)


def test_a_name_with_control_characters_is_one_line_of_the_list(path, capsys):
    path.rename(path.with_name(f"a{ESCAPES.replace('/', '')}b.hapkit"))
    assert main(["sessions", "list", str(path.parent)]) == 0
    out = capsys.readouterr().out
    assert out.count("\n") == 1 + 2
    assert "\x1b" not in out
    (shown,) = read_overviews([*path.parent.glob("a*")], {}, lambda *_: None).values()
    assert shown.name.isprintable()


def test_the_data_of_a_recording_pass_the_checks():
    """Recordings are made in every environment, with its defaults and with every choice."""
    for environment in environments.discover().values():
        values = environment.values()
        for parameter in environment.parameters:
            for value in (parameter.low, parameter.high):
                values[parameter.key] = value
                what = settings_events.of_scene(environment, values)
                text = json.dumps({**what, "state_names": list(environment.state_names)})
                assert checked_event(text, SETTINGS, "event") == json.loads(text)


def test_names_of_a_later_version_are_kept():
    what = {"text": "a", "colour": "red", "where": {"deep": [1, None, True]}}
    assert checked_event(json.dumps(what), MARKER, "event") == what
    assert checked_event(json.dumps(what), "camera", "event") == what
    with pytest.raises(FileError, match="nested deeper"):
        checked_event('{"a": ' * 40 + "1" + "}" * 40, "camera", "event")


# --- heads that claim more samples than memory or time permit


def heads(path, count, samples):
    """Write chunks with valid heads and empty columns."""
    extremes = encode(np.zeros(2 * len(LAYOUT.with_extremes) * -(-samples // 64)))
    values = [None] * (len(TABLES["chunk"]) - 5)
    with SessionWriter.whole(path) as writer:
        writer._database.execute("BEGIN")
        for number in range(count):
            row = (samples, float(number), number + 0.5, 16, extremes, *values)
            writer._insert("chunk", row)
        writer._database.execute("COMMIT")


def test_a_small_file_cannot_claim_more_samples_than_the_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(session, "_MOST_IN_ALL", 20 * MOST_SAMPLES)
    monkeypatch.setattr(session, "MOST_READ", 10**7)
    heads(tmp_path / "a.hapkit", 25, MOST_SAMPLES)
    assert (tmp_path / "a.hapkit").stat().st_size < 20_000
    with closing(Session(tmp_path / "a.hapkit")) as found:
        assert found.counts.sum() == 20 * MOST_SAMPLES
        assert found.damage == (
            "a.hapkit is damaged. Skipped: chunk 21 and later rows, because at most 1,310,720 samples "
            "can be read.",
        )
        monkeypatch.setattr(found, "chunk", lambda _number: pytest.fail("read"))
        # the values take 8 bytes each
        for names, size in ((("time", "position"), 0.021), (("state",), 0.168)):
            text = f"a.hapkit: 1,310,720 samples take {size:.1f} GB, but at most 0.0 GB can be read at once."
            with pytest.raises(SessionError, match=text):
                found.read(names)


def test_a_compressed_column_never_takes_more_memory_than_its_samples(path):
    set_value(path, "chunk", 2, "state", BOMB)
    set_value(path, "chunk", 3, "position", zlib.compress(b"")[:2] + b"\x00\x00\x00\xff\xff" * 100_000)
    with closing(Session(path)) as found:
        assert len(found.read(("state", "position"))["position"]) == 100 * (CHUNKS - 2)


def test_a_session_whose_columns_are_all_damaged_is_refused_with_the_reason(path):
    for row in range(1, CHUNKS + 1):
        set_value(path, "chunk", row, "position", BOMB)
    with pytest.raises(SessionError, match=r"bad.hapkit is damaged. Skipped: chunk 1: "):
        hs.open_session(path)


def test_a_value_larger_than_any_chunk_is_not_read(path):
    set_value(path, "chunk", 2, "velocity", bytes(database._LONGEST_VALUE + 1))
    with closing(Session(path)) as found:
        assert len(found.read(("velocity",))["velocity"]) == 100 * (CHUNKS - 1)
        assert "string or blob too big" in found.damage[0]


def test_a_value_is_checked_again_if_only_its_type_changes(tmp_path):
    """Python considers 1 equal to True, but a flag in a file must be true or false."""
    path, made = tmp_path / "flags.hapkit", table(100)
    with SessionWriter.whole(path) as writer:
        for flag in (True, True, 1, False, 0, True):
            writer.note(Event(made[1, rows.HOST_TIME], STOP, {"stopped": flag}))
        writer.add(pack(made, QUANTUM, 0))
    with closing(Session(path)) as found:
        assert [event.what["stopped"] for event in found.events] == [True, True, False, True]
        assert all(isinstance(event.what["stopped"], bool) for event in found.events)
        assert "event 3: stopped is 1; it must be true or false" in found.damage[0]


def test_equal_settings_are_stored_once(tmp_path):
    path, made = tmp_path / "same.hapkit", table(100)
    with SessionWriter.whole(path) as writer:
        for stiffness in (1.0, 2.0):
            settings = {"parameters": {"stiffness": stiffness}, "units": {"stiffness": "N/m"}}
            writer.note(Event(made[1, rows.HOST_TIME], SETTINGS, settings))
        writer.add(pack(made, QUANTUM, 0))
    with closing(Session(path)) as found:
        first, second = (event.what for event in found.events)
    assert first["units"] is second["units"]
    assert [first["parameters"]["stiffness"], second["parameters"]["stiffness"]] == [1.0, 2.0]


def test_events_beyond_the_limit_are_skipped(path, monkeypatch):
    monkeypatch.setattr(session, "_MOST_EVENTS", 5)
    with closing(Session(path)) as found:
        assert len(found.events) == 5
        assert "Skipped: event 6 and later rows, because at most 5 events" in found.damage[0]
    monkeypatch.setattr(session, "_MOST_EVENTS", 100)
    monkeypatch.setattr(session, "_MOST_TEXT", 100)
    with closing(Session(path)) as found:
        assert "Skipped: event 2 and later rows" in found.damage[0]
    monkeypatch.undo()
    monkeypatch.setattr(session, "MOST_MARKERS", 1)
    with SessionWriter.whole(path.with_name("marked.hapkit")) as writer:
        made = table(100)
        for text in ("a", "b"):
            writer.note(Event(made[1, rows.HOST_TIME], MARKER, {"text": text}))
        writer.add(pack(made, QUANTUM, 0))
    assert [text for _, text in overview(path.with_name("marked.hapkit")).markers] == ["a"]


def test_damaged_rows_beyond_the_limit_end_the_reading(path, monkeypatch):
    for row in range(1, 7):
        set_value(path, "event", row, "what", "[1]")
    monkeypatch.setattr(session, "_MOST_DAMAGED", 4)
    with closing(Session(path)) as found:
        assert len(found._damaged) == 4
        assert len(found.counts) == 1


def circular(path) -> bytes:
    """Return a session whose table of events has pages that all refer to the rows of the first page."""
    with SessionWriter.whole(path) as writer:
        writer._database.execute("BEGIN")
        for _ in range(500):
            writer.note(Event(0.0, MARKER, {"text": "x" * 30}))
        writer._database.execute("COMMIT")
        writer.add(pack(table(100), QUANTUM, 0))
    with closing(sqlite3.connect(path)) as found:
        (root,) = found.execute("SELECT rootpage FROM sqlite_master WHERE name = 'event'").fetchone()
        (size,) = found.execute("PRAGMA page_size").fetchone()
    data = bytearray(path.read_bytes())
    begin = (root - 1) * size
    kind, count = data[begin], int.from_bytes(data[begin + 3 : begin + 5], "big")
    assert (kind, count > 1) == (5, True)  # this is an interior page of a table, see SQLite's file format
    cells = [begin + int.from_bytes(data[begin + 12 + 2 * k :][:2], "big") for k in range(count)]
    for cell in cells[1:]:
        data[cell : cell + 4] = data[cells[0] : cells[0] + 4]
    return bytes(data)


def test_pages_that_refer_back_to_earlier_rows_end_the_reading(tmp_path):
    path = tmp_path / "a.hapkit"
    path.write_bytes(circular(tmp_path / "b.hapkit"))
    with closing(Session(path)) as found:
        assert 10 < len(found.events) < 500
        assert "and later rows, because they are not in order." in found.damage[0]


def test_a_schema_that_takes_too_long_to_read_is_refused(path, monkeypatch):
    with closing(sqlite3.connect(path, isolation_level=None)) as foreign:
        foreign.execute("BEGIN")
        for number in range(50):
            foreign.execute(f"CREATE TABLE t{number} (a)")
        foreign.execute("COMMIT")
    monkeypatch.setattr(database, "_STEPS", 200)
    with pytest.raises(SessionError, match=r"bad\.hapkit cannot be read: interrupted\."):
        Session(path)
    monkeypatch.undo()
    with pytest.raises(SessionError, match=r"bad\.hapkit is not a session of Hapkit Studio\."):
        Session(path)


@POSIX
def test_files_that_would_block_or_are_not_regular_are_refused(path, capsys):
    os.mkfifo(path.with_name("fifo.hapkit"))
    path.with_name("folder.hapkit").mkdir()
    os.mkfifo(f"{path}-wal")
    lines = listed(path.parent, capsys)
    assert lines["fifo.hapkit"].endswith("fifo.hapkit: it is a device or a pipe, not a file.")
    assert "Cannot read" in lines["folder.hapkit"]
    assert lines["bad.hapkit"].endswith(
        "bad.hapkit-wal is a folder or a device, not a file, so it cannot be read."
    )
    assert "neighbour.hapkit" in lines


def test_a_rollback_journal_is_never_applied(path):
    """A journal may name any file, which SQLite would then delete."""
    path.with_name(f"{path.name}-journal").write_bytes(b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7" + bytes(1000))
    with pytest.raises(SessionError, match=r"bad\.hapkit-journal next to it shows that"):
        Session(path)


# --- random damage


def replayed(path) -> None:
    """Prepare a replay; each Recorded takes 80 MB, which only garbage collection releases."""
    with closing(Session(path)) as found:
        history = Recorded(found)
        for time in (history.start, history.stop):
            history.move_to(time)
            history.settings(), history.row(), history.clamped_since(time - 0.1), history.at(time)
            history.window(np.linspace(history.start, history.stop, 100))
    del history
    gc.collect()


@pytest.mark.slow
def test_sessions_with_one_changed_value_are_read_or_refused_and_others_are_listed(path, whole, capsys):
    """The test has 100 files, each with its own seed."""
    files = {}
    for seed in range(100):
        file = path.with_name(f"{seed}.hapkit")
        file.write_bytes(whole)
        mutate(file, random.Random(seed))
        files[file] = file.read_bytes()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lines = listed(path.parent, capsys)
        for file in list(files)[::4]:
            for read in (overview, hs.open_session):
                with suppress(StudioError):
                    read(file)
        for file in list(files)[::25]:
            with suppress(StudioError):
                replayed(file)
    assert len(lines) == len(files) + 2
    assert re.fullmatch(
        r"Puck +Simulated Hapkit +in the lab, here +[-\d]+ [:\d]+ +0:00 +\d+ kB", lines["neighbour.hapkit"]
    )
    bad = "damaged", "cannot be read", "can be read", "not a session", "newer studio"
    assert sum(any(word in line for word in bad) for line in lines.values()) > 50
    assert all(file.read_bytes() == data for file, data in files.items())
    assert len(list(path.parent.iterdir())) == len(files) + 2


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_many_sessions_with_one_changed_value_go_through_every_command(path, whole, capsys, part):
    """400 files cause no traceback, no hang and no control characters, and repaired files are intact."""
    whole_file = path.with_name("repaired.hapkit")
    for seed in range(1000 + 100 * part, 1100 + 100 * part):
        path.write_bytes(whole)
        what = mutate(path, random.Random(seed))
        before, begin = path.read_bytes(), time.process_time()
        for args in (
            ["list", str(path.parent)],
            ["show", str(path)],
            ["check", str(path)],
            ["show", str(path), "--json"],
            ["export", str(path), "--output", str(path.with_name("a.csv"))],
            ["repair", str(path), "--output", str(whole_file)],
        ):
            assert main(["sessions", *args]) in (0, 2), (seed, what)
        if whole_file.exists():
            assert main(["sessions", "check", str(whole_file)]) == 0, (seed, what)
            whole_file.unlink()
        path.with_name("a.csv").unlink(missing_ok=True)
        if seed % 10 == 0:
            with suppress(StudioError):
                replayed(path)
        printed = "".join(capsys.readouterr())
        assert all(c.isprintable() or c == "\n" for c in printed), (seed, what)
        assert path.read_bytes() == before
        assert time.process_time() - begin < 5.0, (seed, what)
