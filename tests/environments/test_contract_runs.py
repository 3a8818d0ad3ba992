"""The contract of every environment that is discovered, in use: reset, rest, limits, the same bits live."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.hand import GRIPS, SCRIPTS, Hand
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from tests.bench.bench_laws import per_tick
from tests.environments.calling import LIBRARY, anywhere
from tests.haptics.support import read

every = pytest.mark.parametrize("key", LIBRARY)
END = 0.05
STILL_AT_THE_END = ("press", "hold", "pluck", "released")


@every
def test_a_new_run_starts_from_the_first_state(key):
    """A run in between, as violent as the device allows, changes nothing of the next."""
    e = LIBRARY[key]
    first = hs.simulate(e, hand="shake", seconds=0.3)
    hs.simulate(e, device=hs.SimulatedHapkit(initial_velocity=2.0, max_force=math.inf), seconds=0.3)
    again = hs.simulate(e, hand="shake", seconds=0.3)
    for name, column in first.columns().items():
        assert column.tobytes() == again.columns()[name].tobytes(), name
    assert np.array_equal(e.force.compiled().initial_state, e.force.initial_state)


def assert_settles(run, environment):
    """No fault, clamp or warning; still at the end, or bounded where the scene says it goes on moving."""
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
@pytest.mark.parametrize("grip", GRIPS)
def test_defaults_come_to_rest_in_every_grip(key, delay, grip):
    """At 1 kHz, held still after a push, and let go at 6 mm, inside what stands around the centre."""
    hand, start, held = Hand(release=0.0), hs.SimulatedHapkit(initial_position=0.006), GRIPS[grip]
    if held is not None:
        hand = Hand(held.mass, held.damping, held.stiffness, lambda t: min(0.03 * t, 0.009))
        start = None
    assert_settles(hs.simulate(key, hand=hand, device=start, delay=delay, seconds=3.0), LIBRARY[key])


@every
@pytest.mark.parametrize("hand", SCRIPTS)
@pytest.mark.parametrize("delay", [0.0, 0.5e-3])
def test_defaults_stay_quiet_under_every_named_hand(key, hand, delay):
    run = hs.simulate(key, hand=hand, delay=delay, seconds=3.0)
    assert run.faults == ()
    assert run.warnings == ()
    assert not (run.flags & ~rows.CLAMPED).any()
    assert np.abs(run.position).max() < END
    if hand in STILL_AT_THE_END:
        assert_settles(run, LIBRARY[key])


@every
def test_no_setting_a_person_can_choose_breaks_a_run(key, rng):
    """Any parameters, loop, hand and start: finite, clamped, quantised, without a fault."""
    e = LIBRARY[key]
    for _ in range(40):
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
    """What the live loop measured, given to a headless run: same velocity, force asked and state."""
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
    assert run.force.tobytes() == np.ascontiguousarray(found[:, rows.ASKED]).tobytes()
    width = run.state.shape[1]
    assert run.state.tobytes() == np.ascontiguousarray(found[:, rows.STATE : rows.STATE + width]).tobytes()


@pytest.mark.slow
def test_the_cost_of_every_law_is_told(capsys):
    """In ns a tick, beside one whose law is free; no time is asked for, only that none gets out of hand."""
    costs = {key: per_tick(e, e.values()) for key, e in LIBRARY.items()}
    with capsys.disabled():
        print("\nns a tick: " + ", ".join(f"{key} {cost:.0f}" for key, cost in costs.items()))
    assert max(costs.values()) < 40.0 * costs["free"]
