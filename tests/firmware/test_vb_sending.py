"""What the board sends: the chip's transmitter and sleep in the virtual board, full queues, empty answers."""

import itertools
import json
import os
import select

import pytest

from hapkit_studio.devices import virtual_board
from hapkit_studio.devices.virtual_board import BoardProgram, VirtualBoard
from hapkit_studio.protocol.framing import DELIMITER, Decoder, encode
from hapkit_studio.protocol.messages import (
    BoardFlag,
    Force,
    Hello,
    HelloRequest,
    Sample,
    Settings,
    SettingsRequest,
    Stream,
)
from tests.firmware.vb import Host, chip, needs_board, needs_compiler
from tests.waiting import PATIENCE

UDRE, TXC = 1 << 5, 1 << 6
QUESTIONS = (HelloRequest(), SettingsRequest())


def said(tmp_path, name, size, **defined):
    """Return what a small program has sent from its first cycle, and the counters."""
    still = tmp_path / "still.txt"
    still.write_text("0 freeze")
    words = [
        virtual_board.program(),
        chip(name, tmp_path, **defined),
        "--fast",
        "--control",
        "--script",
        still,
    ]
    board = BoardProgram([str(w) for w in words])
    host = Host(board.reply("port"))
    try:
        board.send("resume")
        found = host.read(size)
    finally:
        summary = board.end()
        host.close()
    return found, json.loads(summary)


@needs_compiler
def test_the_transmitter_takes_two_bytes_and_tells_when_they_have_gone(tmp_path):
    """Data sheet, UCSR0A: the flag asks while it stands; its interrupt or a one written there clears it."""
    found, summary = said(tmp_path, "pairs", 9, LOOK=1)
    gone, served, inside, behind, cleared = found[4:]
    assert found[:4] == b"1234"
    assert gone & (UDRE | TXC) == UDRE | TXC
    assert served == 1
    assert (inside | behind | cleared) & TXC == 0
    assert summary["overwritten"] == 0


@needs_compiler
def test_a_byte_written_into_a_full_buffer_is_lost_and_counted(tmp_path):
    found, summary = said(tmp_path, "pairs", 7)
    assert found[:2] == b"13"
    assert summary["overwritten"] == 2


@needs_compiler
def test_a_sleep_that_is_not_allowed_is_none(tmp_path):
    found, _ = said(tmp_path, "wakeful", 2)
    assert 100 <= int.from_bytes(found, "little") <= 600  # a few cycles each; the clock would turn over


def heard(board, decoder):
    ready, _, _ = select.select([board.fileno()], [], [], PATIENCE)
    assert ready, "the board has gone silent"
    return decoder.feed(os.read(board.fileno(), 4096))


@needs_board
@pytest.mark.parametrize("padded", [0, 62])
def test_questions_while_samples_come_are_all_answered_and_a_lost_sample_is_told(padded):
    board = VirtualBoard("lockstep")
    board.open()
    decoder, seen = Decoder(), []
    try:
        os.write(board.fileno(), encode(Stream(1, padded)))
        while len(seen) < 200:
            new = heard(board, decoder)
            seen += new
            for sample in (m for m in new if isinstance(m, Sample)):
                ask = QUESTIONS if sample.seq % 20 == 0 else ()
                os.write(board.fileno(), b"".join(map(encode, (Force(sample.seq, 0, 0.0), *ask))))
    finally:
        board.close()
    samples = [m for m in seen if isinstance(m, Sample)]
    asked = sum(s.seq % 20 == 0 for s in samples[:-10])
    for kind in (Hello, Settings):
        assert sum(isinstance(m, kind) for m in seen) >= asked > 3
    gaps = [(b.seq - a.seq) & 0xFFFF for a, b in itertools.pairwise(samples)]
    for gap, sample in zip(gaps, samples[1:], strict=True):
        assert gap == 1 or sample.flags & BoardFlag.OVERRUN
        assert gap <= 4  # filled, the two answers are 200 bytes: 2.2 ms on the line
    assert decoder.bad_frames == 0
    assert board.summary["overwritten"] == board.summary["dropped"] == board.summary["unanswered"] == 0


@needs_board
def test_a_lone_delimiter_is_an_answer_in_lockstep_that_the_chip_does_not_get():
    board = VirtualBoard("lockstep")
    board.open()
    decoder, seen = Decoder(), 0
    try:
        board.start_stream()
        while seen < 300:
            new = sum(isinstance(m, Sample) for m in heard(board, decoder))
            os.write(board.fileno(), DELIMITER * new)
            seen += new
    finally:
        board.close()
    assert board.summary["unanswered"] == 0
    assert 0 < board.summary["received"] < 300  # what opens and closes the port, sometimes said twice
