"""The function ``simulate``: its samples, timing, delay, sensor, clamp, hands, energy and errors."""

import math
from dataclasses import replace

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.hand import Hand, Prescribed
from hapkit_studio.environments.base import Conditions
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rows

IDEAL = {"coulomb_force": 0.0, "quantum": 0.0, "max_force": math.inf}
QUANTUM = 20.7e-6


def device(**given):
    """Return a linear device with an ideal sensor, without Coulomb friction and without a force limit."""
    return hs.SimulatedHapkit(**{**IDEAL, **given})


# --- samples


@pytest.mark.parametrize(
    ("seconds", "rate", "count"),
    [(2.0, 1000.0, 2000), (0.0104, 1000.0, 10), (0.0106, 1000.0, 11), (1.0, 333.3, 333), (0.5, 3.0, 2)],
)
def test_a_run_has_seconds_times_rate_samples_at_their_times(seconds, rate, count):
    run = hs.simulate("wall", seconds=seconds, rate=rate)
    assert len(run.time) == count
    assert np.array_equal(run.time, np.arange(count) / rate)
    for name, column in run.columns().items():
        assert column.shape == (count,), name
    assert run.state.shape == (count, 0)


def test_warnings_get_all_rendering_conditions():
    asked = []
    scene = replace(hs.environments()["wall"], warnings=lambda values, c: asked.append(c) or ("said",))
    device = hs.SimulatedHapkit(0.05, 0.3, 0.2, 1e-5, 2.0, initial_velocity=0.1)
    run = hs.simulate(
        scene, device=device, rate=2000.0, delay=1e-3, estimator=("iir", {"cutoff": 9.0}), seconds=0.1
    )
    assert run.warnings == ("said",)
    speed = np.abs(run.true_velocity).max()
    assert asked == [
        Conditions(
            2000.0, 1e-3, ("iir", {"cutoff": 9.0}), quantum=1e-5, viscous=0.3, speed=speed, mass=0.05,
            coulomb=0.2, max_force=2.0,
        )
    ]  # fmt: skip


@pytest.mark.parametrize("quantum", [20.7e-6, 1e-3, 0.0])
def test_the_position_is_the_next_lower_count(quantum):
    run = hs.simulate("spring", hand="shake", device=hs.SimulatedHapkit(quantum=quantum), seconds=1.0)
    want = quantum * np.floor(run.true_position / quantum) if quantum else run.true_position
    assert np.array_equal(run.position, want)
    assert np.ptp(run.position) > 0.01


@pytest.mark.parametrize("estimator", ["difference", "iir", ("iir", {"cutoff": 12.0})])
def test_the_velocity_is_the_estimate_of_the_positions(estimator):
    run = hs.simulate("wall", hand="tap", estimator=estimator, rate=2000.0, seconds=1.0)
    want = hs.estimate_velocity(run.position, 2000.0, estimator)
    assert run.velocity == pytest.approx(want, rel=1e-12, abs=1e-15)
    assert run.velocity[0] == 0.0


@pytest.mark.parametrize("limit", [3.0, 0.7, math.inf])
def test_the_applied_force_is_the_laws_within_the_limit(limit):
    run = hs.simulate(
        "spring", {"stiffness": 900.0}, hand="shake", device=hs.SimulatedHapkit(max_force=limit)
    )
    assert run.force == pytest.approx(-900.0 * run.position, rel=1e-13)
    assert np.array_equal(run.applied_force, np.clip(run.force, -limit, limit))
    assert np.array_equal(run.flags == rows.CLAMPED, np.abs(run.force) > limit)
    assert (run.flags != 0).any() == math.isfinite(limit)


# --- reproducibility


def test_same_arguments_and_seed_give_the_same_bits():
    args = {"hand": "shake", "delay": 0.3e-3, "estimator": "iir", "seconds": 1.0, "seed": 4}
    first, second = (hs.simulate("wall", {"damping": 3.0}, **args) for _ in range(2))
    for name, column in first.columns().items():
        assert column.tobytes() == second.columns()[name].tobytes(), name


def test_over_speed_latches_only_if_requested():
    start = hs.SimulatedHapkit(initial_velocity=5.0)
    assert not hs.simulate("damping", device=start, seconds=0.02).faults
    run = hs.simulate("damping", device=start, seconds=0.02, max_speed=3.0)
    assert run.faults == (f"Fault: the handle moved too fast, {run.velocity[1]:.1f} m/s (limit 3.0 m/s).",)
    assert run.applied_force[0] == 0.0
    assert not run.applied_force[1:].any()


# --- files


def test_a_saved_run_is_read_back(tmp_path):
    start = hs.SimulatedHapkit(mass=np.float32(0.05), max_force=math.inf)
    run = hs.simulate(
        "wall",
        {"side": "left"},
        hand="stroke",
        device=start,
        seed=np.int64(3),
        estimator=("iir", {"cutoff": np.float32(20)}),
    )
    path = tmp_path / "run.csv"
    run.save(path)
    lines = path.read_text(encoding="utf-8").splitlines()
    header = [line for line in lines if line.startswith("#")]
    settings = dict(line.removeprefix("# ").split(": ") for line in header)
    assert settings["environment"] == "wall"
    assert settings["stiffness"] == "250 N/m"
    assert settings["side"] == "left"
    assert settings["rate"] == "1000 Hz"
    assert (settings["estimator"], settings["estimator.cutoff"]) == ("iir", "20 Hz")
    assert settings["device.max_force"] == "inf N"
    assert settings["seed"] == "3"
    value, unit = settings["device.mass"].split(" ")
    assert (float(value), unit) == (pytest.approx(0.05), "kg")
    names = lines[len(header)].split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=len(header) + 1)
    assert table.shape == (2000, len(names))
    for name, column in run.columns().items():
        assert table[:, names.index(name)] == pytest.approx(column, rel=1e-8, abs=1e-15)


@pytest.mark.parametrize("ending", ["png", pytest.param("svg", marks=pytest.mark.slow)])
def test_a_plotted_run_is_a_picture(tmp_path, ending):
    path = tmp_path / f"run.{ending}"
    run = hs.simulate("wall", hand="press", seconds=0.5)
    run.plot(path)
    with pytest.raises(ParameterError, match=r"The name of a picture must end in one of .*png.*, not 'xyz'"):
        run.plot(tmp_path / "run.xyz")
    starts = {"png": b"\x89PNG", "svg": b"<?xml"}
    assert path.read_bytes().startswith(starts[ending])
    assert path.stat().st_size > 5000


# --- errors: one line with the value and the permitted range

REFUSED = [
    (("wal",), {}, "There is no environment 'wal'; available: free, spring, wall"),
    ((None,), {}, "There is no environment None"),
    (("wall", {"stifness": 1.0}), {}, "Wall has no parameter 'stifness'; it has: stiffness, damping"),
    (("wall", {"stiffness": 5000.1}), {}, "Stiffness must be between 0 and 5,000 N/m, not 5,000.1."),
    (("wall", {"side": "up"}), {}, "Side must be one of right, left, not 'up'."),
    (("wall", [("stiffness", 1.0)]), {}, "parameters of Wall must be given by name"),
    (("wall",), {"hand": "shove"}, "The hand must be one of press, tap, stroke"),
    (("wall",), {"hand": math.sin}, "hand takes a script's name, a Hand"),
    (("wall",), {"hand": Hand(0, 0, 9, lambda t: math.inf if t > 0.0105 else 0.0)}, "at 0.011 s it is not."),
    (("wall",), {"hand": Hand(0, 0, 9, lambda t: "far")}, "one number in m at every time"),
    (("wall",), {"hand": Hand(0, 0, 9, lambda t: (t, t))}, "one number in m at every time"),
    (("wall",), {"hand": Prescribed("left")}, "a function of time in s, not 'left'"),
    (("wall",), {"device": "simulated"}, "device takes a SimulatedHapkit or None, not 'simulated'"),
    (("wall",), {"rate": 0.0}, "The rate must be between 0.001 and 10⁹ Hz, not 0."),
    (("wall",), {"rate": "fast"}, "The rate must be a number in Hz, not 'fast'."),
    (("wall",), {"delay": -1e-3}, "The delay must be between 0 and 10 s, not −0.001."),
    (("wall",), {"seconds": 0.0004}, "A run has 1 to 10,000,000 samples, not 0: 0.0004 s at 1,000 Hz."),
    (("wall",), {"seconds": 86_400.0}, "not 86,400,000: 86,400 s at 1,000 Hz."),
    (("wall",), {"seconds": math.nan}, "Seconds must be between 0"),
    (("wall",), {"estimator": "magic"}, "one of difference, iir, butterworth, foaw, kalman, not 'magic'."),
    (("wall",), {"estimator": ("iir", {"cutoff": -5.0})}, "Cutoff must be between 1 and 2,000 Hz, not −5."),
    (("wall",), {"estimator": ("iir", {"corner": 5.0})}, "has no parameter 'corner'; it has: cutoff"),
    (("wall",), {"estimator": ("iir", 20.0)}, "a name or (name, {option: value})"),
    (("wall",), {"estimator": (["iir"], {})}, "one of difference, iir, butterworth, foaw, kalman, not"),
    (("wall",), {"max_speed": math.nan}, "Largest speed must be between 0"),
    (("wall",), {"seed": 1.5}, "seed takes a whole number"),
    (("wall",), {"seed": True}, "seed takes a whole number"),
]


@pytest.mark.parametrize(("args", "more", "text"), REFUSED, ids=[text[:40] for _, _, text in REFUSED])
def test_invalid_runs_are_rejected(args, more, text):
    with pytest.raises(ParameterError) as error:
        hs.simulate(*args, **more)
    assert text in str(error.value)
    assert "\n" not in str(error.value)


def test_numpy_and_text_numbers_are_accepted():
    given = {"stiffness": np.int64(400), "damping": np.float32(2.0), "position": "0.005", "side": "right"}
    run = hs.simulate(
        "wall", given, rate=np.int32(500), delay=np.float64(0.0), seconds=np.int64(1), hand="press"
    )
    want = hs.simulate("wall", {"stiffness": 400.0, "damping": 2.0}, rate=500.0, seconds=1.0, hand="press")
    assert np.array_equal(run.force, want.force)


def test_all_public_names_exist():
    for name in hs.__all__:
        assert getattr(hs, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        hs.nonsense  # noqa: B018
