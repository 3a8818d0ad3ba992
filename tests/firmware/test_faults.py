"""Every fault stays within its bounds of force and time, and no wrong positions are recorded."""

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from tests.firmware.faults import BOARD_RENDERS, CASES, RECOVER, TESTED, no_spam
from tests.firmware.faults_table import Measured
from tests.firmware.vb import FULL_FORCE, needs_board
from tests.wide import wide

pytestmark = needs_board

LIMIT = 3.0 * (1.0 + 1.0 / 255.0)
"""The board's limit in N, and half a duty step at full duty."""
STALES = {
    "none": 0,
    "to the board nothing for 300 ms": 1,
    "from the board nothing for 300 ms": 1,
    "from the board nothing for 40 ms, three times": 3,
}
QUICK = (
    *STALES,
    "1 % of bytes flipped to the board",
    "bursts of 40 bytes from the board",
    "USB latency 16 ms",
    "cable pulled and put back",
    "program killed",
    "sensor stuck",
    "line full of garbage",
    f"board reset in mid-motion{BOARD_RENDERS}",
    f"line full of valid commands{BOARD_RENDERS}",
)
"""One case per kind of fault; `make test-all` runs all cases."""


@pytest.fixture(scope="module")
def measured():
    """Return a function that measures a case by name, in a separate process that uses the board's clock."""
    command = [sys.executable, "-m", "tests.firmware.faults_table", "--serve"]
    program = subprocess.Popen(
        command, cwd=Path(__file__).parents[2], env=os.environ, stdin=-1, stdout=-1, text=True
    )

    @cache
    def measure(name: str) -> Measured:
        program.stdin.write(f"{name}\n")
        program.stdin.flush()
        return Measured(**json.loads(program.stdout.readline()))

    yield measure
    program.communicate()


def test_names_are_unique_and_the_quick_cases_exist():
    assert len({case.name for case in CASES}) == len(CASES)
    assert set(QUICK) <= {case.name for case in TESTED}


@pytest.mark.slow
@pytest.mark.parametrize("case", wide(TESTED, lambda case: case.name in QUICK), ids=lambda case: case.name)
def test_faults_stay_within_their_bounds(case, measured):
    found = measured(case.name)
    assert 0.3 < found.peak <= min(LIMIT, FULL_FORCE)
    if case.off is not None:
        assert 0.0 <= found.off <= case.off + 2e-4
        assert found.on_while_off == 0.0
    if case.back is not None:
        assert 0.0 < found.back <= case.back
    least = 0.4 if case.killed < case.seconds else 0.6
    assert found.rows > least * 1000 * (case.seconds - 0.3 * (case.off is not None))
    assert found.wrong_rows == found.unmarked_gaps == 0
    assert found.foreign == 0  # every force that the motor had was sent before
    assert found.late_ticks == found.overruns == 0
    assert found.fault in case.latched
    if found.hurt_to:
        assert found.counted > 0
    if found.hurt_from:
        assert found.lost > 0
        assert found.bad > 0
    if case.options or found.hurt_to:
        assert found.lost <= case.board  # a board that takes over skips one sample
        assert found.bad == 0
    if case.lossy and not case.options and case.spam is no_spam and not case.board:
        assert found.hurt_to + found.hurt_from > 30
    assert found.stale == STALES.get(case.name, found.stale)
    if case.name == "none":
        assert found.lost == found.bad == found.counted == found.fault == found.silent_offs == 0
    if case.name == "to the board nothing for 300 ms":  # meanwhile the board has switched its motor off
        assert found.back >= RECOVER
