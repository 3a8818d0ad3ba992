"""The verdict on a scene is the same in window, runs, sketches and commands."""

from dataclasses import replace

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import environments
from hapkit_studio.analysis.stability.objects import contact_limit
from hapkit_studio.analysis.stability.verdict import (
    VerdictInput,
    differs,
    of_spring,
    unstable_ranges,
    verdict,
)
from hapkit_studio.dynamics.hand import grip_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from tests.analysis.stability.independent import Handle

LATE = LoopSettings(delay=1e-3, hand="medium")


def asked(key, setting=LATE, **values):
    environment = environments.named(key)
    return VerdictInput(environment, environment.values(values), setting)


@pytest.mark.slow
def test_a_stiff_wall_is_calm_when_released_and_buzzes_in_a_grip():
    """A wall of 5,000 N/m is too stiff for 1 ms of delay, but a released handle leaves the wall."""
    found = verdict(asked("wall", stiffness=5000.0, damping=0.0))
    held, released = found.lines
    assert held.startswith("In your hand, a push of more than 0.")
    assert released == "After you let go, the handle moves away and cannot buzz."
    assert [token for *_, token in found.signed] == ["warn", "ok"]
    assert (found.headline, found.sign) == ("Buzzes after a push", ("triangle", "warn"))
    grip = grip_named("medium")
    handle = Handle(
        0.044, 0.5, 0.1, 20.7e-6, 3.0, 1000.0, 1e-3, 5000.0, 0.0, True,
        (grip.mass, grip.damping, grip.stiffness), (0.49, 0.16),
    )  # fmt: skip
    pressed = 1.0 / 5000.0 + 1.0 / grip.stiffness
    last = handle.let_go(1.0 / 5000.0 + 1e-3, pressed, 2.0)[-500:]
    assert np.ptp(last) > 2e-4, "1 mm from where a press of 1 N has it, the handle goes on"


def test_calm_scenes_state_the_margin_in_each_hand():
    found = verdict(asked("spring", stiffness=80.0))
    assert found.calm
    assert found.sign == ("check", "ok")
    limits = [found.margins[hand].limit for hand in ("medium", "released")]
    assert limits[0] > limits[1]
    assert found.short == f"Stable, {limits[1] / 80.0:.1f} × below the limit"


@pytest.mark.parametrize(("share", "calm"), [(0.97, True), (1.03, False)])
def test_without_friction_and_counts_the_verdict_agrees_with_the_linear_limit(share, calm):
    setting = LoopSettings(coulomb=0.0, quantum=0.0)
    bound = of_spring(setting, 100.0, 0.0).limit
    assert of_spring(setting, share * bound, 0.0).does["released"].calm == calm


@pytest.mark.parametrize("parameter", ["stiffness", "damping"])
def test_a_nudge_settles_at_the_end_of_the_unstable_range(parameter):
    """Stiffness is tested at the lower end of its unstable range, damping at the upper end."""
    setting = replace(LATE, hand="released", estimator="difference")
    values = {"stiffness": 700.0, "damping": 0.0, "center": 0.0}
    values["stiffness"] = 700.0 if parameter == "stiffness" else 1300.0
    (low, high), *_ = unstable_ranges(asked("spring", setting, **values))[parameter]
    edge, more = (low, 1.0) if parameter == "stiffness" else (high, -1.0)
    for step, settles in ((-0.06, True), (0.06, False)):
        values[parameter] = edge * (1.0 + more * step)
        push = verdict(asked("spring", setting, **values)).does["released"].push
        assert (push > 1e-3) == settles


def test_unstable_damping_does_not_settle_after_a_kick():
    """Damping has no restoring force, so the handle is kicked, with the energy of 1 mm on 100 N/m.

    The end of the unstable range is accurate to 1.6 N·s/m.
    """
    ((low, high),) = unstable_ranges(asked("damping"))["damping"]
    assert high == 50.0
    for damping, settles in ((low - 2.0, True), (low + 2.0, False)):
        handle = Handle(0.044, 0.5, 0.1, 20.7e-6, 3.0, 1000.0, 1e-3, 0.0, damping)
        speed = 1e-3 * np.sqrt(100.0 / 0.044)
        moves = [np.ptp(handle.let_go(0.0, 0.0, 2.0, way * speed)[-500:]) for way in (1.0, -1.0)]
        assert (max(moves) <= 20.7e-6) == settles


def test_an_unstable_wall_does_not_settle_in_the_hand():
    """A wall is pressed with 1 and 2 N.

    The unstable range starts within 156 N/m of the first stiffness at which a nudge oscillates.
    """
    ((low, high),) = unstable_ranges(asked("wall"))["stiffness"]
    assert high == 5000.0
    grip = grip_named("medium")
    for stiffness, settles in ((low - 200.0, True), (low + 200.0, False)):
        handle = Handle(
            0.044, 0.5, 0.1, 20.7e-6, 3.0, 1000.0, 1e-3, stiffness, 0.0, True,
            (grip.mass, grip.damping, grip.stiffness),
        )  # fmt: skip
        places = [press / stiffness for press in (1.0, 2.0)]
        runs = [handle.let_go(x + 1e-3, x * (1.0 + stiffness / grip.stiffness), 4.0)[-1000:] for x in places]
        assert (max(map(np.ptp, runs)) <= 20.7e-6) == settles


def test_parameters_without_effect_have_no_unstable_range():
    assert "center" not in unstable_ranges(asked("spring", stiffness=1800.0))
    assert unstable_ranges(asked("free")) == {}


def test_a_law_with_a_false_impedance_is_judged_without_limit(tmp_path):
    """A student's wall is ten times as stiff as the impedance that was copied from the template."""
    spring = environments.named("spring")
    own = replace(spring, key="own", impedance=lambda values: (30.0, 0.0))
    scene = VerdictInput(own, own.values({"stiffness": 300.0}), LATE)
    found = verdict(scene)
    assert (
        found.unknown
        == "The limit cannot be computed: the law reaches a value of 300 N/m, but its `impedance` states "
        "30 N/m. Correct the law or `impedance`."
    )
    assert found.margins == {}
    assert found.lines[1] == "After you let go, the handle is stable."
    assert differs(replace(own, impedance=spring.impedance), scene.values, (300.0, 0.0)) == ""


@pytest.mark.parametrize(("stiffness", "calm"), [(900.0, True), (1800.0, False)])
def test_every_unstable_run_gets_a_warning(stiffness, calm):
    run = hs.simulate("spring", {"stiffness": stiffness}, hand="pluck")
    still = np.ptp(run.true_position[-400:]) < 2e-5
    assert still == calm
    assert ("If you displace the handle by more than" in " ".join(run.warnings)) != calm


@pytest.mark.parametrize(
    ("share", "text"), [(0.99, "1.01 × below the limit"), (1.01, "nothing presses the handle")]
)
def test_a_released_handle_does_not_press_an_object(share, text):
    scene, loop = environments.named("puck"), LoopSettings()
    stiffness = share * contact_limit(loop, "puck", scene.values())
    found = verdict(VerdictInput(scene, scene.values({"contact_stiffness": stiffness}), loop))
    assert found.does["released"].calm
    assert text in found.lines[-1]
