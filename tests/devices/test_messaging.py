"""Questions to a board: answers, repeats, refusals, silence, a cable pulled in between."""

import itertools
import time
from dataclasses import replace

import pytest

from hapkit_studio import errors
from hapkit_studio.devices import messaging
from hapkit_studio.devices.hapkit import PACKET, HapkitBoard
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import Board, Origin, Save, Settings, SettingsRequest, Stream
from tests.devices.fake_board import UNPLUG
from tests.devices.fake_kit import KIT, FakeKit, sample


def near(got, want):
    """Compare field by field: what is a float travels in 32 bits."""
    for f in Board.layout():
        a, b = getattr(got, f.name), getattr(want, f.name)
        assert a == (pytest.approx(b, rel=1e-6) if f.code == "f" else b), f.name
    return True


def test_settings_come_as_the_board_has_them(opened):
    board, _ = opened(FakeKit())
    settings = board.settings()
    assert near(settings, KIT)
    assert settings.origin == Origin.DEFAULT


def test_the_paddle_is_what_the_board_says_once_it_was_asked(opened):
    board, _ = opened(FakeKit(replace(KIT, mass=0.031, viscous=0.25, coulomb=0.2)))
    assert (board.mass, board.viscous, board.coulomb_force) == (0.044, 0.5, 0.10)
    board.settings()
    assert (board.mass, board.viscous, board.coulomb_force) == pytest.approx((0.031, 0.25, 0.2))
    board.configure(replace(KIT, mass=0.05))
    assert board.mass == pytest.approx(0.05)


def test_configure_is_in_force_at_once_and_not_saved(opened):
    kit = FakeKit()
    board, peer = opened(kit)
    wanted = replace(KIT, quantum=1.5e-5, max_force=1.25, label="mine")
    settings = board.configure(wanted)
    assert near(settings, wanted)
    assert settings.origin == Origin.UNSAVED
    assert kit.stored is None
    assert board.max_force == 1.25  # what the computer reckons with follows the board
    assert board.quantum == pytest.approx(1.5e-5, rel=1e-6)
    assert board.save().origin == Origin.STORED
    assert near(kit.stored, wanted)
    assert any(isinstance(m, Save) for m in peer.received)


def test_settings_can_be_sent_back_as_they_came(opened):
    board, peer = opened(FakeKit())
    board.configure(board.settings())
    (sent,) = [m for m in peer.received if isinstance(m, Board)]
    assert near(sent, KIT)


def test_what_the_board_refuses_changes_nothing(opened):
    board, _ = opened(FakeKit())
    with pytest.raises(errors.ParameterError, match=r"refused these settings.*Nothing was changed") as error:
        board.configure(replace(KIT, max_force=1000.0))
    assert "\n" not in str(error.value)
    assert board.max_force == 2.5
    assert near(board.settings(), KIT)


def test_a_lost_question_is_asked_again_and_the_late_answer_is_nobody_elses(opened):
    asked, kit = [], FakeKit()

    def slow(message):
        if isinstance(message, SettingsRequest):
            asked.append(message)
            # the first answer comes with the second: one of both is too many
            return kit(message) * 2 if len(asked) == 2 else None
        return kit(message)

    board, _ = opened(slow)
    assert near(board.request(SettingsRequest(), Settings, seconds=2.0), KIT)
    assert len(asked) == 2
    changed = replace(KIT, mass=0.05)
    assert near(board.configure(changed), changed)


class Streaming:
    """A line that never falls silent; it answers the second question."""

    in_waiting = 1

    def __init__(self):
        self.asked, self.end = 0, time.monotonic() + 20.0

    def reset_input_buffer(self):
        pass

    def write(self, data):
        self.asked += 1

    def read(self, _size):
        assert time.monotonic() < self.end, "it waits for the stream's end"
        answer = FakeKit()(SettingsRequest()) if self.asked == 2 else b""
        return encode(sample(1)) + answer


def test_a_stream_that_is_on_does_not_keep_an_answer_back():
    assert near(messaging.request(Streaming(), "port", SettingsRequest(), Settings, 0.2), KIT)


def test_no_answer_has_a_text_of_its_own(opened):
    board, _ = opened(FakeKit(deaf={SettingsRequest: 2}))
    with pytest.raises(errors.NoDataError, match=r"did not answer when asked for its settings within 0\.2 s"):
        board.request(SettingsRequest(), Settings, seconds=0.2)


def test_unplugged_in_the_middle_of_a_question(opened):
    kit = FakeKit()
    board, _ = opened(lambda m: UNPLUG if isinstance(m, SettingsRequest) else kit(m))
    with pytest.raises(errors.PortGoneError):
        board.settings()


def test_samples_come_one_by_one_until_silence(opened):
    board, _ = opened(FakeKit(burst=20))
    board.start_stream()
    assert list(itertools.islice(board.samples(), 20)) == [sample(k, count=k) for k in range(20)]
    with pytest.raises(errors.NoDataError, match=r"says hello, but no sample came for 0\.2 s"):
        next(board.samples(silence=0.2))


def test_samples_can_be_left_and_taken_up(opened):
    board, _ = opened(FakeKit(burst=5))
    board.start_stream()
    assert [s.seq for s in itertools.islice(board.samples(), 5)] == [0, 1, 2, 3, 4]
    board.stop_stream()
    assert near(board.settings(), KIT)


def test_frames_are_padded_when_asked_for(opened):
    board, peer = opened(FakeKit())
    count = len(peer.wait_for(3))  # hello, stream off, release
    board.start_stream(padded=PACKET)
    board.padding = PACKET
    board.start_stream()
    board.start_stream(padded=0)
    assert peer.wait_for(count + 3)[count:] == [Stream(1, 62), Stream(1, 62), Stream(1, 0)]


@pytest.mark.parametrize("use", [HapkitBoard.settings, HapkitBoard.save, lambda b: next(b.samples())])
def test_a_closed_board_says_that_it_is_closed(use):
    with pytest.raises(errors.DeviceError, match="is not open"):
        use(HapkitBoard("/dev/ttyNONE7"))
