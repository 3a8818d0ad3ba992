"""Every device with a simulated handle works in the list, headless, in the loop, and in commands."""

import json
import math

import numpy as np
import pytest

from hapkit_studio import api, cli, devices
from hapkit_studio.analysis.stability.verdict import VerdictInput, verdict
from hapkit_studio.analysis.zwidth.on_device import setting_of
from hapkit_studio.dynamics.hand import Prescribed
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.sessions.recorder import Recorder
from tests.waiting import wait_until

MODELLED = [entry for entry in devices.available() if entry.make().model is not None]
every_device = pytest.mark.parametrize("entry", MODELLED, ids=lambda entry: entry.key)


@pytest.fixture
def engine(entry):
    engine = Engine(entry.make(), "wall", realtime=False)
    engine.start()
    yield engine
    engine.close()


@every_device
def test_is_listed_and_found_by_its_key(entry, capsys):
    assert cli.main(["devices", "--probe", "--json"]) == 0
    (listed,) = [d for d in json.loads(capsys.readouterr().out)["devices"] if d["key"] == entry.key]
    assert (listed["title"], listed["ok"]) == (entry.title, True)
    assert type(devices.named(entry.key)) is type(entry.make())


@every_device
def test_a_model_agrees_with_the_devices_properties(entry):
    device = entry.make()
    for name in ("mass", "viscous", "coulomb_force", "quantum", "max_force"):
        assert getattr(device.model, name) == getattr(device, name), name
    assert (device.rate is not None) == device.own_clock


@every_device
def test_headless_a_hand_needs_the_force_of_mass_damping_and_friction(entry):
    """The force in N follows from Newton's law for a prescribed sine and its derivatives."""
    device, size, turn = entry.make(), 0.01, 2.0 * math.pi * 5.0
    run = api.simulate(
        "free", device=device, hand=Prescribed(lambda t: size * math.sin(turn * t)), seconds=0.5
    )
    speed = size * turn * np.cos(turn * run.time)
    force = -device.mass * turn**2 * size * np.sin(turn * run.time) + device.viscous * speed
    force += device.coulomb_force * np.sign(speed)
    inside = (np.abs(speed) > 0.05 * size * turn) & (run.time > 0.01) & (run.time < 0.49)
    assert run.hand_force[inside] == pytest.approx(force[inside], rel=1e-3, abs=1e-3)
    assert np.allclose(run.position / device.quantum, np.round(run.position / device.quantum), atol=1e-6)


@every_device
def test_the_loop_renders_records_and_is_judged(entry, engine, tmp_path):
    device, reader = entry.make(), engine.reader()
    path = tmp_path / "run.hapkit"
    recorder = Recorder(seconds=0.5)
    recorder.follow(engine)
    recorder.record(path)
    engine.move_hand(0.01)
    found = []

    def pressed():
        found.extend(reader.read())
        return bool(found) and found[-1][rows.APPLIED_FORCE] < -0.1

    wait_until(pressed)
    recorder.stop()
    recorder.close()
    table = np.array(found)
    counts = table[:, rows.POSITION] / device.quantum
    assert np.allclose(counts, np.round(counts), atol=1e-6)
    assert (np.abs(table[:, rows.APPLIED_FORCE]) <= device.max_force).all()
    assert engine.loop.rate == (device.rate or 1000.0)
    run = api.open_session(path)
    assert run.settings["device"]["title"] == device.title
    assert run.settings["rate_Hz"] == engine.loop.rate
    setting = setting_of(engine, "medium")
    assert (setting.mass, setting.rate) == (device.mass, engine.loop.rate)
    assert verdict(VerdictInput(engine.environment, engine.values, setting, engine.max_force)).lines


@every_device
def test_a_device_with_its_own_rate_keeps_it(entry, engine):
    device = entry.make()
    other = 2.0 * (device.rate or 500.0)
    if device.own_clock:
        with pytest.raises(ParameterError, match="sets the rate"):
            engine.set_loop(rate=other)
    else:
        engine.set_loop(rate=other)
        assert engine.loop.rate == other


@every_device
def test_a_command_runs_it_with_a_hand(entry, capsys):
    args = ["run", "wall", "--device", entry.key, "--hand", "press", "--seconds", "0.5", "--json"]
    assert cli.main(args) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["computer"]["rate_Hz"] == (entry.make().rate or 1000.0)


@every_device
def test_bode_drives_its_handle_at_its_rate(entry, capsys):
    device = entry.make()
    handle = {"mass": device.mass, "viscous": device.viscous, "coulomb": device.coulomb_force}
    handle |= {"quantum": device.quantum, "rate": device.rate or 1000.0}
    options = [f"--{name}={value!r}" for name, value in handle.items()]
    found = []
    for args in (["--device", entry.key], options):
        assert cli.main(["bode", "spring", *args, "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out)["curves"])
    assert found[0] == found[1]
