"""Every law of the board beside its Python original: the same rows, the same force.

The board reckons in single precision with tables; both get the same single-precision numbers. One step at a
time from the same state covers every method, also those that grow: 2 mN. Freely running they stay as close
for the length of a recording, and switch as often.
"""

import itertools

import numpy as np
import pytest

from hapkit_studio import simulate
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Choice
from tests.laws import board_laws
from tests.laws.board_laws import ENVIRONMENTS, Job, by_python, needs_compiler, single

pytestmark = needs_compiler

BOUND = 2e-3  # N
COUNT = 20.7e-6  # m
HANDS = ("sweep", "tap", "shake")
RATE = 1000.0


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    """Return the board's laws, built with the sanitizers."""
    return board_laws.build(tmp_path_factory.mktemp("laws"), "driver")


def numbers(environment, rng):
    """Return sets of numbers: as declared, both ends, one anywhere between."""
    declared = [p for p in environment.parameters if not isinstance(p, Choice)]
    ends = [{p.key: p.low for p in declared}, {p.key: p.high for p in declared}]
    return [{}, *ends, {p.key: rng.uniform(p.low, p.high) for p in declared}]


def settings(environment, rng):
    """Return the values of every choice with every set of numbers that goes together."""
    choices = [p for p in environment.parameters if isinstance(p, Choice) and p.key != "picture"]
    found = []
    for options in itertools.product(*(range(len(c.options)) for c in choices)):
        for given in numbers(environment, rng):
            try:
                found.append(
                    environment.values(given | {c.key: o for c, o in zip(choices, options, strict=True)})
                )
            except ParameterError:
                continue
    return found


def recorded(environment, values, hand):
    """Return what the loop saw in a scene, (n, 2), in single precision."""
    run = simulate(environment.key, values, hand=hand, rate=RATE, seconds=0.6)
    return single(np.column_stack([run.position, run.velocity]))


def jobs_of(key):
    """Return the jobs of an environment: its settings under three hands."""
    environment, rng = ENVIRONMENTS[key], np.random.default_rng(20241107)
    return [
        Job(environment, values, 1.0 / RATE, recorded(environment, values, HANDS[n % len(HANDS)]))
        for n, values in enumerate(settings(environment, rng))
    ]


def from_states(job, after):
    """Return the job whose rows start from the states before them."""
    before = np.vstack([job.environment.force.initial_state, after[:-1]])
    return Job(job.environment, job.values, job.period, job.rows, single(before))


def jumps(job):
    """Return where the law's force jumps within 20 nm of a row: a thousandth of a count."""
    sides = []
    for way in (-2e-8, 2e-8):
        rows = job.rows + np.array([way, 0.0])
        moved = Job(job.environment, job.values, job.period, rows, job.states)
        sides.append(_exact_rows(moved, rows))
    return np.abs(sides[1] - sides[0]) > BOUND


def _exact_rows(job, rows):
    force = np.empty(len(rows))
    for k in range(len(rows)):
        one = Job(job.environment, job.values, job.period, rows[k : k + 1], job.states[k : k + 1])
        force[k] = by_python(one, exact=True)[0][0]
    return force


@pytest.mark.parametrize("key", ENVIRONMENTS)
def test_the_board_asks_for_the_same_force(key, driver):
    jobs = [from_states(job, by_python(job)[1]) for job in jobs_of(key)]
    for job, (force, after) in zip(jobs, board_laws.run(driver, jobs), strict=True):
        wanted, state = by_python(job)
        assert np.isfinite(wanted).all()
        apart = ~(np.abs(force - wanted) <= BOUND)
        if apart.any():
            near = Job(job.environment, job.values, job.period, job.rows[apart], job.states[apart])
            assert jumps(near).all(), (job.values, job.rows[apart][:3], force[apart][:3], wanted[apart][:3])
        assert apart.mean() <= 0.01
        ours = (np.abs(after - state) <= 1e-4 * (1.0 + np.abs(state)))[:, told(job)]
        assert np.mean(ours) >= 0.99 if ours.size else True, job.values


SWITCHES = {"button": ("downs", "ups"), "cat": ("swats",), "hard_surface": ("armed",), "friction": ("stuck",)}
# These say by `stuck` only whether the friction is at its most, which is a matter of the last bit.
NEVER_STUCK = ("karnopp", "stribeck", "lugre")


def told(job):
    """Return which of the states say more than a matter of the last bit."""
    names = job.environment.state_names
    rubs = job.environment.key == "friction"
    loose = rubs and job.environment.parameters[0].text(job.values["model"]) in NEVER_STUCK
    return [n for n, name in enumerate(names) if not (loose and name == "stuck")]


@pytest.mark.parametrize("key", [k for k, e in ENVIRONMENTS.items() if e.state_names])
def test_the_board_goes_the_same_way_by_itself(key, driver):
    jobs = jobs_of(key)
    for job, (force, after) in zip(jobs, board_laws.run(driver, jobs), strict=True):
        wanted, state = by_python(job)
        close = np.abs(force - wanted) <= BOUND
        assert close.all(), (job.values, int(np.argmin(close)))
        columns = [n for n in told(job) if job.environment.state_names[n] in SWITCHES.get(key, ())]
        assert switched(after[:, columns]) == switched(state[:, columns]), job.values


def switched(columns):
    """Return how often the columns' values changed."""
    return int((np.diff(columns, axis=0) != 0.0).sum())


def test_a_wrong_law_would_be_seen(driver):
    """Feed the board another stiffness: 1 % of the spring's force must not pass for the same."""
    job = jobs_of("spring")[0]
    wanted, _ = by_python(job)
    wrong = Job(job.environment, job.values | {"stiffness": 80.8}, job.period, job.rows)
    force, _ = board_laws.run(driver, [wrong])[0]
    assert np.abs(force - wanted).max() > BOUND


def test_the_tables_hold_their_bounds(tmp_path):
    made = board_laws.build(tmp_path, "fast")
    done = board_laws.subprocess.run([made], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
