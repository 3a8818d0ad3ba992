"""The summary of a session agrees with synthetic samples."""

import numpy as np
import pytest

from hapkit_studio.haptics import rows
from hapkit_studio.sessions import overview as module
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.file import ABOUT, MARKER, SETTINGS, Event, SessionWriter
from hapkit_studio.sessions.overview import overview
from tests.sessions.test_chunk import QUANTUM


def motion(seconds, start=100.0):
    """Return rows of a ramp of 1 mm/s at 1 kHz, with one sample at 30 mm in the middle."""
    count = round(1000 * seconds)
    table = np.zeros((count, rows.ROW_WIDTH))
    table[:, rows.TICK], table[:, rows.HOST_TIME] = np.arange(count), start + 1e-3 * np.arange(count)
    table[:, rows.POSITION] = 1e-6 * np.arange(count)
    table[count // 2, rows.POSITION] = 0.03
    return table


def write(path, *parts):
    writer = SessionWriter(path)
    first = parts[0][0, rows.HOST_TIME]
    writer.note(Event(first - 5.0, ABOUT, {"device": "Simulated Hapkit"}))
    for after, key in ((-1.0, "wall"), (0.5, "spring"), (0.7, "wall")):
        writer.note(Event(first + after, SETTINGS, {"environment": key}))
    writer.note(Event(first - 2.0, MARKER, {"text": "before it began"}))
    writer.note(Event(first + 0.25, MARKER, {"text": "a quarter"}))
    for part in parts:
        for begin in range(0, len(part), 300):
            writer.add(pack(part[begin : begin + 300], QUANTUM, 0))
    writer.close()


@pytest.mark.parametrize("few", [10**6, 0], ids=["samples", "blocks"])
def test_the_trace_has_the_extremes_at_their_times_and_keeps_a_gap(tmp_path, monkeypatch, few):
    monkeypatch.setattr(module, "_FEW", few)
    before, after = motion(4.0), motion(4.0, 110.0)
    write(tmp_path / "a.hapkit", before, after)
    time, least, greatest = overview(tmp_path / "a.hapkit").trace
    width = time[1] - time[0]
    assert len(time) <= 1000
    assert width <= (0.05 if few else 0.3)  # a block is 64 ms long
    assert np.nanmax(greatest) == pytest.approx(0.03, abs=QUANTUM)
    peaks = time[greatest > 0.02]
    assert [np.abs(peaks - at).min() <= width + 0.064 for at in (2.0, 12.0)] == [True, True]
    assert len(peaks) == 2
    gap = (time > 4.0 + width) & (time < 10.0 - width)
    assert gap.any()
    assert np.isnan(least[gap]).all()
    ramp = (time > 0.1) & (time < 3.9)
    assert not np.isnan(least[ramp]).any()
    assert np.abs(least[ramp] - 1e-3 * time[ramp]).max() < 1e-3 * (width + 0.064) + QUANTUM


def test_environments_markers_and_changes_are_those_of_the_session(tmp_path):
    write(tmp_path / "a.hapkit", motion(1.0))
    found = overview(tmp_path / "a.hapkit")
    assert (found.device, found.environments) == ("Simulated Hapkit", ("wall", "spring"))
    assert [text for _, text in found.markers] == ["a quarter"]
    assert found.markers[0][0] == pytest.approx(0.25)
    assert [text for _, text in found.changes] == ["environment wall → spring", "environment spring → wall"]
    assert [when for when, _ in found.changes] == pytest.approx([0.5, 0.7])
    assert (found.samples, found.size) == (1000, (tmp_path / "a.hapkit").stat().st_size)
    assert found.seconds == pytest.approx(0.999)


def test_a_foreign_file_is_reported_as_one(tmp_path):
    (tmp_path / "a.hapkit").write_text("a letter")
    found = overview(tmp_path / "a.hapkit")
    assert found.error == "a.hapkit is not a session of Hapkit Studio."
    assert found.trace.shape == (3, 0)
