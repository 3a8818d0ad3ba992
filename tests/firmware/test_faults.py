"""Every fault within its bounds: force, time until off and until back, nothing recorded wrongly."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from hapkit_studio.haptics import arrays
from tests.firmware.faults import CASES, END, PERIOD, RECOVER, START, TESTED, no_spam
from tests.firmware.vb import FULL_FORCE, needs_board

pytestmark = needs_board

LIMIT = 3.0 * (1.0 + 1.0 / 255.0)
"""N: the limit of the board and half a step of its duty, at most full duty."""
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def measured():
    """Run all cases in one process of their own: the loop's clock is the board's there."""
    words = [sys.executable, "-m", "tests.firmware.faults_table", "--json"]
    done = subprocess.run(words, cwd=ROOT, env=os.environ, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return {one["name"]: one for one in json.loads(done.stdout)}


@pytest.fixture(params=TESTED, ids=lambda case: case.name)
def case(request):
    return request.param


@pytest.fixture
def found(case, measured):
    return measured[case.name]


def test_names_differ():
    assert len({case.name for case in CASES}) == len(CASES)


def test_the_force_stays_below_the_limit(found):
    assert 0.3 < found["peak"] <= min(LIMIT, FULL_FORCE)


def test_the_motor_is_off_in_time_and_stays_off(case, found):
    if case.off is not None:
        assert 0.0 <= found["off"] <= case.off + 2e-4
        assert found["on_while_off"] == 0.0


def test_the_force_comes_back_in_time(case, found):
    if case.back is not None:
        assert 0.0 < found["back"] <= case.back


def test_nothing_is_recorded_wrongly(case, found):
    least = 0.4 if case.killed < case.seconds else 0.6
    assert found["rows"] > least * 1000 * (case.seconds - 0.3 * (case.off is not None))
    assert found["wrong_rows"] == 0
    assert found["unmarked_gaps"] == 0


def test_no_force_was_obeyed_that_nobody_sent(found):
    assert found["foreign"] == 0


def test_the_board_keeps_its_ticks_and_its_bytes(found):
    assert found["late_ticks"] == 0
    assert found["overruns"] == 0


def test_faults_latch_where_they_must_and_nowhere_else(case, found):
    assert found["fault"] in case.latched


def test_damage_is_counted_by_whoever_saw_it(case, found):
    if found["hurt_to"]:
        assert found["told"] > 0
    if found["hurt_from"]:
        assert found["lost"] > 0
        assert found["bad"] > 0
    if case.options or found["hurt_to"]:
        # a board that takes over leaves out one sample
        assert found["lost"] <= case.board
        assert found["bad"] == 0


def test_every_damage_was_done(case, found):
    if case.lossy and not case.options and case.spam is no_spam and not case.board:
        assert found["hurt_to"] + found["hurt_from"] > 30


def test_a_board_that_cut_its_motor_off_gets_no_full_force_at_once(measured):
    again = measured["to the board nothing for 300 ms"]
    assert again["stale"] == 1
    assert again["back"] >= RECOVER


def test_a_single_stall_is_no_latched_fault(measured):
    assert measured["from the board nothing for 300 ms"]["stale"] == 1
    assert measured["from the board nothing for 40 ms, three times"]["stale"] == 3


def test_without_a_fault_nothing_is_lost_and_nothing_late(measured):
    assert {measured["none"][key] for key in ("lost", "bad", "told", "stale", "fault", "silent_offs")} == {0}
    assert START + 20 * PERIOD < END  # the windows above are long enough to see
    assert measured["none"]["fault"] == arrays.NO_FAULT
