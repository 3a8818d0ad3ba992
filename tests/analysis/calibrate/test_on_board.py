"""The calibration steps run on the firmware in a simulated chip; the virtual board's hand is the student."""

import numpy as np
import pytest

from hapkit_studio.analysis.calibrate.calibration import Calibration
from hapkit_studio.devices.board_runner import BoardRunner, Limits
from hapkit_studio.devices.virtual_board import VirtualBoard, built, truth
from hapkit_studio.protocol.messages import Alive, Origin, Save

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not built(), reason="the virtual board is not built")]


class PatientBoard(VirtualBoard):
    """A virtual board with long time-outs, for busy machines."""

    def save(self):
        # in lockstep every frame advances the board's time, and saving takes a third of a second
        self.send_messages(Save(), *[Alive()] * 60)
        return self.settings()

    def request(self, message, reply, seconds=30.0):
        return super().request(message, reply, 30.0)

    def samples(self, silence=30.0):
        return super().samples(30.0)


@pytest.fixture
def begin():
    """Return a function that opens a board with options and starts its calibration."""
    boards = []

    def opened(*options, log=None):
        boards.append(PatientBoard("lockstep", log, options=("--answer-timeout", "0.02", *options)))
        runner = BoardRunner(boards[0])
        runner.open()
        return boards[0], Calibration(runner)

    yield opened
    boards[0].close()


def position(work, board, place):
    """Return the position that the board reports when the handle is moved to ``place`` m."""
    board.send(f"position {place} 0.2")
    work.runner.record(0.3)
    return work.runner.record(0.01).position[-1]


def test_reversed_magnet_and_motor_are_corrected_and_saved(begin):
    board, work = begin("--sensor-sign", "-1", "--direction", "-1", "--magnet", "777")
    for place in (-0.02, 0.02):
        position(work, board, place)
        work.take_mark(place)
    assert work.measure_scale().sense == -1
    work.use_scale()
    position(work, board, 0.0)
    board.send("release")
    assert work.try_direction().good
    assert work.board.direction == -1
    assert position(work, board, 0.03) == pytest.approx(0.03, rel=0.01)
    position(work, board, 0.005)
    assert work.store("mine").origin == Origin.STORED
    board.send("reset")
    assert work.runner.record(0.01).position[-1] == pytest.approx(0.005, abs=1e-4)
    assert work.runner.settings.label == "mine"


def test_a_sweep_determines_the_paddle_of_the_virtual_board(begin):
    truth = {"mass": 0.08, "viscous": 0.3, "coulomb": 0.2}
    _, work = begin(*[word for key, value in truth.items() for word in (f"--{key}", str(value))])
    part = work.sweep(4.0).part
    assert [key for key, value in truth.items() if not part[key].holds(value)] == []
    assert part["mass"].half < 0.01 * truth["mass"]


def test_two_springs_correct_a_motor_at_90_percent_on_the_board(begin, tmp_path):
    log = tmp_path / "truth.f64"
    board, work = begin("--torque", str(0.9 * 0.0183), log=log)

    def felt():
        """Render 150 N/m to a moving hand.

        Return the effective stiffness from the board's log of true values.
        """
        board.flush()
        before = len(truth(log))
        board.send("hand 0.008 400 8 0.1 1.0")
        work.runner.run(lambda t, x, v: -150.0 * x, 1.5, Limits(2.0))
        board.flush()
        rows = truth(log)[before:]
        rows = rows[rows.duty != 0.0]
        board.send("release")
        return -np.polyfit(rows.position, rows.motor_force, 1)[0]

    assert felt() == pytest.approx(135.0, rel=0.02)
    work.runner.record(1.0)
    for stiffness in (100.0, 300.0):
        work.pull(stiffness)
    found = work.use_springs()
    assert found.ratio == pytest.approx(0.90, rel=0.01)
    assert felt() == pytest.approx(150.0, rel=0.02)
