"""An administrator's file limits force, devices and settings; if the file has a mistake, no motor runs."""

import sys

import pytest

from hapkit_studio import cli, devices, lab
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.errors import DeviceError, FileError, ParameterError
from hapkit_studio.gui.state.permissions import BY_LAB, Permissions
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.lessons import library


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
        lab.settings()
    assert named in str(raised.value)
    engine = Engine(SimulatedHapkit(), realtime=False)
    with pytest.raises(DeviceError, match="stays zero"):
        engine.start()
    assert engine.driver is None or not engine.health().running
    assert cli.main(["devices"]) == 2
    assert "lab.toml" in capsys.readouterr().err


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
