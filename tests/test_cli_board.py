"""Computer or board on the command line."""

from types import SimpleNamespace

import pytest

from hapkit_studio.commands import rendered, run_on
from hapkit_studio.devices.virtual_board import built
from hapkit_studio.haptics.engine import Engine
from tests.lateness import ATTEMPTS
from tests.test_cli import as_json, run


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "wall", "--render", "board"), "--device"),
        (("run", "wall", "--board-rate", "4000"), "--device"),
        (("run", "wall", "--device", "simulated", "--render", "board"), "has no board"),
        (("run", "wall", "--device", "simulated", "--board-rate", "500"), "--render board"),
        (("loop-test", "--render", "board"), "has no board"),
        (("run", "wall", "--device", "nothing"), "There is no device"),
        (("flash", "simulated"), "needs no flashing. Name a port"),
        (("check", "/dev/ttyNONE7"), "ttyNONE7 is not there. Plug the board in"),
        (("export", "wall", "--port", "/dev/ttyNONE7"), "ttyNONE7 is not there. Plug the board in"),
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


def test_a_fault_ends_a_run_with_a_code_of_its_own(capsys, monkeypatch):
    words = ("run", "wall", "--device", "simulated", "--seconds", "0.2")
    assert run(capsys, *words)[0] == 0
    fault = SimpleNamespace(text="Over-speed. Force is zero.")
    monkeypatch.setattr(Engine, "fault", property(lambda engine: fault if engine.heard else None))
    monkeypatch.setattr(Engine, "heard", False, raising=False)
    play = run_on.rendered.play

    def then_fault(engine, *given):
        engine.heard = True
        return play(engine, *given)

    monkeypatch.setattr(run_on.rendered, "play", then_fault)
    code, out, err = run(capsys, *words)
    assert (code, err) == (2, "")
    assert fault.text in out


@pytest.mark.parametrize(
    ("rate", "wish", "got", "said"),
    [
        (1000.0, 4000.0, 2.0, ["The board renders at 1,000 Hz, not at 4,000 Hz"]),
        (1000.0, 1000.0, 2.0, []),
        (4000.0, None, 1.82, []),
        (4000.0, None, 1.0, ["Only 1.00 s of samples came in 2 s"]),
    ],
)
def test_less_than_was_wished_is_said(rate, wish, got, said):
    found = rendered.remarks({"board": {"rate_Hz": rate}}, wish, 2.0, got)
    assert len(found) == len(said)
    assert all(line.startswith(words) for line, words in zip(found, said, strict=True))


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
