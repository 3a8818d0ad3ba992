"""Identification of the rendered impedance: stiffness, damping, friction, the centre, and the hand's grip."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.identify import from_csv, from_run, identify
from hapkit_studio.dynamics.hand import Hand
from tests.analysis.identify.motions import HAND, impedance, several_sines, shaken, sine_run


@pytest.mark.parametrize(
    ("quantum", "rate", "delay", "damping"),
    [
        (20.7e-6, 1000.0, 0.0, 0.0),
        (61e-6, 1000.0, 2.5e-3, 5.0),
        (61e-6, 4000.0, 0.4e-3, 3.0),
    ],
)
def test_a_sine_renders_the_expected_impedance(quantum, rate, delay, damping):
    run = sine_run(300.0, damping, 3.7, 0.007, 0.4, quantum=quantum, rate=rate, delay=delay)
    found = identify(from_run(run))
    part = found.rendered
    stiffness, rest = impedance(300.0, damping, 3.7, rate, delay)
    assert part["stiffness"].holds(stiffness)
    assert part["damping"].holds(rest)
    assert part["stiffness"].half < 0.1
    assert part["damping"].half < 0.01
    assert found.hertz == pytest.approx(3.7, rel=0.01)


def test_a_ramp_has_no_frequency():
    run = hs.simulate("spring", hand=hs.Prescribed(lambda t: 0.012 * t), seconds=0.66)
    found = identify(from_run(run)).as_json()
    assert found["parts"]["rendered"]["motion_Hz"] is None
    assert found["parts"]["rendered"]["estimates"][0]["determined"]


def test_a_wall_is_judged_by_its_contacts_only():
    run = hs.simulate("wall", {"stiffness": 500.0, "damping_mode": "none"}, hand="tap", seconds=3.0)
    part = identify(from_run(run)).rendered
    assert part["stiffness"].value == pytest.approx(500.0, rel=2e-3)
    assert part["damping"].value == pytest.approx(-500.0 * 0.5e-3, abs=0.02)
    assert part["centre"].value == pytest.approx(0.005, abs=2e-5)
    contacts = np.count_nonzero(run.force)
    assert part.left_out["not in contact"] == 3000 - contacts


def test_damping_on_the_way_in_is_found_there_only():
    values = {"stiffness": 200.0, "damping": 8.0}
    tapped = identify(from_run(hs.simulate("wall", values, hand="tap", seconds=3.0, rate=4000.0))).rendered
    assert tapped["damping_in"].value == pytest.approx(8.0 - 200.0 * 0.125e-3, abs=0.15)
    assert tapped["damping_out"].value == pytest.approx(-200.0 * 0.125e-3, abs=0.15)
    pressed = identify(from_run(hs.simulate("wall", values, hand="press", seconds=3.0, rate=4000.0))).rendered
    assert pressed["damping_in"].asked == 8.0
    assert pressed["damping_in"].value == pytest.approx(8.0 - 200.0 * 0.125e-3, abs=0.15)
    assert not pressed["damping_out"].determined
    assert "Pull out faster" in pressed["damping_out"].advice


def test_friction_and_viscous_damping_are_distinguished():
    values = {"kinetic_force": 0.6, "static_force": 0.6, "viscous": 2.0, "tether_stiffness": 3000.0}
    part = shaken(5, "friction", values).rendered
    assert part["friction"].value == pytest.approx(0.6, abs=0.01)
    assert part["damping"].value == pytest.approx(2.0, abs=0.1)


def test_other_forces_lower_the_explained_fraction():
    assert shaken(7, values={"stiffness": 300.0}).rendered.explained > 0.9999
    run = hs.simulate("texture", hand="stroke", seconds=3.0)
    assert identify(from_run(run)).rendered.explained < 0.9


def test_lost_samples_are_a_gap_not_a_jump():
    run = sine_run(300.0, 0.0, 2.0, 0.008)
    kept = np.ones(len(run.time), bool)
    kept[1000:1130] = False
    columns = ("time", "position", "velocity", "force", "applied_force", "hand_force", "flags")
    cut = {name: getattr(run, name)[kept] for name in columns}
    lost = type("Lost", (), {**cut, "settings": run.settings})
    part = identify(from_run(lost)).rendered
    assert part.left_out["lost"] == 130
    assert part["stiffness"].holds(impedance(300.0, 0.0, 2.0, 1000.0, 0.0)[0])


def test_motionless_recordings_give_advice_instead_of_values():
    still = identify(from_run(hs.simulate("spring", seconds=1.0))).rendered
    assert not any(e.determined for e in still.estimates)
    assert "Move" in (still.advice or still.estimates[0].advice)
    away = identify(from_run(hs.simulate("wall", seconds=1.0))).rendered
    assert away.advice == "Unknown: the handle never touched the surface. Push into it."


def test_slow_recordings_do_not_determine_the_damping():
    # the sine has an amplitude of 0.02 mm, which is about one sensor count
    run = sine_run(60.0, 0.0, 0.3, 2e-5, seconds=2.0)
    part = identify(from_run(run)).rendered
    assert not part["damping"].determined
    assert part["damping"].advice.startswith("Unknown. Move faster: the highest speed in these samples is")
    assert math.isfinite(part["stiffness"].half)


def test_a_filter_does_not_move_the_centre():
    centre = 0.010
    values = {"stiffness": 120.0, "damping": 3.0, "center": centre}
    run = hs.simulate("spring", values, hand="shake", estimator="iir", seconds=6.0)
    found = identify(from_run(run)).rendered
    assert found["stiffness"].value > 125.0  # the delay of the filtered velocity stiffens the motion
    assert found["centre"].holds(centre)
    assert 0.5e-6 <= found["centre"].half < 0.5e-3


def test_a_file_contains_the_grip_that_identification_of_the_handle_needs(tmp_path):
    hand, path = Hand(*HAND, several_sines(3), vectorised=True), tmp_path / "own.csv"
    run = hs.simulate("spring", {"stiffness": 150.0}, hand=hand, seconds=3.0)
    run.save(path)
    assert run.settings["hand_grip"] == {"mass": 0.05, "damping": 4.0, "stiffness": 200.0}
    assert np.allclose(run.hand_target, hand.target(run.time), atol=1e-12)
    for part in (identify(from_csv(path)).handle, identify(from_run(run)).handle):
        assert abs(part["mass"].value - 0.094) < 2.0 * part["mass"].half
        assert part["mass"].half < 0.005
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line for line in lines if "hand_grip" not in line]
    assert len(lines) - len(kept) == 3
    path.write_text("".join(kept), encoding="utf-8")
    part = identify(from_csv(path)).handle
    assert not part.estimates
    assert "does not say how the hand held the handle" in part.advice
