"""The USB chip's latency timer: asked for, read where it can be read, said with a remedy where it is long."""

import pytest

from hapkit_studio.devices import low_latency
from hapkit_studio.devices.low_latency import Latency, shorten_latency
from hapkit_studio.devices.serial_ports import NOWHERE, Identity

KIT = Identity(0x0403, 0x6001, "AAA", "1-2")


class Line:
    """A port that notes what is asked of it."""

    def __init__(self, refuses=None):
        self.asked, self.refuses = [], refuses

    def set_low_latency_mode(self, on):
        self.asked.append(on)
        if self.refuses:
            raise self.refuses

    def fileno(self):
        return -1


@pytest.fixture
def timer(monkeypatch, tmp_path):
    """Return a function that sets what the system shows for ttyUSB0."""
    monkeypatch.setattr(low_latency, "_SYS", tmp_path)
    monkeypatch.setattr(low_latency.sys, "platform", "linux")

    def show(text):
        (tmp_path / "ttyUSB0").mkdir(exist_ok=True)
        (tmp_path / "ttyUSB0" / "latency_timer").write_text(text)

    return show


def test_a_short_timer_is_nothing_to_speak_of(timer):
    line = Line()
    timer("1\n")
    latency = shorten_latency(line, "/dev/ttyUSB0", KIT)
    assert line.asked == [True]
    assert latency == Latency(0.001, True, "/dev/ttyUSB0")
    assert not latency.long
    assert latency.words == "USB latency timer 1 ms."


@pytest.mark.parametrize(
    "refuses", [OSError(1, "Operation not permitted"), ValueError("no"), AttributeError()]
)
def test_a_refusal_is_said_with_what_can_be_done(timer, refuses):
    timer("16\n")
    latency = shorten_latency(Line(refuses), "/dev/ttyUSB0", KIT)
    assert latency == Latency(0.016, True, "/dev/ttyUSB0")
    assert latency.long
    assert latency.words.startswith("USB latency timer 16 ms. Run `echo 1 | sudo tee ")
    assert "/ttyUSB0/latency_timer`" in latency.words
    assert "render on the board" in latency.words


def test_what_cannot_be_read_is_taken_for_the_usual(timer):
    latency = shorten_latency(Line(), "/dev/ttyUSB0", KIT)
    assert latency == Latency(0.016, False, "/dev/ttyUSB0")
    assert "as far as known" in latency.words


@pytest.mark.parametrize("identity", [NOWHERE, Identity(0x2341, 0x0043)])
def test_other_chips_have_no_timer(timer, identity):
    latency = shorten_latency(Line(), "/dev/ttyACM0", identity)
    assert (latency.timer, latency.long, latency.words) == (None, False, "")


@pytest.mark.parametrize(("system", "words"), [("win32", "Device Manager"), ("darwin", "FTDI's own driver")])
def test_the_remedy_is_the_systems_own(monkeypatch, system, words):
    monkeypatch.setattr(low_latency.sys, "platform", system)
    assert words in Latency(0.016).words
