"""Computer or board on the command line."""

import pytest

from hapkit_studio.devices.virtual_board import built
from tests.test_cli import as_json, run

ATTEMPTS = 5


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "wall", "--render", "board"), "--device"),
        (("run", "wall", "--board-rate", "4000"), "--device"),
        (("run", "wall", "--device", "simulated", "--render", "board"), "has no board"),
        (("run", "wall", "--device", "simulated", "--board-rate", "500"), "--render board"),
        (("loop-test", "--render", "board"), "has no board"),
        (("run", "wall", "--device", "nothing"), "There is no device"),
    ],
)
def test_what_cannot_be_is_one_line(capsys, words, said):
    code, out, err = run(capsys, *words)
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1


def test_run_on_the_simulated_device(capsys):
    found = as_json(capsys, "run", "spring", "--device", "simulated", "--hand", "press", "--seconds", "0.5")
    assert found["render"] == "computer"
    assert found["samples"] > 100
    assert found["board"]["delay_us"] is None
    assert found["peak_force"] > 0.0


@pytest.mark.alone
@pytest.mark.skipif(not built(), reason="the virtual board is not built")
def test_the_board_renders_and_answers_sooner(capsys):
    for left in reversed(range(ATTEMPTS)):
        found = as_json(
            capsys, "run", "wall", "--device", "virtual-board", "--render", "board", "--hand", "press",
            "--seconds", "1", "--estimator", "kalman",
        )  # fmt: skip
        if not found["faults"] or not left:
            break
    assert found["render"] == "board"
    assert found["board"]["delay_us"] < 0.5 * found["computer"]["delay_us"]
    assert found["board"]["rate_Hz"] == 4000.0
    assert found["board"]["stiffness_limit"] > 2.0 * found["computer"]["stiffness_limit"]
    assert found["board_overruns"] == 0
