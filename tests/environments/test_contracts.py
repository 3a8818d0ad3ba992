"""Requirements on every discovered environment: its texts, its law at every corner, and its runs."""

import itertools
import math
import re

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import resources
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.hand import GRIPS, SCRIPTS, Hand
from hapkit_studio.environments.base import Conditions, Environment
from hapkit_studio.environments.bump_valley import height
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.parameters import Choice
from tests.environments.calling import LIBRARY, anywhere, call, corners, drawn
from tests.haptics.support import read

every = pytest.mark.parametrize("key", LIBRARY)
REACH, SPEED, STEP = 0.060, 3.0, 1e-7


@every
def test_is_described(key):
    e = LIBRARY[key]
    assert isinstance(e, Environment)
    assert e.key == key
    assert all(text == text.strip() for text in (e.title, e.summary, e.explanation, e.formula))
    assert "F" in e.formula
    assert len(e.explanation) > 80
    assert 0 < len(e.summary) < 40
    assert "\n" not in e.summary + e.title
    # ``scene`` may name another environment, whose icon and drawing are used; by default they are plain
    if e.scene != key:
        assert resources.path("icons", f"{e.scene}.svg").exists()
    for p in e.parameters:
        assert p.label
        assert p.help, p.key
        assert p.low <= p.default <= p.high
        assert p.check(p.default) == p.default


@pytest.mark.slow
@every
def test_force_is_finite_at_every_corner(key):
    e = LIBRARY[key]
    for values in corners(e):
        state = None
        for x, v in itertools.product((-REACH, -1e-9, 0.0, 0.005, REACH), (-SPEED, 0.0, SPEED)):
            force, state, fault = call(e, values, x, v, state)
            assert math.isfinite(force), (values, x, v)
            assert fault == 0, (values, x, v)
            assert np.isfinite(state).all(), (values, x, v)


@every
def test_curve_is_the_compiled_law(key):
    e = LIBRARY[key]
    position = np.linspace(-REACH, REACH, 61)
    for values in corners(e)[::37]:
        for velocity in (0.0, 0.1, -0.1):
            want = [call(e, values, x, velocity)[0] for x in position]
            got = e.curve(values, position, velocity)
            assert got == pytest.approx(np.array(want), rel=1e-12, abs=1e-12)


@every
def test_theory_has_branches_over_its_axis(key, rng):
    e = LIBRARY[key]
    for theory, reach in ((e.over_position, REACH), (e.over_velocity, 0.6)):
        for _ in range(20):
            axis = np.linspace(-reach, reach, 401)
            force = np.zeros(401) if theory is None else np.atleast_2d(theory(anywhere(e, rng), axis))
            assert force.shape[-1] == 401
            assert not np.isinf(force).any()


@pytest.mark.slow
@every
def test_impedance_bounds_the_slopes_of_the_law(key, rng):
    """At any corner, the force changes no faster with position or speed than declared, except at jumps."""
    e = LIBRARY[key]
    if e.impedance is None:
        return
    x = rng.uniform(-0.05, 0.05, 100)
    for values in corners(e)[::13]:
        stiffness, damping = e.impedance(values)
        slope = np.abs(e.curve(values, x + STEP) - e.curve(values, x)).max() / STEP
        assert slope <= stiffness * (1.0 + 1e-6) + 1e-6, values
        by_speed = (e.curve(values, x, 0.1) - e.curve(values, x)) / 0.1
        by_speed = np.append(by_speed, (e.curve(values, x, -0.1) - e.curve(values, x)) / -0.1)
        assert np.abs(by_speed).max() <= damping * (1.0 + 1e-9) + 1e-9


@every
def test_warns_in_whole_sentences_only_when_pushed(key, rng):
    """Each warning is one line for any values and conditions.

    The defaults with a slow hand have no warning.
    """
    e = LIBRARY[key]
    assert tuple(e.warnings(e.values(), Conditions(speed=0.1))) == ()
    for _ in range(50):
        quantum = rng.choice([0.0, 20.7e-6, 1e-3])
        period, delay = 10 ** rng.uniform(-4, -2), rng.choice([0.0, 1e-3, 0.1])
        estimator, coulomb = str(rng.choice(list(ESTIMATORS))), rng.choice([0.0, 0.1])
        conditions = Conditions(
            1.0 / period, delay, estimator, quantum=quantum, viscous=rng.uniform(0, 2), coulomb=coulomb
        )
        for line in e.warnings(anywhere(e, rng), conditions):
            assert line
            assert "\n" not in line
            assert not line.endswith("!")


@every
def test_incompatible_values_give_a_one_line_error(key, rng):
    """``simulate`` and the window reject values with the text of ``check``."""
    e = LIBRARY[key]
    for values in (drawn(e, rng) for _ in range(200)):
        if complaint := e.check(values):
            assert "\n" not in complaint
            with pytest.raises(ParameterError, match=f"^{re.escape(complaint)}$"):
                e.values(values)
        else:
            assert e.values(values) == values


def felt(e, values, rng):
    """Return the force along a random path from a random or initial state; the seed determines both."""
    way = np.cumsum(rng.uniform(-1.0, 1.0, 300)) * 10.0 ** rng.uniform(-6.0, -2.5)
    x = np.clip(way + rng.uniform(-0.03, 0.03), -REACH, REACH)
    v = np.diff(x, prepend=x[0]) / 1e-3
    initial = np.append(e.force.compiled().initial_state, 0.0)
    state = initial + rng.choice([0.0, 4.0], len(initial)) * rng.uniform(0.0, 1.0, len(initial))
    forces = []
    for where, speed in zip(x, v, strict=True):
        force, state, _ = call(e, values, where, speed, state)
        forces.append(force)
    return np.array(forces)


def feels_another(e, values, changed, rng):
    """Return True if changed values give a different force along the same path."""
    seed = int(rng.integers(2**32))
    before, after = (felt(e, v, np.random.default_rng(seed)) for v in (values, changed))
    return bool((before != after).any())


def another(e, values, name, rng):
    """Return compatible values that differ in one parameter."""
    while True:
        changed = values | {name: anywhere(e, rng)[name]}
        if changed != values and not e.check(changed):
            return changed


@every
def test_unused_parameters_change_no_force(key, rng):
    e = LIBRARY[key]
    for _ in range(60):
        values = anywhere(e, rng)
        for name, reason in e.unused(values).items():
            assert reason
            assert not reason.endswith(".")
            changed = another(e, values, name, rng)
            assert not feels_another(e, values, changed, rng), (name, values, changed)


@pytest.mark.slow
@every
def test_used_parameters_change_the_force_or_the_drawing(key, rng):
    """With every option of every choice, each parameter that is not listed as unused has an effect."""
    e = LIBRARY[key]
    choices = [p for p in e.parameters if isinstance(p, Choice)]
    for options in itertools.product(*(range(len(c.options)) for c in choices)):
        chosen = {c.key: float(option) for c, option in zip(choices, options, strict=True)}
        for parameter in e.parameters:
            assert any(has_effect(e, parameter.key, chosen, rng) for _ in range(60)), (parameter.key, chosen)


def has_effect(e, name, chosen, rng):
    """Return True if changing a parameter has an effect, or if the parameter is declared to have none."""
    values = anywhere(e, rng) | chosen
    if e.check(values):
        return False
    if name in e.unused(values):
        return True
    changed = another(e, values, name, rng)
    if e.key == "bump_valley" and name == "picture":
        x = np.linspace(-0.04, 0.04, 81)
        return bool((height(values, x) != height(changed, x)).any())
    return feels_another(e, values, changed, rng)


END = 0.05
STILL_AT_THE_END = ("press", "hold", "pluck", "released")


@pytest.mark.slow
@every
def test_a_new_run_starts_from_the_first_state(key):
    """A violent run in between does not change the next run."""
    e = LIBRARY[key]
    first = hs.simulate(e, hand="shake", seconds=0.3)
    hs.simulate(e, device=hs.SimulatedHapkit(initial_velocity=2.0, max_force=math.inf), seconds=0.3)
    again = hs.simulate(e, hand="shake", seconds=0.3)
    for name, column in first.columns().items():
        assert column.tobytes() == again.columns()[name].tobytes(), name
    assert np.array_equal(e.force.compiled().initial_state, e.force.initial_state)


def assert_settles(run, environment):
    """Assert that a run has no fault, clamp or warning, and ends at rest.

    A scene that is declared restless only has to stay bounded.
    """
    assert run.faults == ()
    assert run.warnings == ()
    assert not run.flags.any()
    assert np.abs(run.true_position).max() < END
    if environment.restless:
        third = len(run.time) // 3
        early, late = np.ptp(run.true_position[:-third]), np.ptp(run.true_position[-third:])
        assert late <= 1.01 * early + 20.7e-6
        return
    assert np.ptp(run.true_position[-500:]) < 20.7e-6
    assert np.abs(run.true_velocity[-500:]).max() < 2e-3


@every
@pytest.mark.parametrize("delay", [0.0, 0.5e-3])
def test_defaults_come_to_rest_in_every_grip(key, delay):
    """With each grip, the handle is pushed and then held still; without a hand, it is released at 6 mm.

    At 6 mm, the handle is inside objects that are at the centre. The rate is 1 kHz.
    """
    for held in GRIPS.values():
        hand, start = Hand(release=0.0), hs.SimulatedHapkit(initial_position=0.006)
        if held is not None:
            hand = Hand(held.mass, held.damping, held.stiffness, lambda t: min(0.03 * t, 0.009))
            start = None
        assert_settles(hs.simulate(key, hand=hand, device=start, delay=delay, seconds=3.0), LIBRARY[key])


@pytest.mark.slow
@every
@pytest.mark.parametrize("delay", [0.0, 0.5e-3])
def test_defaults_stay_quiet_under_every_named_hand(key, delay):
    for hand in SCRIPTS:
        run = hs.simulate(key, hand=hand, delay=delay, seconds=3.0)
        assert (run.faults, run.warnings) == ((), ()), hand
        assert not (run.flags & ~rows.CLAMPED).any(), hand
        assert np.abs(run.position).max() < END, hand
        if hand in STILL_AT_THE_END:
            assert_settles(run, LIBRARY[key])


@pytest.mark.slow
@every
@pytest.mark.parametrize("count", [4, pytest.param(12, marks=pytest.mark.slow)])
def test_no_setting_within_the_limits_breaks_a_run(key, count, rng):
    """With any parameters, loop, hand and start, a run is finite, limited, quantised, and without a fault."""
    e = LIBRARY[key]
    for _ in range(count):
        start, speed = rng.uniform(-0.04, 0.04), rng.uniform(-1, 1)
        run = hs.simulate(
            e,
            anywhere(e, rng),
            hand=str(rng.choice(list(SCRIPTS))),
            device=hs.SimulatedHapkit(initial_position=start, initial_velocity=speed),
            rate=10 ** rng.uniform(2.0, 4.0),
            delay=rng.choice([0.0, 1e-3, 0.1]) * rng.random(),
            estimator=str(rng.choice(list(ESTIMATORS))),
            seconds=0.3,
        )
        assert run.faults == ()
        assert all(np.isfinite(column).all() for column in run.columns().values())
        assert np.abs(run.applied_force).max() <= 3.0
        assert np.array_equal(run.position, 20.7e-6 * np.floor(run.true_position / 20.7e-6))


@every
def test_the_live_loop_and_simulate_render_the_same_bits(key):
    """A headless run with the live loop's positions gives the same velocity, force and state."""
    e = LIBRARY[key]
    engine = Engine(hs.SimulatedHapkit(initial_position=0.004), e, realtime=False)
    reader = engine.reader()
    engine.set_loop(rate=4000.0)
    engine.move_hand(-0.012)
    engine.start()
    try:
        found = read(reader, lambda table: len(table) >= 300)
        engine.move_hand(0.015)
        found = np.concatenate((found, read(reader, lambda table: len(table) >= 300)))
    finally:
        engine.close()
    assert np.array_equal(found[:, rows.TICK], np.arange(len(found)))
    seen = found[:, rows.POSITION]
    assert np.ptp(seen) > 1e-3
    replay = hs.Prescribed(lambda t: seen[min(round(t * 4000.0), len(seen) - 1)])
    device = hs.SimulatedHapkit(quantum=0.0)
    run = hs.simulate(e, hand=replay, device=device, rate=4000.0, seconds=len(seen) / 4000.0)
    assert run.position.tobytes() == seen.tobytes()
    assert run.velocity.tobytes() == np.ascontiguousarray(found[:, rows.VELOCITY]).tobytes()
    assert run.force.tobytes() == np.ascontiguousarray(found[:, rows.FORCE]).tobytes()
    width = run.state.shape[1]
    assert run.state.tobytes() == np.ascontiguousarray(found[:, rows.STATE : rows.STATE + width]).tobytes()
