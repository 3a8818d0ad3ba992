"""An administrator's file limits force, devices and settings; if the file has a mistake, no motor runs."""

import contextlib
import re
import sys

import numpy as np
import pytest

from hapkit_studio import cli, devices, environments, lab
from hapkit_studio.analysis.calibrate import motions
from hapkit_studio.analysis.calibrate.checks import CHECKS, run_all
from hapkit_studio.analysis.zwidth.guarded_device import GuardedDevice, TrialLimits
from hapkit_studio.devices.board_runner import AbortedError, BoardRunner, ForceLimitError
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.errors import DeviceError, FileError, ParameterError
from hapkit_studio.gui.state.permissions import BY_LAB, Permissions
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.lessons import library
from hapkit_studio.workshop import sketch
from tests.devices.paddle_kit import PaddleKit
from tests.haptics.support import rest


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Return a function that writes this computer's lab file."""
    monkeypatch.setenv("XDG_CONFIG_DIRS", str(tmp_path))
    monkeypatch.setattr(lab, "path", lambda: tmp_path / "hapkit-studio" / "lab.toml")

    def written(text):
        lab.path().parent.mkdir(exist_ok=True)
        lab.path().write_text(text, encoding="utf-8")
        lab.settings.cache_clear()
        return lab.path()

    lab.settings.cache_clear()
    yield written
    lab.settings.cache_clear()


@pytest.mark.skipif(sys.platform != "linux", reason="the folder of Linux")
def test_the_file_is_in_the_first_folder_for_all_users(monkeypatch):
    monkeypatch.delenv("XDG_CONFIG_DIRS", raising=False)
    assert str(lab.path()) == "/etc/xdg/hapkit-studio/lab.toml"
    monkeypatch.setenv("XDG_CONFIG_DIRS", "/srv/one:/srv/two")
    assert str(lab.path()) == "/srv/one/hapkit-studio/lab.toml"


@pytest.mark.parametrize(("limit", "most"), [(2.0, 2.0), (5.0, 3.0)])
def test_the_force_is_limited_by_the_lab_or_the_device_whichever_is_lower(write, limit, most):
    write(f"force_limit = {limit}")
    engine = Engine(SimulatedHapkit(max_force=3.0), realtime=False)
    engine.start()
    try:
        assert engine.max_force == most
        with pytest.raises(ParameterError, match=f"{most:g} N"):
            engine.limit_force(most + 0.1)
    finally:
        engine.close()


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("force_limit = 'two'", "force_limit is 'two'"),
        ("force_limit = 0.0", "from 0.1 to 100 N"),
        ("force_limit = nan", "from 0.1 to 100 N"),
        ("force_limits = 2.0", "force_limits"),
        ("devices = []", "devices"),
        ("lessons = 'here'", "whole path"),
        ("locked = ['value.wall']", "value.wall.stiffness"),
        ("locked = ['everything']", "everything"),
        ("force_limit = \n", "line 1"),
    ],
)
def test_a_mistake_is_named_and_no_loop_starts(write, capsys, text, named):
    write(text)
    with pytest.raises(FileError, match=r"lab\.toml") as raised:
        lab.check()
    assert named in str(raised.value)
    assert lab.settings().force_limit == 0.0
    assert [entry.key for entry in devices.available()] == ["simulated"]
    engine = Engine(SimulatedHapkit(), realtime=False)
    with pytest.raises(DeviceError, match="stays zero"):
        engine.start()
    assert engine.driver is None or not engine.health().running
    for command in (
        ["devices"],
        ["run", "wall", "--device", "simulated"],
        ["check", "virtual-board"],
        ["flash"],
    ):
        assert cli.main(command) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert named in line
        assert str(lab.path()) in line


@pytest.mark.parametrize("obstacle", ["folder", "link to nothing", "no access", "not text"])
def test_a_file_that_cannot_be_read_is_a_mistake(write, monkeypatch, obstacle):
    file = write("")
    if obstacle == "no access":  # root may read every file

        def refused(path):
            raise PermissionError(13, "Permission denied", str(path))

        monkeypatch.setattr(lab.os, "lstat", refused)
    elif obstacle == "not text":
        file.write_bytes(b"force_limit = 2.0 # \xff\n")
    else:
        file.unlink()
        if obstacle == "folder":
            file.mkdir()
        else:
            file.symlink_to(file.parent / "missing.toml")
    with pytest.raises(DeviceError, match=r"lab\.toml.* stays zero"):
        lab.force_limit()


def test_without_the_file_or_its_folder_nothing_is_limited(write):
    file = write("")
    file.unlink()
    assert lab.settings() == lab.LabSettings()
    file.parent.rmdir()
    for make in (lambda: None, file.parent.touch):  # no folder, and a file in its place
        make()
        lab.settings.cache_clear()
        assert lab.settings() == lab.LabSettings()


ABOVE, BELOW = 1.01, 0.99


def test_the_loop_cuts_forces_above_the_limit_only(write):
    stiffness, pushed = 200.0, 0.02  # N/m, m: the spring asks for up to 4 N
    write("force_limit = 1.5")
    engine = Engine(SimulatedHapkit(max_force=3.0), "spring", realtime=False)
    engine.set_environment("spring", {"stiffness": stiffness, "damping": 0.0})
    engine.set_loop(hand="firm")
    reader = engine.reader()
    engine.start()
    try:
        engine.limit_force(BELOW * 1.5)
        with pytest.raises(ParameterError, match=r"1\.5 N"):
            engine.limit_force(ABOVE * 1.5)
        engine.limit_force(1.5)
        engine.move_hand(pushed)
        found = rest(reader, 600)
    finally:
        engine.close()
    steady = found[(found[:, rows.FLAGS].astype(int) & ~rows.CLAMPED) == 0]
    asked, given = steady[:, rows.FORCE], steady[:, rows.APPLIED_FORCE]
    assert np.abs(asked).max() > ABOVE * 1.5
    np.testing.assert_allclose(given, np.clip(asked, -1.5, 1.5), atol=1e-12)


MOTIONS = {
    "pulse": (lambda runner: motions.pulse(runner, 0.1), motions.PULSE_LIMITS),
    "raise_force": (motions.raise_force, motions.RAISE_LIMITS),
    "carry": (motions.carry, motions.CARRY_LIMITS),
    "push": (lambda runner: motions.push(runner, 1.5, 0.01, lambda: True), motions.PUSH_LIMITS),
    "pull": (lambda runner: motions.pull(runner, 60.0), motions.PULL_LIMITS),
    "sweep": (lambda runner: motions.sweep(runner, 0.05), motions.SWEEP_LIMITS),
    "spring": (lambda runner: motions.spring(runner, 100.0, 0.05), motions.SPRING_LIMITS),
}


def test_every_motion_of_the_set_up_is_tested_here():
    made = {
        name
        for name, value in vars(motions).items()
        if callable(value) and value.__module__ == motions.__name__
    }
    assert made == set(MOTIONS)


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_that_may_exceed_the_limit_does_not_start(write, name):
    move, limits = MOTIONS[name]
    runner = BoardRunner(PaddleKit())
    write("")
    runner.open()
    write(f"force_limit = {BELOW * limits.force}")
    with pytest.raises(ForceLimitError, match=rf"{limits.force:g} N.*lab\.toml"):
        move(runner)
    assert runner.board.forces == []
    write(f"force_limit = {ABOVE * limits.force}")
    with contextlib.suppress(AbortedError):  # the handle of this test is not suitable for all motions
        move(runner)
    assert len(runner.board.forces) > 0
    assert np.abs(runner.board.forces).max() <= limits.force


def test_a_mistake_in_the_file_keeps_the_set_up_from_opening_the_board(write):
    write("force_limit = 'two'")
    runner = BoardRunner(PaddleKit())
    with pytest.raises(DeviceError, match="stays zero"):
        runner.open()
    assert runner.board.hello is None


def test_the_check_of_a_kit_names_what_the_limit_prevents(write):
    write("force_limit = 1.0")  # pulses need 0.3 N, the sweep and the spring 1.2 N
    runner = BoardRunner(PaddleKit())
    runner.open()
    report = run_all(runner)
    limited = [key for key, result in report.results.items() if "lab.toml" in result.text]
    assert limited == ["paddle", "spring"]
    assert not report.dangerous
    assert np.abs(runner.board.forces).max() <= 0.3
    assert set(report.results) == {check.key for check in CHECKS}


@pytest.mark.parametrize(("lab_limit", "most"), [(BELOW * 3.0, BELOW * 3.0), (ABOVE * 3.0, 3.0)])
def test_a_sketch_has_the_lower_limit(write, lab_limit, most):
    write(f"force_limit = {lab_limit}")
    text = sketch.text(environments.named("wall"), {})
    (found,) = re.findall(r"float kMaxForce = ([\d.]+)f;", text)
    assert float(found) == pytest.approx(most, rel=1e-6)
    write("force_limit = 'two'")
    with pytest.raises(DeviceError, match="stays zero"):
        sketch.text(environments.named("wall"), {})


def test_trials_of_walls_keep_the_limit_and_restore_it(write):
    write("force_limit = 1.8")
    engine = Engine(SimulatedHapkit(), "spring", realtime=False)
    engine.start()
    try:
        with pytest.raises(ParameterError, match=r"1\.8 N"):
            GuardedDevice(engine, TrialLimits(max_force=ABOVE * 1.8), print, print).__enter__()
        with GuardedDevice(engine, TrialLimits(max_force=BELOW * 1.8), lambda text: None, lambda: None):
            assert engine.max_force == BELOW * 1.8
        assert engine.max_force == 1.8
    finally:
        engine.close()


def test_firmware_is_written_to_allowed_ports_only(write, capsys):
    write('devices = ["/dev/ttyACM*"]')
    assert cli.main(["flash", "/dev/ttyUSB0"]) == 2
    assert "lab.toml does not allow the device /dev/ttyUSB0" in capsys.readouterr().err


def test_only_allowed_devices_are_listed_and_opened(write):
    write('devices = ["/dev/ttyACM*", "COM3"]')
    # the simulated device is always allowed
    assert [entry.key for entry in devices.available()] == ["simulated"]
    assert devices.named("/dev/ttyACM1").title
    for key in ("/dev/ttyUSB0", "COM31"):
        with pytest.raises(ParameterError, match=r"lab\.toml does not allow"):
            devices.named(key)


def test_a_labs_lessons_are_added_and_a_missing_folder_is_reported(write, tmp_path):
    folder = tmp_path / "Übungen"
    folder.mkdir()
    usual = library().lessons
    (folder / "ours.md").write_text(usual["virtual_wall"].path.read_text("utf-8"), encoding="utf-8")
    write(f"lessons = '{folder}'")
    assert set(library().lessons) == {*usual, "ours"}
    write(f"lessons = '{tmp_path / 'unmounted'}'")
    found = library()
    assert set(found.lessons) == set(usual)
    assert "unmounted" in found.errors[0]


def test_a_labs_lock_covers_what_it_names_and_no_code_opens_it(write, qapp):
    from hapkit_studio.gui.state.lock import LOOP, Lock

    write('locked = ["loop", "value.wall.damping", "environment.cat"]')
    permissions = Permissions(qapp)
    permissions.lab = Lock(lab.settings().locked)
    fixed = [LOOP, ("loop", "rate"), ("value", "wall", "damping"), ("environment", "cat")]
    free = [("value", "wall", "stiffness"), ("environment", "wall"), ("device",)]
    assert [permissions.why_fixed(*place) for place in fixed] == [BY_LAB] * len(fixed)
    assert [permissions.why_fixed(*place) for place in free] == [""] * len(free)
    assert not permissions.lab.opens("")
    permissions.set_lock(Lock())  # this is how an instructor unlocks
    assert permissions.why_fixed(*LOOP) == BY_LAB
