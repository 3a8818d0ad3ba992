"""Export from the Live view writes exact samples of the range, and settings; a file is complete or absent."""

import csv
import json
import math
import re
import time
from datetime import datetime, timedelta
from types import SimpleNamespace

import numpy as np
import pytest
from pyarrow import parquet
from PySide6.QtGui import QGuiApplication, QImage
from scipy.io import loadmat

from hapkit_studio.charts import run as charts
from hapkit_studio.gui.live import export
from hapkit_studio.gui.pages.sessions import COMMA
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import telemetry

COLUMNS = {
    "position_m": rows.POSITION,
    "velocity_m_per_s": rows.VELOCITY,
    "force_asked_N": rows.FORCE,
    "force_applied_N": rows.APPLIED_FORCE,
}


@pytest.fixture
def fed(reset_window):
    """Return the window with 5 s of known samples, and a copy of the samples."""
    window = reset_window
    window.live.tick()
    window.live.history.clear()
    table = telemetry(5000, start=7)
    window.live.history.append(table)
    window.centre.time.refresh()
    yield window, table.copy()
    window.centre.time.cursors.show(False)
    window.live.history.clear()


@pytest.fixture
def write(fed, qtbot, monkeypatch):
    """Return a function that exports a range to a file as the dialog does, and returns the message."""
    window, _ = fed

    def written(path, stretch, kind="Table (*.csv)"):
        chosen = SimpleNamespace(selectedNameFilter=lambda: kind)
        asked = []
        monkeypatch.setattr(export, "choose_file", lambda *given, **_: asked.append(given[3]) or chosen)
        heard = []
        connections = [s.connect(heard.append) for s in (window.export.succeeded, window.export.failed)]
        window.export.ask(stretch)
        for save in asked:
            save(str(path))
        qtbot.waitUntil(lambda: bool(heard))
        for signal, one in zip((window.export.succeeded, window.export.failed), connections, strict=True):
            signal.disconnect(one)
        return heard[0]

    return written


def read(path, between=","):
    """Return settings and columns of a CSV file, parsed independently."""
    lines = path.read_text("utf-8").splitlines()
    header = dict(line.removeprefix("# ").split(": ", 1) for line in lines if line.startswith("# "))
    head, *rows = list(csv.reader(lines[len(header) :], delimiter=between))
    table = [[float(word.replace(",", ".")) for word in row] for row in rows]
    return header, dict(zip(head, np.array(table).T, strict=True))


def of(table, start, stop):
    return table[(table[:, rows.HOST_TIME] >= start) & (table[:, rows.HOST_TIME] < stop)]


@pytest.mark.parametrize(("kind", "between"), [("Table (*.csv)", ","), (COMMA, ";")])
def test_a_table_contains_exactly_the_samples_of_its_range(fed, write, tmp_path, kind, between):
    window, table = fed
    assert write(tmp_path / "a.csv", (2.0, 3.5), kind) == "The file a.csv was saved"
    settings, columns = read(tmp_path / "a.csv", between)
    expected = of(table, 2.0, 3.5)
    assert list(columns)[1:5] == list(COLUMNS)
    for name, place in COLUMNS.items():
        np.testing.assert_allclose(columns[name], expected[:, place], rtol=2.0**-24, atol=0.0)
    np.testing.assert_allclose(columns["time_s"], expected[:, rows.HOST_TIME] - 2.0, atol=1e-9)
    assert settings["environment"] == "wall"
    assert settings["stiffness"] == f"{window.studio.values['stiffness']:g} N/m"
    assert settings["rate"] == "1000 Hz"


def test_a_parquet_file_contains_the_same_samples_and_settings(fed, write, tmp_path):
    assert write(tmp_path / "a.parquet", (2.0, 3.5), "Parquet (*.parquet)") == "The file a.parquet was saved"
    found, expected = parquet.read_table(tmp_path / "a.parquet"), of(fed[1], 2.0, 3.5)
    for name, place in COLUMNS.items():
        np.testing.assert_array_equal(found[name].to_numpy(), expected[:, place])
    np.testing.assert_allclose(found["time_s"].to_numpy(), expected[:, rows.HOST_TIME] - 2.0, atol=1e-9)
    settings = json.loads(found.schema.metadata[b"settings"])
    assert settings["parameters"]["stiffness"] == fed[0].studio.values["stiffness"]


def test_the_ranges_are_visible_between_cursors_and_all(fed, write, tmp_path):
    window, table = fed
    time = window.centre.time
    window.centre.view.set_paused(True)
    time.canvases[-1].view.setXRange(-3.0, -1.0, padding=0)
    time.refresh()
    cursors = time.cursors
    cursors.show(True)
    cursors.move(0, 4.0005)
    cursors.move(1, 1.5005)
    ranges = {"visible": window.export.visible, "selection": window.export.selected}
    ranges["all"] = (-math.inf, math.inf)
    count = {}
    for name, stretch in ranges.items():
        write(tmp_path / f"{name}.csv", stretch)
        count[name] = len(read(tmp_path / f"{name}.csv")[1]["time_s"])
    window.centre.view.set_paused(False)
    assert count == {"visible": pytest.approx(2000, abs=3), "selection": 2501, "all": len(table)}


def test_the_settings_at_the_start_and_all_changes_in_the_range_are_written(fed, write, tmp_path):
    """Changes after the range are not written."""
    window, _ = fed
    window.export._settings.clear()
    scene = {"environment": "wall", "units": {"stiffness": "N/m"}}
    window.export._settings.extend([
        (1.0, {**scene, "parameters": {"stiffness": 300.0}}),
        (2.5, {**scene, "parameters": {"stiffness": 800.0}}),
        (2.5, {**scene, "parameters": {"stiffness": 800.0}}),
        (3.0, {**scene, "parameters": {"stiffness": 850.0}}),
        (4.5, {"environment": "spring", "parameters": {}}),
    ])  # fmt: skip
    write(tmp_path / "a.csv", (2.0, 4.0))
    settings, _ = read(tmp_path / "a.csv")
    assert settings == {
        "environment": "wall",
        "stiffness": "300 N/m",
        "stiffness at 0.5 s": "800 N/m",
        "stiffness at 1 s": "850 N/m",
    }
    write(tmp_path / "a.mat", (2.0, 4.0))
    write(tmp_path / "a.parquet", (2.0, 4.0), "Parquet (*.parquet)")
    found = [
        loadmat(tmp_path / "a.mat")["settings"].item(),
        parquet.read_metadata(tmp_path / "a.parquet").metadata[b"settings"],
    ]
    for settings in map(json.loads, found):
        assert settings["parameters"] == {"stiffness": 300.0}
        assert settings["changes"] == [
            {"time_s": 0.5, "parameters": {"stiffness": 800.0}},
            {"time_s": 1.0, "parameters": {"stiffness": 850.0}},
        ]


def test_a_change_while_the_loop_runs_is_exported_with_its_time_and_drawn(
    fed, write, qtbot, tmp_path, monkeypatch
):
    studio, live = fed[0].studio, fed[0].live
    live.tick()
    live.history.clear()
    begun = time.perf_counter()
    qtbot.waitUntil(lambda: live.tick() or live.history.now > begun + 0.1)
    studio.set_value("stiffness", 600.0)
    changed = time.perf_counter()
    qtbot.waitUntil(lambda: live.tick() or live.history.now > changed + 0.1)
    captions = []
    monkeypatch.setattr(charts, "save", lambda *given, caption: captions.append(caption))
    write(tmp_path / "a.csv", (begun, changed + 0.1))
    write(tmp_path / "a.png", (begun, changed + 0.1))
    settings, columns = read(tmp_path / "a.csv")
    assert settings["stiffness"] == "250 N/m"
    (when,) = [name for name in settings if name.startswith("stiffness at ")]
    assert settings[when] == "600 N/m"
    zero = changed - (live.history.between(begun, changed).x[0])
    assert float(when.split()[2]) == pytest.approx(zero, abs=0.1)
    assert 0.0 < float(when.split()[2]) < columns["time_s"][-1]
    scene, conditions, change = captions[0].replace("\N{NO-BREAK SPACE}", " ").split("\n")
    assert scene.startswith("Wall: stiffness 250 N/m")
    today = datetime.now() - timedelta(seconds=time.perf_counter() - begun)
    assert any(f"{today + timedelta(minutes=n):%Y-%m-%d %H:%M}" in conditions for n in (-1, 0, 1))
    assert re.fullmatch(r"At \d\.\d\d s: stiffness 250 → 600 N/m", change)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "begins"), [("a.png", b"\x89PNG"), ("a.pdf", b"%PDF"), ("a.svg", b"<?xml"), ("a.mat", b"MATLAB")]
)
def test_the_file_extension_selects_the_format_and_no_other_file_remains(fed, write, tmp_path, name, begins):
    folder = tmp_path / "there"
    folder.mkdir()
    assert write(folder / name, (1.0, 2.0)) == f"The file {name} was saved"
    assert [path.name for path in folder.iterdir()] == [name]
    assert (folder / name).read_bytes().startswith(begins)


def test_a_failed_export_shows_one_line_and_keeps_the_old_file(fed, write, tmp_path, monkeypatch):
    kept = tmp_path / "there" / "kept.csv"
    kept.parent.mkdir()
    kept.write_text("mine")
    assert (
        write(tmp_path / "none" / "a.csv", (1.0, 2.0))
        == "The file a.csv cannot be written: No such file or directory."
    )
    assert write(kept.with_suffix(".xyz"), (1.0, 2.0)).startswith(
        "The file name must end in .png, .svg, .pdf, .csv"
    )
    assert write(kept, (90.0, 91.0)) == "There are no samples in this range."

    def full(path, *_):
        path.write_text("half")
        raise OSError(28, "No space left on device")

    monkeypatch.setitem(export.export.WRITERS, ".csv", full)
    assert write(kept, (1.0, 2.0)) == "The file kept.csv cannot be written: No space left on device."
    assert [path.read_text() for path in kept.parent.iterdir()] == ["mine"]


@pytest.mark.slow
def test_a_copied_picture_equals_the_exported_one(fed, write, tmp_path, qtbot):
    window, _ = fed
    write(tmp_path / "a.png", window.export.visible)
    with qtbot.waitSignal(window.export.succeeded):
        window.actions_by_key.run("session.copy_picture")
    copied = QGuiApplication.clipboard().image().convertToFormat(QImage.Format.Format_RGB32)
    assert copied == QImage(str(tmp_path / "a.png")).convertToFormat(QImage.Format.Format_RGB32)


def test_a_picture_shows_the_current_law_over_the_plotted_quantity(fed, write, tmp_path, monkeypatch):
    phase, given = fed[0].centre.phase, []
    monkeypatch.setattr(charts, "run_figure", lambda *args: given.append(args[4:]))
    for index, over in ((0, "position"), (1, "velocity"), (2, "")):
        phase.choose(index)
        write(tmp_path / "a.png", (1.0, 2.0))
        known, shown = given[-1]
        assert known["wall"] is fed[0].studio.environment
        assert shown == over
    phase.choose(0)
