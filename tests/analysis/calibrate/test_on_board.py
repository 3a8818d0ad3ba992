"""The same steps on the real firmware in its chip; the virtual board's hand plays the student."""

import pytest

from hapkit_studio.devices.virtual_board import built
from hapkit_studio.errors import NoDataError
from hapkit_studio.protocol.messages import Origin
from tests.analysis.calibrate import student
from tests.analysis.calibrate.student_board import StudentBoard


def settles() -> bool:
    """Tell whether there is a board, with firmware that has settings."""
    if not built():
        return False
    board = StudentBoard()
    board.open()
    try:
        return board.settings().quantum > 0.0
    except NoDataError:  # an image from before there were settings
        return False
    finally:
        board.close()


@pytest.fixture(scope="module", autouse=True)
def _there():
    if not settles():
        pytest.skip("the virtual board is not built")


def test_magnet_and_motor_the_wrong_way_round_are_put_right_and_kept():
    kit = StudentBoard("--sensor-sign", "-1", "--direction", "-1", "--magnet", "777")
    work = student.session(kit)
    try:
        scale = student.hold_at_marks(kit, work, (-0.02, 0.02, 0.0))
        assert scale.sense == -1
        work.use_scale()
        assert work.try_direction().good
        assert work.board.direction == -1
        student.walk(kit, work, 0.03)
        assert work.runner.record(0.01).position[-1] == pytest.approx(0.03, rel=0.01)
        assert kit.force_asked(work.runner, 0.5) == pytest.approx(0.5, rel=0.05)
        student.walk(kit, work, 0.005)
        assert work.store("mine").origin == Origin.STORED
        kit.send("reset")
        assert work.runner.record(0.01).position[-1] == pytest.approx(0.005, abs=1e-4)
        assert work.runner.settings.label == "mine"
    finally:
        kit.close()


@pytest.mark.slow
def test_a_sweep_tells_the_paddle_of_the_virtual_board():
    truth = {"mass": 0.08, "viscous": 0.3, "coulomb": 0.2}
    kit = StudentBoard(*[word for key, value in truth.items() for word in (f"--{key}", str(value))])
    work = student.session(kit)
    try:
        part = work.sweep(4.0).part
        assert [key for key, value in truth.items() if not part[key].holds(value)] == []
        assert part["mass"].half < 0.01 * truth["mass"]
    finally:
        kit.close()
