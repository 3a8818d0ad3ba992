"""The contract of every environment that is discovered, and what each of the first four must show."""

import itertools
import math
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import environments, resources
from hapkit_studio.dynamics.hand import GRIPS, SCRIPTS, Hand
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rows
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice
from tests.environments.calling import LIBRARY, call

every = pytest.mark.parametrize("key", LIBRARY)
REACH, SPEED = 0.060, 3.0


def corners(environment):
    """Return every combination of the least, the default and the largest value of each parameter."""
    each = []
    for p in environment.parameters:
        some = range(len(p.options)) if isinstance(p, Choice) else (p.low, p.default, p.high)
        each.append([(p.key, float(value)) for value in some])
    every = [dict(corner) for corner in itertools.product(*each)]
    return every if len(every) <= 800 else every[:: len(every) // 800]


def test_finds_the_files_of_its_folder_by_themselves():
    folder = environments.__path__[0]
    files = {path.stem for path in Path(folder).glob("*.py")} - {"__init__", "base"}
    assert set(LIBRARY) == files
    assert {"free", "spring", "wall", "damping"} <= files
    assert hs.environments() == LIBRARY
    assert hs.environments is environments


@every
def test_is_described(key):
    e = LIBRARY[key]
    assert isinstance(e, Environment)
    assert e.key == key
    for words in (e.title, e.summary, e.explanation, e.formula):
        assert words
        assert words == words.strip()
    assert "F" in e.formula
    assert len(e.explanation) > 80
    assert "\n" not in e.summary
    assert len(e.summary) < 40
    assert resources.path("icons", f"{e.scene}.svg").exists()
    for p in e.parameters:
        assert p.label
        assert p.help, p.key
        assert p.low <= p.default <= p.high
        assert p.check(p.default) == p.default


@every
def test_has_a_drawing(key):
    scenes = Path(hs.__file__).parent / "gui" / "scenes"
    assert (scenes / f"{LIBRARY[key].scene}.py").exists()


def test_keys_shortcuts_and_titles_are_their_own():
    for values in ([e.shortcut for e in LIBRARY.values() if e.shortcut], [e.title for e in LIBRARY.values()]):
        assert len(set(values)) == len(values)


@every
def test_force_is_finite_at_every_corner(key):
    e = LIBRARY[key]
    for values in corners(e):
        state = None
        for x, v in itertools.product((-REACH, -1e-9, 0.0, 0.005, REACH), (-SPEED, 0.0, SPEED)):
            force, state, fault = call(e, values, x, v, state)
            assert math.isfinite(force), (values, x, v)
            assert fault == 0
            assert np.isfinite(state).all()


@every
def test_every_corner_of_the_handle_is_finite_too(key, rng):
    e = LIBRARY[key]
    for _ in range(300):
        values = {
            p.key: float(rng.integers(0, 2)) if p.discrete else rng.uniform(p.low, p.high)
            for p in e.parameters
        }
        force, _, fault = call(e, values, rng.uniform(-REACH, REACH), rng.uniform(-SPEED, SPEED))
        assert math.isfinite(force)
        assert fault == 0


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


@every
@pytest.mark.parametrize("delay", [0.0, 0.5e-3])
def test_defaults_come_to_rest_under_every_hand(key, delay):
    """At 1 kHz, held still by every grip after a push, and let go: no fault, no clamp, no motion at the end.

    The release is at 6 mm, inside what the environments render around the centre.
    """
    for grip in GRIPS.values():
        if grip is None:
            hand, start = Hand(release=0.0), hs.SimulatedHapkit(initial_position=0.006)
        else:
            hand = Hand(grip.mass, grip.damping, grip.stiffness, lambda t: min(0.03 * t, 0.009))
            start = None
        run = hs.simulate(key, hand=hand, device=start, delay=delay, seconds=3.0)
        assert run.faults == ()
        assert not run.flags.any()
        tail = run.true_position[-500:]
        assert np.ptp(tail) < 20.7e-6, grip
        assert np.abs(run.true_velocity[-500:]).max() < 2e-3


@every
@pytest.mark.parametrize("hand", SCRIPTS)
def test_defaults_stay_quiet_under_every_named_hand(key, hand):
    for delay in (0.0, 0.5e-3):
        run = hs.simulate(key, hand=hand, delay=delay, seconds=3.0)
        assert run.faults == ()
        assert not (run.flags & ~rows.CLAMPED).any()
        assert np.abs(run.position).max() < 0.05
        if hand in ("press", "hold", "released"):
            assert not run.flags.any()
            assert np.ptp(run.true_position[-500:]) < 20.7e-6


@every
def test_curve_is_the_compiled_law(key):
    e = LIBRARY[key]
    position = np.linspace(-REACH, REACH, 241)
    for values in corners(e)[::7]:
        for velocity in (0.0, 0.1, -0.1):
            want = [call(e, values, x, velocity)[0] for x in position]
            assert e.curve(values, position, velocity) == pytest.approx(np.array(want), rel=1e-14, abs=1e-14)


@every
def test_impedance_bounds_the_slopes_of_the_law(key):
    """No faster rise of force with position or speed than it says, anywhere, at any corner."""
    e = LIBRARY[key]
    if e.impedance is None:
        return
    x = np.linspace(-0.05, 0.05, 100)
    for values in corners(e)[::5]:
        stiffness, damping = e.impedance(values)
        slope = np.abs(np.diff(e.curve(values, x)) / np.diff(x)).max()
        assert slope <= stiffness * (1.0 + 1e-9)
        by_speed = (e.curve(values, x, 0.1) - e.curve(values, x)) / 0.1
        by_speed = np.append(by_speed, (e.curve(values, x, -0.1) - e.curve(values, x)) / -0.1)
        assert np.abs(by_speed).max() <= damping * (1.0 + 1e-9) + 1e-9


def test_unknown_environments_are_named_with_those_there_are():
    for wrong in ("wal", "", 5, None, ["wall"], {"wall"}):
        with pytest.raises(
            ParameterError, match=r"There is no environment .*; there are: free, spring, wall"
        ):
            environments.named(wrong)


@every
def test_no_setting_a_person_can_choose_breaks_a_run(key, rng):
    """Any parameters, loop, hand and start: finite, clamped, quantised, without a fault."""
    e = LIBRARY[key]
    for _ in range(40):
        values = {
            p.key: str(rng.choice(p.options)) if isinstance(p, Choice) else rng.uniform(p.low, p.high)
            for p in e.parameters
        }
        run = hs.simulate(
            e,
            values,
            hand=str(rng.choice(list(SCRIPTS))),
            device=hs.SimulatedHapkit(
                initial_position=rng.uniform(-0.04, 0.04), initial_velocity=rng.uniform(-1, 1)
            ),
            rate=10 ** rng.uniform(2.0, 4.0),
            delay=rng.choice([0.0, 1e-3, 0.1]) * rng.random(),
            estimator=["difference", "iir", ("iir", {"cutoff": 1.0}), ("iir", {"cutoff": 2000.0})][
                rng.integers(4)
            ],
            seconds=0.3,
        )
        assert run.faults == ()
        assert all(np.isfinite(column).all() for column in run.columns().values())
        assert np.abs(run.applied_force).max() <= 3.0
        assert np.array_equal(run.position, 20.7e-6 * np.floor(run.true_position / 20.7e-6))


def test_environments_of_other_packages_are_found(monkeypatch):
    """By the entry-point group, behind those of this package."""

    @law
    def force(p, s, x, v, dt):
        return -x

    mine = Environment("mine", "Mine", "From elsewhere", (), force)

    class Point:
        def load(self):
            return mine

    def points(group):
        assert group == "hapkit_studio.environments"
        return [Point()]

    monkeypatch.setattr(environments, "entry_points", points)
    found = environments.discover.__wrapped__()
    assert found["mine"] is mine
    assert list(found)[: len(LIBRARY)] == list(LIBRARY)
    assert hs.simulate(mine, device=hs.SimulatedHapkit(initial_position=0.01), seconds=0.01).force[0] < 0.0


def test_a_broken_environment_of_another_package_is_left_out_with_a_warning(monkeypatch):
    broken = EntryPoint("torn", "no_such_module_anywhere:ENVIRONMENT", environments.ENTRY_POINTS)
    monkeypatch.setattr(environments, "entry_points", lambda group: [broken])
    with pytest.warns(UserWarning, match="'torn'.*cannot be loaded.*no_such_module_anywhere"):
        found = environments.discover.__wrapped__()
    assert list(found) == list(LIBRARY)


def test_the_library_cannot_be_changed_by_who_asks_for_it():
    with pytest.raises(TypeError):
        environments.discover()["mine"] = LIBRARY["wall"]
