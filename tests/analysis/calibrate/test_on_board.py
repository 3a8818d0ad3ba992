"""The same steps on the real firmware in its chip; the virtual board's hand plays the student."""

import pytest

from hapkit_studio.devices.board_runner import Limits
from hapkit_studio.devices.virtual_board import VirtualBoard, built
from hapkit_studio.errors import NoDataError
from hapkit_studio.protocol.messages import Alive, Origin, Save
from tests.analysis.calibrate import student

PATIENCE = 30.0
"""s: a busy machine may simulate slowly, and nothing here depends on it."""
FOLLOWS = 0.004
"""s in which the hand is where it was led: nobody jumps."""


class StudentBoard(VirtualBoard):
    """Answers to ``hand`` (m, None lets go), ``weight`` (N) and ``student``, called at every sample."""

    def __init__(self, *options):
        super().__init__("lockstep", options=("--answer-timeout", "0.02", *options))
        self.time, self.x, self.v = 0.0, 0.0, 0.0
        self.student = lambda kit: None
        self._hand, self._weight = None, 0.0

    @property
    def hand(self):
        return self._hand

    @hand.setter
    def hand(self, place):
        if place == self._hand:
            return
        self._hand = place
        if place is None:
            self.send("release")
        else:
            self.x = place
            self.send(f"position {place:.9f} {FOLLOWS}")

    @property
    def weight(self):
        return self._weight

    @weight.setter
    def weight(self, force):
        self._weight = force
        self.send(f"force {force:.6f}")

    def open(self, *words):
        super().open(*words)
        self._serial.write_timeout = PATIENCE

    def save(self):
        # in lockstep every frame buys some time of the board, and writing takes a third of a second
        self.send_messages(Save(), *[Alive()] * 60)
        return self.settings()

    def request(self, message, reply, seconds=PATIENCE):
        return super().request(message, reply, PATIENCE)

    def samples(self, silence=PATIENCE):
        for sample in super().samples(PATIENCE):
            self.time = 1e-6 * sample.time_us
            self.student(self)
            yield sample

    def force_asked(self, runner, force):
        """Return the real force in N, by the board's truth, while one is asked and a hand holds."""
        real = []

        def pushing(t, x, v):
            if t > 0.02 and not real:
                real.append(self.status()["motor_force"])
            return force

        self.hand = self.x
        runner.run(pushing, 0.03, Limits(3.0))
        return real[0]


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
