"""A simulated kit in this process: board, motor, sensor, paddle, and a hand that the test moves."""

import math
import time
from dataclasses import fields

import numpy as np

from hapkit_studio.devices.base import Device
from hapkit_studio.devices.profiles import default
from hapkit_studio.dynamics.paddle import advance, transition
from hapkit_studio.errors import DeviceError, ParameterError
from hapkit_studio.protocol.messages import Board, BoardFlag, Force, Origin, Release, Sample, Settings, Stop
from tests.devices.fake_board import HELLO_FIELDS

PERIOD = 1e-3
HANDLE, STOP = 0.090, 0.055
"""The handle's radius, and the position of its end stops, in m."""
EVERY = 20
ANSWER = 0.4e-3
"""Time in s from a sample until its force takes effect, by the serial line and the board."""


class PaddleKit(Device):
    """A kit with the interface of HapkitBoard. ``settings`` are those stored on its board.

    The other arguments are its true properties:

    - ``mass``, ``viscous``, ``coulomb``: properties of the paddle;
    - ``sense``, ``direction``: -1 for a reversed magnet, and for swapped motor wires;
    - ``supply``: 0 if there is no supply;
    - ``dead``: the duty below which the motor gives no torque;
    - ``noise``: the sensor's standard deviation in counts;
    - ``weight``, ``spring``: a pull in N, and a spring in N/m between handle and middle;
    - ``pace``: real s per period;
    - ``student``: student(kit) is called every period, and may set ``hand`` to a position in m or None.
    """

    title = "Hapkit on test"

    def __init__(
        self, board=None, *, mass=0.044, viscous=0.5, coulomb=0.10, sense=1, direction=1, magnet=300.0,
        torque=0.0183, pulley=0.005, sector=0.074, counts=921, lowest=51, supply=1.0, dead=0,
        noise=0.0, stuck=False, pace=0.0,
    ):  # fmt: skip
        self.mass, self.viscous, self.coulomb = mass, viscous, coulomb
        self.silence, self.pace = 0, pace
        self.sense, self.direction, self.magnet = sense, direction, magnet
        self.supply, self.dead, self.noise = supply, dead, noise
        self.counts, self.lowest, self.stuck = counts, lowest, stuck
        self.torque = torque
        self.gear = HANDLE * pulley / sector
        self.full = torque / self.gear
        self.count_length = math.pi * self.gear / counts
        self.rng = np.random.default_rng(1)
        self.settings_now = board or default().board
        self.stored, self.origin, self.hello = None, Origin.DEFAULT, None
        self.x = self.v = self.weight = self.spring = 0.0
        self.hand, self.student, self.slipped = None, lambda kit: None, 0.0
        self.seq, self.time, self.pwm, self.answered, self.delay = 0, 0.0, 0, 0, 0
        self.turns, self.last, self.silent = 0, None, True
        self.stopped, self.streaming, self.forces = False, False, []

    # --- interface of HapkitBoard
    def open(self):
        self.hello = HELLO_FIELDS

    def close(self):
        self.hello, self.pwm, self.streaming = None, 0, False

    def settings(self):
        self._opened()
        values = {f.name: getattr(self.settings_now, f.name) for f in fields(Board)}
        return Settings(**values, origin=self.origin, refused=0)

    def configure(self, board):
        self._opened()
        if not 0.0 < board.quantum < 0.01 or board.counts_per_flip < 4:
            raise ParameterError("The Hapkit on test refused these settings.")
        if board.counts_per_flip != self.settings_now.counts_per_flip:
            self.last = None
        self.settings_now, self.origin, self.pwm = board, Origin.UNSAVED, 0
        return self.settings()

    def save(self):
        self.stored, self.origin = self.settings_now, Origin.STORED
        return self.settings()

    def start_stream(self, padded=None):
        self.streaming = True

    def stop_stream(self):
        self.streaming, self.pwm = False, 0

    def send_messages(self, *messages):
        for message in messages:
            if isinstance(message, Force):
                self._force(message)
            elif isinstance(message, Stop):
                self.stopped, self.pwm = True, 0
            elif isinstance(message, Release):
                self.stopped = False

    def samples(self, silence=1.0):
        while True:
            self.silent = True
            yield self._sample()
            self._advance()
            if self.pace and self.seq % EVERY == 0:
                time.sleep(EVERY * self.pace)

    def _opened(self):
        if self.hello is None:
            raise DeviceError("Not open.")

    # --- the board
    def _sample(self):
        raw = self._raw()
        board = self.settings_now
        if self.last is None:
            self.turns = board.counts_per_flip * round((board.zero - raw) / board.counts_per_flip)
        elif abs(raw - self.last) > board.counts_per_flip / 2:
            self.turns += board.counts_per_flip if raw < self.last else -board.counts_per_flip
        self.last = raw
        self.seq = (self.seq + 1) & 0xFFFF
        flags = BoardFlag.STOPPED if self.stopped else BoardFlag(0)
        flags |= BoardFlag.WATCHDOG if self.silence >= 25 else BoardFlag(0)
        return Sample(
            seq=self.seq, time_us=round(1e6 * self.time) & 0xFFFFFFFF,
            count=board.sense * (self.turns + raw - board.zero), raw=raw, answered=self.answered,
            delay_us=self.delay, flags=int(flags), pwm=self.pwm,
            rx_errors=0, stale=0, generation=0, received=0, refusal=0,
        )  # fmt: skip

    def _raw(self):
        if self.stuck:
            return 500
        place = self.sense * self.x / self.count_length + self.magnet + self.slipped
        place += self.noise * self.rng.standard_normal()
        return math.floor(self.lowest + place % self.counts)

    def _force(self, message):
        board = self.settings_now
        force = float(np.clip(message.force, -board.max_force, board.max_force))
        full = board.motor_constant * board.sector_radius / (board.handle_radius * board.pulley_radius)
        share = min(math.sqrt(abs(force) / full), 1.0)
        pwm = round(board.dead_band + (255 - board.dead_band) * share) if share > 0.5 / 255 else 0
        self.next_pwm = 0 if self.stopped else int(math.copysign(pwm, force))
        self.answered, self.delay, self.silent = message.seq, round(1e6 * ANSWER), False
        self.forces.append(force)

    # --- the physics
    def motor_force(self, pwm):
        """Return the motor's true force in N."""
        live = max(abs(pwm) - self.dead, 0) / (255 - self.dead)
        sign = math.copysign(1.0, pwm) * self.direction * self.settings_now.direction
        return sign * self.supply * self.full * live * live if pwm else 0.0

    def _advance(self):
        self.student(self)
        self.silence = self.silence + 1 if self.silent else 0
        if self.silence >= 25:
            self.pwm = 0
        if self.hand is not None:
            self.x, self.v = self.hand, 0.0
            if not self.silent:
                self.pwm = self.next_pwm
        else:
            self._glide(ANSWER)
            if not self.silent:
                self.pwm = self.next_pwm
            self._glide(PERIOD - ANSWER)
        self.time += PERIOD

    def _glide(self, dt):
        force = self.motor_force(self.pwm) + self.weight
        step = transition(self.mass, self.viscous, self.spring, dt)
        self.x, self.v = advance(
            self.x, self.v, force, 0.0, self.coulomb, self.mass, self.viscous, self.spring, dt, step
        )
        if abs(self.x) > STOP:
            self.x, self.v = math.copysign(STOP, self.x), 0.0

    # --- functions for tests
    @property
    def position(self):
        """Return the position in m according to the board's settings."""
        return self._sample().count * self.settings_now.quantum

    def restart(self):
        """Switch the board off and on: unsaved settings are lost, and the zero is found again."""
        self.last = None
        if self.stored is not None:
            self.settings_now = self.stored
