"""Framing of every message in plain Python (COBS, CRC-16), for handshakes and tests, not for the loop."""

import binascii

from hapkit_studio.protocol.messages import MESSAGES, Message

DELIMITER = b"\0"
CRC_SIZE = 2
CRC_START = 0xFFFF
_BLOCK = 254

_BY_ID = {m.ID: m for m in MESSAGES}


def crc16(body: bytes) -> int:
    """Return the CRC-16/CCITT-FALSE; it is zero for a body followed by its CRC, high byte first."""
    return binascii.crc_hqx(body, CRC_START)


def cobs_encode(raw: bytes) -> bytes:
    """Replace each zero by the distance to the next zero (COBS, Cheshire & Baker 1999)."""
    out = bytearray()
    for run in raw.split(b"\0"):
        rest = run
        while len(rest) >= _BLOCK:
            out += bytes([_BLOCK + 1]) + rest[:_BLOCK]
            rest = rest[_BLOCK:]
        out += bytes([len(rest) + 1]) + rest
    return bytes(out)


def cobs_decode(coded: bytes) -> bytes | None:
    """Return the raw bytes, or None if ``coded`` ends inside a block."""
    out = bytearray()
    at = 0
    while at < len(coded):
        code = coded[at]
        if code == 0 or at + code > len(coded):
            return None
        out += coded[at + 1 : at + code]
        at += code
        if code <= _BLOCK and at < len(coded):
            out.append(0)
    return bytes(out)


def frame(body: bytes) -> bytes:
    """Return the frame of a body, which consists of id and payload."""
    return cobs_encode(body + crc16(body).to_bytes(CRC_SIZE, "big")) + DELIMITER


def encode(message: Message) -> bytes:
    """Return the frame of a message."""
    return frame(message.pack())


def body_of(coded: bytes) -> bytes | None:
    """Return id and payload of a frame without its delimiter; None if structure or CRC are wrong."""
    raw = cobs_decode(coded)
    if raw is None or len(raw) <= CRC_SIZE or crc16(raw):
        return None
    return raw[:-CRC_SIZE]


class Decoder:
    """Decodes received bytes into bodies and messages; counts invalid frames."""

    def __init__(self) -> None:
        self._pending = bytearray()
        self.bad_frames = 0

    def bodies(self, data: bytes) -> list[bytes]:
        """Return every valid body that the data complete, also bodies of unknown messages."""
        self._pending += data
        *whole, rest = self._pending.split(DELIMITER)
        self._pending = bytearray(rest)
        found = []
        for coded in filter(None, whole):
            body = body_of(bytes(coded))
            if body is None:
                self.bad_frames += 1
            else:
                found.append(body)
        return found

    def feed(self, data: bytes) -> list[Message]:
        """Return every message that the data complete; bodies with an unknown size or id are skipped."""
        messages = []
        for body in self.bodies(data):
            kind = _BY_ID.get(body[0])
            if kind and len(body) == 1 + kind.size():
                messages.append(kind.unpack(body))
        return messages
