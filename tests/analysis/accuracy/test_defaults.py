"""What the product uses is the cheapest within the tolerance, in every scene of every chart."""

import pytest

from hapkit_studio import environments
from hapkit_studio.analysis import accuracy
from hapkit_studio.analysis.accuracy import words
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics.settings_writer import LoopSettings

SCENES = [(plan.key, scene.key) for plan in accuracy.plans().values() for scene in plan.scenes]
# other programs may disturb a measurement, never three in a row
TRIES = 3


@pytest.mark.alone
@pytest.mark.parametrize(("chart", "scene"), SCENES)
def test_the_default_is_the_cheapest_within_the_tolerance(chart, scene):
    for _ in range(TRIES):
        (sheet,) = accuracy.compute([chart], scene).sheets
        if sheet.answer.right:
            break
    assert sheet.answer.right, f"{words.sentence(sheet)} {words.verdict(sheet)}"
    assert sheet.answer.default.error <= sheet.scene.tolerance
    assert sheet.scene.reason


def test_the_defaults_are_the_products_own():
    plans = accuracy.plans()

    def default(chart, scene):
        return next(s.default for s in plans[chart].scenes if s.key == scene)

    for scene, key in (("damped", "mass_spring_damper"), ("contact", "puck")):
        environment = environments.named(key)
        choice = INTEGRATORS[int(environment.values()["integrator"])]
        assert default("integrators", scene).method == choice
    friction = environments.named("friction")
    model = next(p for p in friction.parameters if p.key == "model")
    assert default("friction", "handle").method == model.text(friction.values()["model"])
    assert default("servo", "contact").step_s == 1.0 / LoopSettings().rate


def test_the_charts_and_their_scenes():
    assert list(accuracy.plans()) == ["integrators", "velocity", "servo", "friction"]
    assert len(SCENES) == len(set(SCENES)) == 16


@pytest.mark.slow
def test_progress_tells_every_scene_and_may_stop_the_work():
    told = []
    found = accuracy.compute(["servo"], progress=lambda done, of: told.append((done, of)))
    assert told == [(0, 2), (1, 2), (2, 2)]
    assert {row["chart"] for row in found.rows()} == {"servo"}

    class Stopped(Exception):
        pass

    def stop(done, of):
        raise Stopped

    with pytest.raises(Stopped):
        accuracy.compute(["servo"], progress=stop)


@pytest.mark.parametrize(
    ("charts", "scene", "names"),
    [
        (["speed"], None, "no accuracy chart 'speed'; there are: integrators, velocity, servo, friction"),
        (["servo"], "damped", "no scene 'damped' in these charts; there are: stiffness, contact"),
    ],
)
def test_refuses_what_there_is_not(charts, scene, names):
    with pytest.raises(ParameterError, match=names):
        accuracy.compute(charts, scene)
