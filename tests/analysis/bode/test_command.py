"""The command ``bode`` prints text and JSON and draws a figure; invalid settings give one-line errors."""

import json

import pytest

from hapkit_studio.cli import main


@pytest.mark.slow
def test_the_output_states_each_walls_end_and_a_figure_is_written(capsys, tmp_path):
    picture = tmp_path / "wall.png"
    args = ["bode", "wall", "-p", "stiffness=300", "--rate", "1000,4000", "--quantum", "0"]
    assert main([*args, "--json", "--plot", str(picture)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [curve["rate_Hz"] for curve in found["curves"]] == [1000.0, 4000.0]
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main(args) == 0
    out = capsys.readouterr().out
    assert "300 N/m up to 221 Hz" in out
    assert "300 N/m up to 886 Hz" in out
    assert "° of theory up to 200 Hz" in out


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ("--board-rate 4000", "--board-rate is for --device virtual-board"),
        ("--device /dev/ttyUSB9", "has no hand that could drive its handle"),
        ("--rate fast", "Rates are numbers in Hz as 1000,4000"),
        ("--amplitude 1", "Amplitude must be between"),
        ("--amplitude -5e-3", "Amplitude must be between"),
    ],
)
def test_invalid_options_give_a_one_line_error(capsys, options, text):
    assert main(["bode", "spring", *options.split()]) == 2
    err = capsys.readouterr().err
    assert text in err
    assert err.count("\n") == 1
