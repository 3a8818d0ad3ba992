"""Recordings are read from the studio's files, from copies saved by a spreadsheet, and from other files."""

import csv
import io
import json
import os

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import api
from hapkit_studio.analysis.identify import identify
from hapkit_studio.cli import main
from hapkit_studio.errors import ParameterError
from hapkit_studio.tables import TableColumn, UnknownColumnsError
from tests.sessions.test_export import session  # noqa: F401


@pytest.fixture(scope="module")
def run():
    return hs.simulate("spring", {"stiffness": 300.0}, hand="shake", seconds=3.0)


@pytest.fixture(scope="module")
def own(run, tmp_path_factory):
    """Return the folder of a run that the studio has written."""
    folder = tmp_path_factory.mktemp("own")
    run.save(folder / "plain.csv")
    run.save(folder / "comma.csv", decimal=",")
    run.save(folder / "session.hapkit")
    return folder


def resaved(text, read, write, end="\r\n"):
    """Return a table that was read with one delimiter and written with another.

    All rows are padded to the width of the widest.
    """
    rows = list(csv.reader(io.StringIO(text), delimiter=read))
    width = max(map(len, rows))
    file = io.StringIO()
    csv.writer(file, delimiter=write, lineterminator=end).writerows(
        row + [""] * (width - len(row)) for row in rows
    )
    return file.getvalue() + write * (width - 1) + end


def old(run, text):
    """Return the text in the studio's former format, with all settings in one line of JSON."""
    table = [line for line in text.splitlines() if not line.startswith("#")]
    return "\n".join([f"# {json.dumps(run.settings, ensure_ascii=False)}", *table]) + "\n"


SAVED = {
    "plain": lambda plain, comma, run: plain.encode(),
    "decimal comma": lambda plain, comma, run: comma.encode(),
    "byte-order mark": lambda plain, comma, run: b"\xef\xbb\xbf" + comma.encode(),
    "spreadsheet": lambda plain, comma, run: resaved(comma, ";", ";").encode("cp1252"),
    "spreadsheet, points": lambda plain, comma, run: resaved(plain, ",", ";").encode("utf-8-sig"),
    "spreadsheet, commas in quotes": lambda plain, comma, run: resaved(comma, ";", ",").encode(),
    "spreadsheet, tabs": lambda plain, comma, run: resaved(comma, ";", "\t").encode("utf-16"),
    "old": lambda plain, comma, run: old(run, plain).encode(),
    "old, byte-order mark": lambda plain, comma, run: b"\xef\xbb\xbf" + old(run, plain).encode(),
    "old, decimal comma": lambda plain, comma, run: old(run, comma).encode(),
    "old, spreadsheet": lambda plain, comma, run: resaved(old(run, plain), ",", ";").encode("utf-8-sig"),
    "old, decimal comma, spreadsheet": lambda plain, comma, run: resaved(old(run, comma), ";", ";").encode(),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("way", [*SAVED, "session"])
def test_resaved_studio_files_give_the_same_result(own, run, way, tmp_path, capsys):
    path = own / "session.hapkit"
    if way != "session":
        path = tmp_path / "saved.csv"
        plain, comma = ((own / name).read_text(encoding="utf-8") for name in ("plain.csv", "comma.csv"))
        path.write_bytes(SAVED[way](plain, comma, run))
    assert main(["identify", str(path)]) == 0
    text = capsys.readouterr().out
    assert "Stiffness: you set 300 N/m, the device gave 300.0 ± 0.1 N/m." in text
    assert "Mass: 44 g of the handle and 100 g of the hand, identified 144.0 ± 0.2 g." in text


def test_a_hands_own_script_is_stored_by_a_session_and_by_a_table(tmp_path):
    hand = hs.Hand(
        0.05, 4.0, 200.0, lambda t: 0.01 * np.sin(9.0 * t) + 0.003 * np.sin(31.0 * t), vectorised=True
    )
    run = hs.simulate("spring", {"stiffness": 150.0}, hand=hand, seconds=2.0)
    run.save(tmp_path / "a.csv")
    run.save(tmp_path / "a.hapkit")
    masses = [identify(api.open_recording(tmp_path / name)).handle["mass"] for name in ("a.csv", "a.hapkit")]
    assert masses[0].value == pytest.approx(0.094, abs=0.005)
    assert masses[1].value == pytest.approx(masses[0].value, abs=1e-4)


# --- the settings change during a recording


def stiffness_of(found):
    return found["parts"]["rendered"]["estimates"][0]


@pytest.mark.parametrize("ending", ["hapkit", "csv"])
def test_each_part_between_changes_has_its_own_settings(session, tmp_path, capsys, ending):  # noqa: F811
    path = session
    if ending == "csv":
        path = tmp_path / "felt.csv"
        hs.open_session(session).save(path)
    assert main(["identify", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    stiffness = stiffness_of(found)
    assert (stiffness["set"], stiffness["value"]) == (600.0, pytest.approx(600.0, abs=0.6))
    assert found["from_s"] == pytest.approx(1.1, abs=2e-3)
    assert found["to_s"] == pytest.approx(2.999, abs=2e-3)
    assert main(["identify", str(path), "--to", "0.9", "--json"]) == 0
    stiffness = stiffness_of(json.loads(capsys.readouterr().out))
    assert (stiffness["set"], stiffness["value"]) == (250.0, pytest.approx(250.0, abs=0.5))
    assert main(["identify", str(path), "--from", "0.5"]) == 2
    assert "The settings changed at 1.05 s: choose a part without a change." in capsys.readouterr().err
    assert main(["identify", str(path)]) == 0
    assert capsys.readouterr().out.startswith(
        "The settings changed at 1.05 s; a piece has no change in it.\n"
    )


# --- other programs made the recording

NAMED = ("--time", "t_ms:ms", "--position", "x_mm:mm", "--force", "F:mN")


def foreign(count=3000, velocity=True):
    """Return the text of a recording of two sines in a spring of 210 N/m at 2 mm with 1.5 N·s/m."""
    t = 1e-3 * np.arange(count)
    sines = [(8.0, 0.83, 0.0), (4.0, 2.37, 1.0)]
    x = sum(a * np.sin(2.0 * np.pi * f * t + p) for a, f, p in sines)  # mm
    v = sum(2.0 * np.pi * f * a * np.cos(2.0 * np.pi * f * t + p) for a, f, p in sines)  # mm/s
    force = -210.0 * (x - 2.0) - 1.5 * v  # mN
    names, columns = ["t_ms", "x_mm", "F"], [1e3 * t, x, force]
    if velocity:
        names, columns = [*names, "dx_mms"], [*columns, v]
    rows = (";".join(f"{value:.4f}" for value in row).replace(".", ",") for row in zip(*columns, strict=True))
    return "\n".join([";".join(names), *rows]) + "\n"


@pytest.mark.parametrize("more", [(), ("--velocity", "dx_mms:mm/s")])
def test_the_spring_in_a_recording_of_another_program_is_identified(tmp_path, capsys, more):
    path = tmp_path / "lab.csv"
    path.write_text(foreign())
    assert main(["identify", str(path), *NAMED, *more, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    terms = {e["key"]: e for e in found["parts"]["rendered"]["estimates"]}
    assert terms["stiffness"]["value"] == pytest.approx(210.0, abs=0.3)
    # a command held for 1 ms has a mean delay of 0.5 ms, which lowers the damping
    assert terms["damping"]["value"] == pytest.approx(1.5 - 210.0 * 0.5e-3, abs=0.01)
    assert terms["centre"]["value"] == pytest.approx(2e-3, abs=2e-5)
    assert terms["stiffness"]["set"] is None
    assert "hand's force is not measured" in found["parts"]["handle"]["text"][0]
    assert "The force is taken from the file" in found["force"]


def test_an_unknown_table_lists_its_columns_and_the_option_to_name_them(tmp_path, capsys):
    path = tmp_path / "lab.csv"
    path.write_text(foreign(40))
    assert main(["identify", str(path)]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "--time t_ms:ms --position x_mm:mm --force F:N" in err
    assert "It has: t_ms, x_mm, F, dx_mms." in err
    with pytest.raises(UnknownColumnsError) as raised:
        api.open_recording(path)
    assert raised.value.table.names == ("t_ms", "x_mm", "F", "dx_mms")


def test_plot_columns_are_in_si_units(tmp_path):
    """The table has four samples; the velocity is read from it, or computed from the positions."""
    path = tmp_path / "four.csv"
    path.write_text(
        "t_ms;x_mm;dx_mms;F\n0;0,00;0,0;0,00\n1;0,10;100,0;-0,03\n2;0,20;100,0;-0,06\n3;0,30;100,0;-0,09\n"
    )
    columns = {
        "time": TableColumn("t_ms", "ms"),
        "position": TableColumn("x_mm", "mm"),
        "force": TableColumn("F", "N"),
    }
    found = api.open_recording(path, columns)
    assert found.time == pytest.approx([0.0, 1e-3, 2e-3, 3e-3])
    assert found.position == pytest.approx([0.0, 1e-4, 2e-4, 3e-4])
    assert found.applied_force == pytest.approx(-300.0 * found.position)
    assert found.velocity == pytest.approx([0.1] * 4)
    assert found.setup.quantum == pytest.approx(1e-4)
    given = api.open_recording(path, {**columns, "velocity": TableColumn("dx_mms", "mm/s")})
    assert given.velocity == pytest.approx([0.0, 0.1, 0.1, 0.1])
    with pytest.raises(ParameterError, match="at least 32 samples, not 4"):
        identify(found)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "t_ms;x_mm;F\n0;0;0\n1;0;0\n1;0;0\n",
            r"times that decrease or repeat: 0\.001 s comes after 0\.001 s in line 4",
        ),
        ("t_ms;x_mm;F\n0;0;0\n\n5;0;0\n1;0;0\n", r"0\.001 s comes after 0\.005 s in line 5"),
        ("t_ms;x_mm;F\n0;0;0\n1;nan;0\n", "not numbers, first in line 3"),
        ("t_ms;x_mm;F\n0;0;0\n1;0;-inf\n", "not numbers, first in line 3"),
        ("t_ms;x_mm;F\n0;0;0\n1;?;0\n", "line 3, x_mm is '\\?'"),
        ("t_ms;x_mm;G\n0;0;0\n1;0;0\n", "has no column F for the force"),
    ],
)
def test_invalid_recordings_give_a_one_line_error(tmp_path, capsys, text, message):
    path = tmp_path / "lab.csv"
    path.write_text(text)
    assert main(["identify", str(path), *NAMED]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    with pytest.raises(ParameterError, match=message):
        api.open_recording(path, {"time": TableColumn("t_ms", "ms"), "position": TableColumn("x_mm", "mm"),
                                  "force": TableColumn("F", "mN")})  # fmt: skip


def test_an_unknown_unit_of_a_column_is_one_line(tmp_path, capsys):
    path = tmp_path / "lab.csv"
    path.write_text(foreign(40))
    for given in (("--time", "t_ms:mm"), ("--force", "F"), ("--velocity", "dx_mms:m")):
        assert main(["identify", str(path), *NAMED, *given]) == 2
        err = capsys.readouterr().err
        assert "is NAME:UNIT, the unit one of" in err
        assert err.count("\n") == 1


def test_a_fifo_is_refused_at_once(tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe.csv")
    assert main(["identify", str(tmp_path / "pipe.csv")]) == 2
    assert "a device or a pipe, not a file" in capsys.readouterr().err
