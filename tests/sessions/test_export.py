"""Exports are read without the studio: samples, times of changes, and a law's own names."""

import csv
import json
import re

import numpy as np
import pytest
from pyarrow import parquet
from scipy.io import loadmat

import hapkit_studio as hs
from hapkit_studio.charts import run as charts
from hapkit_studio.cli import main
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import hand_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments import named
from hapkit_studio.environments.base import Environment, MovingObject
from hapkit_studio.haptics import headless, rows
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.export import matlab_names
from hapkit_studio.sessions.file import ABOUT, SETTINGS, Event, SessionWriter

IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")
START = 500.0  # start in s by the clock of the recording computer
CHANGE = 1.0  # time in s of the change after the first sample


def spring(stiffness):
    return {
        "environment": "spring",
        "parameters": {"stiffness": stiffness, "damping": 0.0, "center": 0.0},
        "units": {"stiffness": "N/m", "damping": "N·s/m", "center": "m"},
        "hand": "own",
        "rate_Hz": 1000.0,
        "delay_s": 0.0,
    }


def rendered(stiffness, seconds):
    """Return the rows of a spring that a hand shakes."""
    values = named("spring").values({"stiffness": stiffness})
    scene = headless.Scene(named("spring"), values, SimulatedHapkit(), LoopSettings())
    return headless.render(scene, hand_named("shake"), round(1000 * seconds))[0]


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """Return a session of 3 s with 250 N/m, and with 600 N/m from 1 s on.

    The change is recorded with the largest possible delay.
    """
    path = tmp_path_factory.mktemp("sessions") / "felt.hapkit"
    table = np.concatenate([rendered(250.0, CHANGE), rendered(600.0, 2.0)])
    table[:, rows.TICK] = np.arange(len(table))
    table[:, rows.HOST_TIME] = START + 1e-3 * np.arange(len(table))
    table[:, rows.BOARD_TIME] = 1e-3 * np.arange(len(table))
    writer = SessionWriter(path)
    writer.note(Event(START + 0.03, ABOUT, {"device": "Simulated Hapkit", "quantum_m": 20.7e-6}))
    writer.note(Event(START + 0.03, SETTINGS, spring(250.0)))
    writer.note(Event(START + CHANGE + 0.05, SETTINGS, spring(600.0)))
    for part in np.split(table, 10):
        writer.add(pack(part, 20.7e-6, 0))
    writer.close()
    return path


def header_of(path):
    """Return a CSV's settings as text by name, read line by line."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return dict(re.fullmatch(r"# (\S.*?): (\S.*)", line).groups() for line in lines if line.startswith("#"))


def columns_of(path, delimiter=","):
    """Return a CSV's columns by name, as Python's csv module reads them."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    names, *cells = csv.reader(lines, delimiter=delimiter)
    values = [[float(cell.replace(",", ".")) for cell in row] for row in cells]
    return dict(zip(names, np.array(values).T, strict=True))


@pytest.mark.parametrize("decimal", ".,")
def test_a_csv_has_the_first_settings_and_the_change_with_its_time(session, tmp_path, capsys, decimal):
    path = tmp_path / "felt.csv"
    assert main(["sessions", "export", str(session), "--output", str(path), "--decimal", decimal]) == 0
    header = header_of(path)
    assert header["stiffness"] == "250 N/m"
    assert header["stiffness at 1.05 s"] == "600 N/m"
    assert [name for name in header if " at " in name] == ["stiffness at 1.05 s"]
    assert (header["environment"], header["rate"]) == ("spring", "1000 Hz")
    columns = columns_of(path, ";" if decimal == "," else ",")
    assert len(columns["time_s"]) == 3000
    assert columns["time_s"][-1] == pytest.approx(2.999)


@pytest.mark.parametrize("ending", ["parquet", "mat"])
def test_parquet_and_mat_have_the_first_settings_and_the_change_with_its_time(
    session, tmp_path, capsys, ending
):
    path = tmp_path / f"felt.{ending}"
    assert main(["sessions", "export", str(session), "--output", str(path)]) == 0
    if ending == "mat":
        found = loadmat(path)
        text, position = found["settings"].item(), found["position_m"].ravel()
    else:
        found = parquet.read_table(path)
        text, position = found.schema.metadata[b"settings"], found["position_m"].to_numpy()
    settings = json.loads(text)
    assert settings["parameters"]["stiffness"] == 250.0
    assert settings["changes"] == [{"time_s": 1.05, "parameters": {"stiffness": 600.0}}]
    np.testing.assert_array_equal(position, hs.open_session(session).position)


def test_a_picture_has_the_change_and_its_time_in_the_caption(session, tmp_path, monkeypatch):
    captions = []
    monkeypatch.setattr(charts, "save", lambda *given, caption: captions.append(caption))
    hs.open_session(session).plot(tmp_path / "felt.png")
    initial, _conditions, change = captions[0].replace("\N{NO-BREAK SPACE}", " ").split("\n")
    assert "250" in initial
    assert "600" not in initial
    assert change == "At 1.05 s: stiffness 250 → 600 N/m"


def test_a_session_that_is_read_has_its_last_settings_and_earlier_ones(session):
    run = hs.open_session(session)
    assert run.settings["parameters"]["stiffness"] == 600.0
    assert [(time, what["parameters"]["stiffness"]) for time, what in run.log] == [
        (0.0, 250.0), (pytest.approx(1.05), 600.0),
    ]  # fmt: skip
    later = hs.open_session(session, 1.5)
    assert [what["parameters"]["stiffness"] for _, what in later.log] == [600.0]


def test_a_run_of_a_session_is_saved_as_a_session_with_its_changes(session, tmp_path):
    hs.open_session(session).save(tmp_path / "again.hapkit")
    first, second = hs.open_session(session), hs.open_session(tmp_path / "again.hapkit")
    np.testing.assert_allclose(second.position, first.position, atol=1e-9)
    assert [time for time, _ in second.log] == pytest.approx([time for time, _ in first.log])
    assert second.log[0][1]["parameters"] == first.log[0][1]["parameters"]


# --- a law's names that the studio also uses

LONG = "x" * 70
STATE = {
    "time_s": 5.0, "flags": 0.0, "position_m": 7.0, "settings": 1.0, "energy_J": 9.0, "state": 2.0,
    "größe": 1.0, "grosse": 2.0, "ω": 3.0, "old": (4.0, 5.0), "end": 6.0, "_low": 7.0, f"{LONG}a": 8.0,
    f"{LONG}b": 9.0, "数": 1.0,
}  # fmt: skip


@law(state=STATE)
def clashing(p, s, x, v, dt):
    s.time_s += 2 * dt
    return -p.stiffness * x


CLASH = Environment(
    key="clash",
    title="Clash",
    summary="Names that collide",
    parameters=(Parameter("stiffness", "Stiffness", "N/m", 50.0, 0.0, 300.0),),
    force=clashing,
    moves=MovingObject("position", state="position_m"),
)


@pytest.fixture(scope="module")
def clash():
    return hs.simulate(CLASH, hand="press", seconds=1.0)


def own_columns(run):
    """Return the studio's columns that have the name of a state variable."""
    return {"time_s": run.time, "position_m": run.position, "energy_J": run.energy, "flags": run.flags}


def test_state_variables_have_unique_names_in_csv_and_parquet(clash, tmp_path):
    clash.save(tmp_path / "clash.csv")
    clash.save(tmp_path / "clash.parquet")
    table = parquet.read_table(tmp_path / "clash.parquet")
    both = columns_of(tmp_path / "clash.csv"), {name: table[name].to_numpy() for name in table.column_names}
    assert list(both[0]) == list(both[1])
    for found in both:
        for name, values in own_columns(clash).items():
            np.testing.assert_allclose(found[name], values, rtol=1e-8, err_msg=name)
        assert found["time_s"][-1] == pytest.approx(0.999)
        assert found["state.time_s"][-1] == pytest.approx(7.0)
        assert (found["state.position_m"] == 7.0).all()
        assert (found["object.position_m"] == 7.0).all()
        assert (found["state.old[1]"] == 5.0).all()
        assert (found["state.größe"] == 1.0).all()
        assert sum(name.startswith("state.") for name in found) == len(clash.state_names) == 16


def test_a_mat_file_has_them_in_a_struct_with_valid_identifiers(clash, tmp_path):
    clash.save(tmp_path / "clash.mat")
    found = {name: v for name, v in loadmat(tmp_path / "clash.mat").items() if not name.startswith("__")}
    for name, values in own_columns(clash).items():
        np.testing.assert_array_equal(found[name].ravel(), values, err_msg=name)
    assert json.loads(found["settings"].item())["environment"] == "clash"
    state = {name: found["state"][name][0, 0].ravel() for name in found["state"].dtype.names}
    for name in (*found, *state):
        assert IDENTIFIER.fullmatch(name), name
    assert state["time_s"][-1] == pytest.approx(7.0)
    constant = {name: values[-1] for name, values in state.items() if name != "time_s"}
    assert constant == {
        "flags": 0.0, "position_m": 7.0, "settings": 1.0, "energy_J": 9.0, "state": 2.0,
        "grosse": 1.0, "grosse_2": 2.0, "omega": 3.0, "old_0": 4.0, "old_1": 5.0, "x_end": 6.0, "low": 7.0,
        "x" * 63: 8.0, "x" * 61 + "_2": 9.0, "u6570": 1.0,
    }  # fmt: skip
    assert (found["object"]["position_m"][0, 0] == 7.0).all()


def test_identifiers_are_valid_and_unique_for_any_names(rng):
    letters = list("aZ_09.[]- äßøЖΩ数\u0301\n")
    names = ["".join(rng.choice(letters, rng.integers(0, 80))) for _ in range(300)]
    names += [name.upper() for name in names] + ["a_2", "a", "a", "a", "for", "x_for", "for"]
    found = matlab_names(names)
    assert len(set(found)) == len(names)
    assert all(IDENTIFIER.fullmatch(name) for name in found)


def test_the_command_writes_parquet_and_mat_of_a_run(tmp_path, capsys):
    for ending in ("parquet", "mat"):
        path = tmp_path / f"run.{ending}"
        assert (
            main(
                [
                    "run",
                    "spring",
                    "-p",
                    "stiffness=120",
                    "--hand",
                    "press",
                    "--seconds",
                    "0.2",
                    "--csv",
                    str(path),
                ]
            )
            == 0
        )
    table, found = parquet.read_table(tmp_path / "run.parquet"), loadmat(tmp_path / "run.mat")
    force, position = table["force_asked_N"].to_numpy(), table["position_m"].to_numpy()
    np.testing.assert_allclose(force, -120.0 * position, rtol=1e-12)
    np.testing.assert_array_equal(found["position_m"].ravel(), position)
    assert json.loads(table.schema.metadata[b"settings"])["changes"] == []


def test_a_state_is_named_by_its_own_law(tmp_path):
    """After a change of environment, the state's columns have the names in the new environment's law."""
    table = np.zeros((1000, rows.ROW_WIDTH))
    table[:, rows.TICK] = np.arange(1000)
    table[:, rows.HOST_TIME] = table[:, rows.BOARD_TIME] = 1.0 + 1e-3 * np.arange(1000)
    table[:500, rows.STATE] = 3.0
    table[500:, rows.STATE : rows.STATE + 2] = 4.0, 5.0
    writer = SessionWriter(tmp_path / "a.hapkit")
    writer.note(Event(0.0, SETTINGS, {"environment": "a", "state_names": ["count"]}))
    writer.note(Event(1.5, SETTINGS, {"environment": "b", "state_names": ["speed", "count"]}))
    writer.add(pack(table[:500], 20.7e-6, 2))
    writer.add(pack(table[500:], 20.7e-6, 2))
    writer.close()
    run = hs.open_session(tmp_path / "a.hapkit")
    named = dict(zip(run.state_names, run.state.T, strict=True))
    assert set(named) == {"count", "speed"}
    np.testing.assert_array_equal(named["count"], np.repeat([3.0, 5.0], 500))
    np.testing.assert_array_equal(named["speed"], np.repeat([np.nan, 4.0], 500))
