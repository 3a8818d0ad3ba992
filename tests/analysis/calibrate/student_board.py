"""The virtual board as the student's kit: the same hand and weights as the kit in this process has."""

from hapkit_studio.devices.board_runner import Limits
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.protocol.messages import Alive, Save

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
