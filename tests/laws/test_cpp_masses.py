"""A person's laws of moving masses on the board: whatever pushes them, they move as in Python."""

import numpy as np
import pytest

from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.laws import firmware
from hapkit_studio.parameters import Choice
from hapkit_studio.workshop import firmware as written
from tests.laws import board_laws
from tests.laws.board_laws import Job, needs_compiler
from tests.laws.law_files import environment
from tests.laws.test_cpp_taken import PARAMETERS, STATE, moved, push, text

pytestmark = needs_compiler

METHOD = Choice("method", "Method", INTEGRATORS, "semi_implicit")
BOTH = STATE | {"y": 0.01, "w": 0.0, "c": 0.0}
KEPT = ("s.hand = x", "s.speed = v")


def second(**changed):
    """Return a statement that moves the other mass."""
    return moved("s.y, s.w, s.c", **{"x": "s.y", "v": "s.w", "before": "s.c"} | changed)


LAWS = {
    "by_the_hand_as_it_is_now": text(moved(touch="x", speed="v"), f"return -{push()}"),
    "two_of_other_numbers": text(
        moved(),
        second(m="p.other", f="p.stiffness * 0.012"),
        *KEPT,
        f"return -{push()} - {push(x='s.y', v='s.w')}",
        state=BOTH,
    ),
    "one_on_each_side": text(
        moved(),
        second(side="-1.0"),
        *KEPT,
        f"return {push(x='s.y', v='s.w', side='-1.0')} - {push()}",
        state=BOTH,
    ),
    "one_pushes_the_other": text(
        moved(),
        f"held = {push(x='s.y', v='s.w', touch='s.x', speed='s.v')}",
        second(touch="s.x", speed="s.v"),
        *KEPT,
        f"return -{push()} - 0.1 * held",
        state=BOTH,
    ),
}
NUMBERS = ({}, {"mass": 0.8, "other": 0.4, "rest": 0.0}, {"stiffness": 700.0, "contact": 900.0})


@pytest.fixture(scope="module")
def board(tmp_path_factory):
    """Return the laws' environments, and the program of the board that has them all."""
    folder = tmp_path_factory.mktemp("masses")
    made = {name: environment(folder, words, (*PARAMETERS[:-1], METHOD)) for name, words in LAWS.items()}
    headers = firmware.headers({f"law{n}": e.force for n, e in enumerate(made.values())})
    firmware.write(written.by_hand() | headers, folder / "hapkit")
    driver = folder / "driver"
    words = ["make", "-s", "-C", board_laws.FOLDER, f"BUILD={folder}", f"SKETCH={folder / 'hapkit'}", driver]
    board_laws.subprocess.run(words, check=True)
    return made, driver


@pytest.mark.parametrize("name", LAWS)
def test_masses_move_as_in_python(name, board):
    made, driver = board[0][name], board[1]
    time = np.arange(600) * 1e-3
    x = 0.008 + 0.012 * np.sin(11.0 * time) + 0.004 * np.sin(33.0 * time)
    rows = np.column_stack([x, np.gradient(x, 1e-3)])
    values = [made.values(n | {"method": m}) for n in NUMBERS for m in range(len(INTEGRATORS))]
    jobs = [Job(made, v, 1e-3, rows, number=list(LAWS).index(name)) for v in values]
    for job, (force, _) in zip(jobs, board_laws.run(driver, jobs), strict=True):
        wanted, _ = board_laws.by_python(job)
        assert np.ptp(wanted) > 2.0
        np.testing.assert_allclose(force, wanted, atol=2e-3, rtol=0.0, err_msg=str(job.values))
