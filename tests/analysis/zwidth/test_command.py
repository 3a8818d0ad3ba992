"""The command ``zwidth`` by simulation prints text and JSON, draws a figure, and gives one-line errors."""

import json

import pytest

from hapkit_studio.analysis.zwidth import on_device, simulation
from hapkit_studio.analysis.zwidth.guarded_device import TrialLimits
from hapkit_studio.analysis.zwidth.result import Protocol
from hapkit_studio.cli import main
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings


def run(capsys, *args):
    code = main(("zwidth", *args))
    out, err = capsys.readouterr()
    return code, out, err


@pytest.mark.slow
def test_the_output_states_the_stiffest_wall_and_the_conditions(capsys):
    code, out, err = run(capsys, "--damping", "0,2", "--mass", "0.05", "--quantum", "15e-6")
    assert (code, err) == (0, "")
    assert out.startswith(
        "With damping b = 2 N·s/m (no hand), the handle comes to rest at all tested walls up to 8,7"
    )
    assert "the handle buzzes" in out
    assert "v₀ 0.1 m/s · push 1 N · force limit none · precision of the stiffness 1 %" in out


def test_the_json_is_one_object(capsys):
    code, out, err = run(capsys, "--damping", "1", "--delay", "1e-3", "--max-force", "3", "--json")
    assert (code, err) == (0, "")
    found = json.loads(out, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    (point,) = found["points"]
    assert set(point) == {
        "damping", "stiffness", "linear_limit", "ended", "clamped", "first_failed", "last_held"
    }  # fmt: skip
    assert point["linear_limit"] < point["stiffness"] < 2.0 * point["linear_limit"]
    conditions = found["conditions"]
    assert conditions["rate_Hz"] == 1000.0
    assert conditions["delay"] == 1e-3
    assert conditions["max_force"] == 3.0
    assert set(conditions) >= {"mass", "viscous", "coulomb", "quantum", "estimator", "hand", "speed", "push"}


@pytest.fixture
def measured(monkeypatch):
    """Replace the measurement by one that records its arguments."""
    asked = {}

    def measure(engine, levels, limits, **more):
        asked.update(engine=engine, levels=levels, limits=limits, loop=engine.loop, grip=engine.grip)
        if asked.get("raises"):
            raise asked["raises"]
        return simulation.compute(LoopSettings(), levels, Protocol(seconds=0.6, halvings=1))

    monkeypatch.setattr(on_device, "measure", measure)
    return asked


@pytest.mark.slow
def test_a_device_gets_the_options_and_is_closed(capsys, measured):
    args = "--device simulated --damping 0,1 --mass 0.06 --rate 500 --delay 2e-3 --estimator iir:cutoff=20"
    args += " --hand firm --max-force 1.5 --push 0.5 --speed 0.05"
    code, _, err = run(capsys, *args.split())
    assert (code, err) == (0, "")
    assert measured["levels"] == (0.0, 1.0)
    assert measured["limits"] == TrialLimits(max_force=1.5, push=0.5, hit=0.05)
    assert measured["engine"].device == SimulatedHapkit(mass=0.06)
    loop = measured["loop"]
    assert (loop.rate, loop.delay, loop.estimator) == (500.0, 2e-3, ("iir", {"cutoff": 20.0}))
    assert measured["grip"] == "firm"
    assert not measured["engine"].health().running


def test_ctrl_c_closes_the_device(capsys, measured):
    measured["raises"] = KeyboardInterrupt()
    code, out, _ = run(capsys, "--device", "simulated")
    assert (code, out) == (130, "")
    assert not measured["engine"].health().running
    assert measured["engine"].arrays.control.done[0] == 1  # the loop's last action was a zero command
