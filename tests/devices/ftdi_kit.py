"""A fake kit behind an FTDI chip, in simulated board time that is independent of real time."""

from hapkit_studio.protocol.framing import encode
from tests.devices.fake_board import FakeKit, sample

BYTE = 10e-6
"""Time in s of a byte on the line, which is ten bits at 1 Mbaud."""
PACKET = 62
PERIOD = 1e-3


class FtdiKit(FakeKit):
    """A kit whose FTDI chip sends a packet after 62 bytes, or when its timer ends (AN232B-04).

    Each packet restarts the timer. ``latency`` is the timer's time in s; ``turnaround`` is the time in s from
    a packet until its force is in the PWM register. ``ages`` is the mean age of the force in effect in each
    period, integrated exactly.
    """

    def __init__(self, latency=0.016, turnaround=0.4e-3, **options):
        super().__init__(**options)
        self.latency, self.turnaround = latency, turnaround
        self.on = False
        self._restart(0)

    def _restart(self, padded):
        self.padded, self.tick, self.sent_at, self.packet_at = padded, 0, 0.0, 0.0
        # ``line`` has the bytes on the wire with their times and frames
        self.line, self.whole, self.ages = [], -1, []
        self.now, self.applied = 0.0, []  # ``applied`` has the forces as (time, sample answered)

    def _stream(self, message):
        self._restart(message.padded)
        self.on = bool(message.on)
        return self._until_an_answer_is_due() if message.on else None

    def _force(self, message):
        if not self.on:
            return None
        self.applied.append((self.now + self.turnaround, message.seq))
        return self._until_an_answer_is_due()

    def _until_an_answer_is_due(self):
        """Return the packets up to the first that completes a frame."""
        out, before = b"", self.whole
        while self.whole == before:
            while len(self.line) < PACKET and self._next_byte_at() <= self.packet_at + self.latency:
                self._sample()
            size = min(PACKET, len(self.line))
            full = size == PACKET and self.line[size - 1][0] <= self.packet_at + self.latency
            self.now = self.packet_at = self.line[size - 1][0] if full else self.packet_at + self.latency
            ready = [b for b in self.line[:size] if b[0] <= self.now]
            out += bytes(byte for _, byte, _ in ready)
            self.whole = max([self.whole, *(ends for _, _, ends in ready)])
            del self.line[: len(ready)]
        return out

    def _next_byte_at(self):
        return max(self.tick * PERIOD, self.sent_at)

    def _sample(self):
        """Take a sample at the next tick, with the replies received so far, and send its frame."""
        k, time = self.tick, self.tick * PERIOD
        there = [(at, seq) for at, seq in self.applied if at <= time]
        at, seq = there[-1] if there else (0.0, 0)
        delay = round(1e6 * (at - seq * PERIOD)) if there else 0
        if there and k > 0:
            self._integrate((k - 1) * PERIOD, time)
        frame = encode(sample(k, answered=seq & 0xFFFF, delay_us=min(delay, 65535)))
        if self.padded:
            frame += b"\0" * (-len(frame) % self.padded)
        begin = self._next_byte_at()
        for i, byte in enumerate(frame):
            ends = k if i == len(frame) - 1 else -1
            self.line.append((begin + (i + 1) * BYTE, byte, ends))
        self.sent_at = begin + len(frame) * BYTE
        self.tick += 1

    def _integrate(self, start, stop):
        """Store the force's mean age over a period; the age is the time since the sample that it answers."""
        before = [f for f in self.applied if f[0] <= start]
        if not before:
            return
        inside = [f for f in self.applied if start < f[0] <= stop]
        edges = [start, *(at for at, _ in inside), stop]
        seqs = [before[-1][1], *(seq for _, seq in inside)]
        area = sum(
            (b - a) * ((a + b) / 2 - seq * PERIOD)
            for a, b, seq in zip(edges[:-1], edges[1:], seqs, strict=True)
        )
        self.ages.append(area / (stop - start))
