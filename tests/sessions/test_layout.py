"""Sessions stay readable if the studio's signals change, because each file contains its layout."""

import shutil
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.gui.live.recorded import Recorded
from hapkit_studio.haptics import rows
from hapkit_studio.sessions.chunk import BLOCK, pack
from hapkit_studio.sessions.columns import DamagedError, encode
from hapkit_studio.sessions.file import SETTINGS, Event, SessionWriter
from hapkit_studio.sessions.layout import LAYOUT, Layout, StoredSignal, checked_layout
from hapkit_studio.sessions.overview import overview
from hapkit_studio.sessions.session import Session, add_note
from tests.sessions.test_chunk import QUANTUM, table

OLD = Path(__file__).with_name("version_1.hapkit")
"""A file by the last studio whose files had no layout: 130 samples at 1 kHz, see ``old_motion``."""
WARMER = Layout((StoredSignal("temperature", "K", "", 1), *LAYOUT.signals))
"""A layout with an additional signal, whose extremes come first."""


def write(path, made, layout=LAYOUT, more=()):
    """Write rows as one chunk with a layout; ``more`` has values of signals unknown to the studio."""
    chunk = pack(made, QUANTUM, 0)
    extremes = [chunk.blocks()[LAYOUT.with_extremes.index(n)] for n in layout.with_extremes if n not in more]
    for values in dict(more).values():
        blocks = np.split(values, range(BLOCK, len(values), BLOCK))
        extremes.insert(0, np.array([[b.min() for b in blocks], [b.max() for b in blocks]]))
    columns = {**chunk.columns, **{name: encode(values) for name, values in dict(more).items()}}
    with SessionWriter.whole(path, layout) as writer:
        writer.note(Event(made[0, rows.HOST_TIME] - 1.0, SETTINGS, {"environment": "free", "parameters": {}}))
        writer.add(replace(chunk, columns=columns, extremes=encode(np.ravel(extremes)), layout=layout))


def test_a_file_with_an_unknown_signal_is_read_and_repaired(tmp_path):
    made, warm = table(300), np.linspace(290.0, 300.0, 300)
    write(tmp_path / "a.hapkit", made, WARMER, {"temperature": warm})
    with closing(Session(tmp_path / "a.hapkit")) as session:
        session.repair(tmp_path / "b.hapkit")
    add_note(tmp_path / "b.hapkit", "a word")
    for path in (tmp_path / "a.hapkit", tmp_path / "b.hapkit"):
        with closing(Session(path)) as session:
            found = session.read(("temperature", "velocity", "applied_force"))
            np.testing.assert_allclose(found["temperature"], warm, rtol=1e-7)
            np.testing.assert_allclose(found["velocity"], made[:, rows.VELOCITY], rtol=1e-7)
            np.testing.assert_allclose(found["applied_force"], made[:, rows.APPLIED_FORCE], atol=1e-6)
            assert session.check() == ()
        np.testing.assert_allclose(hs.open_session(path).position, made[:, rows.POSITION], atol=1e-12)
        trace = overview(path).trace
        assert np.nanmax(trace[2]) == pytest.approx(made[:, rows.POSITION].max())


def test_a_file_without_a_signal_of_the_studio_is_read_with_nan(tmp_path):
    made, left_out = table(300), ("energy", "lateness")
    less = Layout(tuple(signal for signal in LAYOUT.signals if signal.name not in left_out))
    write(tmp_path / "a.hapkit", made, less)
    with closing(Session(tmp_path / "a.hapkit")) as session:
        found = session.read((*left_out, "velocity"))
        assert all(np.isnan(found[name]).all() for name in left_out)
        np.testing.assert_allclose(found["velocity"], made[:, rows.VELOCITY], rtol=1e-7)
        assert session.check() == ()
        history = Recorded(session)
        history.move_to(history.stop)
        for complete in (True, False):
            history.complete = complete
            window = history.window(np.linspace(history.start, history.stop, 7))
            assert np.isfinite(window.known().y["velocity"]).all()
    assert np.isnan(hs.open_session(tmp_path / "a.hapkit").energy).all()


def test_a_file_of_version_1_is_read_exported_annotated_and_repaired(tmp_path):
    k = np.arange(130)
    force = 0.25 * (k - 65)
    shutil.copy(OLD, tmp_path / "old.hapkit")
    with closing(Session(tmp_path / "old.hapkit")) as session:
        session.repair(tmp_path / "new.hapkit")
        assert session.markers == ((100.05, "here"),)
    for path in (tmp_path / "old.hapkit", tmp_path / "new.hapkit"):
        add_note(path, "a word")
        run = hs.open_session(path)
        np.testing.assert_allclose(run.time, 1e-3 * k, atol=1e-9)
        np.testing.assert_allclose(run.position, 20e-6 * (k - 65), atol=1e-12)
        np.testing.assert_allclose(run.force, force, rtol=1e-7)
        np.testing.assert_allclose(run.applied_force, np.clip(force, -3.0, 3.0), rtol=1e-6)
        np.testing.assert_allclose(run.energy, 1e-3 * k, rtol=1e-7)
        np.testing.assert_array_equal(run.flags, rows.CLAMPED * (np.abs(force) > 3.0))
        np.testing.assert_array_equal(run.state[:, 0], k)
        assert run.hand_force == pytest.approx(0.5)
        run.save(path.with_suffix(".csv"))
        text = path.with_suffix(".csv").read_text(encoding="utf-8")
        header = next(line for line in text.splitlines() if not line.startswith("#"))
        assert header == (
            "time_s,position_m,velocity_m_per_s,true_position_m,true_velocity_m_per_s,force_asked_N,"
            "force_applied_N,hand_force_N,energy_J,flags,hand_target_m,state.n"
        )
        with closing(Session(path)) as session:
            assert session.notes == ("a word",)
            history = Recorded(session)
            history.move_to(100.0905)
            assert history.latest()["force"] == pytest.approx(0.25 * 25)
            assert history.latest()["applied_force"] == pytest.approx(3.0)


@pytest.mark.parametrize(
    "signals",
    [
        [("time", "s", "", 0, 0), ("time", "s", "", 0, 0)],
        [("time", "s", "", 0, 0), ("crc", "", "", 0, 0)],
        [("time", "s", "", 0, 0), ("a b", "", "", 0, 0)],
        [("time", "s", "", 0, 0), ("x); DROP TABLE event; --", "", "", 0, 0)],
        [("time", "s", "later", 0, 0), ("later", "s", "", 0, 0)],
        [("time", "s", "time", 0, 0)],
        [("time", "s", "", 2, 0)],
        [("time", b"s", "", 0, 0)],
        [("time", "s" * 21, "", 0, 0)],
        [("time", "s", "", 0, 0), *((f"x{i}", "", "", 0, 0) for i in range(64))],
        [("position", "m", "", 0, 0)],
        [],
    ],
)
def test_an_inconsistent_layout_is_refused(signals):
    with pytest.raises(DamagedError, match=r"^the list of its signals has "):
        checked_layout(signals)


def test_a_run_saved_as_a_session_has_no_energies_of_the_observer(tmp_path):
    hs.simulate("spring", seconds=0.2).save(tmp_path / "a.hapkit")
    with closing(Session(tmp_path / "a.hapkit")) as session:
        found = session.read(("energy_given", "energy_limit"))
    assert np.isnan([*found.values()]).all()
