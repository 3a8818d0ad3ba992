"""The firmware that ships, by what it does: it shakes hands and renders a spring."""

import numpy as np
import pytest

from hapkit_studio.devices import profiles
from hapkit_studio.devices.flash import shipped
from hapkit_studio.devices.virtual_board import VirtualBoard, truth
from hapkit_studio.protocol.messages import PROTOCOL_VERSION
from tests.firmware.vb import FULL_FORCE, QUANTUM, needs_board
from tests.firmware.vb_host import exchange, rows_of

pytestmark = needs_board

STIFFNESS = 150.0
PUSH = ("0.05 hand 0.012 400 8 0.1 0.2", "0.5 hand -0.012 400 8 0.1 0.3")


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    """Return Hello, samples and truth log of the shipped firmware under a spring of this computer."""
    folder = tmp_path_factory.mktemp("shipped")
    (folder / "script.txt").write_text("\n".join(PUSH))
    paths = {"log": folder / "truth.f64", "script": folder / "script.txt"}
    board = VirtualBoard("lockstep", firmware=shipped(), **paths)
    board.open()
    hello = board.hello
    board.start_stream()
    zero = []

    def spring(sample):
        zero.append(sample.count)
        return -STIFFNESS * QUANTUM * (sample.count - zero[0])

    samples = exchange(board.fileno(), 1.0, spring)
    board.close()
    return hello, samples, truth(folder / "truth.f64")


def test_it_speaks_this_studios_version(rendered):
    hello, *_ = rendered
    assert hello.version == PROTOCOL_VERSION
    assert hello.quantum == pytest.approx(QUANTUM, rel=1e-3)
    assert len(hello.build) == 8


def test_a_spring_is_what_the_pins_render(rendered):
    _, samples, log = rendered
    rows = rows_of(samples, log)[2:]  # answers come from the second sample on
    moved = rows_of(samples, log).position
    force = rows.motor_force
    assert np.abs(force).max() > 1.0
    # a step of the duty, a count, and how far the handle goes until the next answer
    step = FULL_FORCE * (2.0 * np.abs(rows.duty) + 1.0) / 255.0**2
    lag = STIFFNESS * np.abs(np.diff(moved))[1:]
    assert np.all(np.abs(force + STIFFNESS * (rows.position - moved[0])) <= step + lag + STIFFNESS * QUANTUM)


def test_it_answers_with_its_settings():
    board = VirtualBoard("fast", firmware=shipped())
    board.open()
    try:
        settings = board.settings()
    finally:
        board.close()
    assert settings.quantum == pytest.approx(QUANTUM, rel=1e-3)
    assert settings.max_force == pytest.approx(profiles.default().board.max_force)
