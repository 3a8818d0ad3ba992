import json

import pytest

import hapkit_studio as hs
from hapkit_studio.cli import main


@pytest.fixture(scope="module")
def csv(tmp_path_factory):
    path = tmp_path_factory.mktemp("identify") / "run.csv"
    hs.simulate("wall", {"stiffness": 300.0, "damping_mode": "none"}, hand="tap", seconds=3.0).save(path)
    return str(path)


def test_the_command_says_what_was_rendered(csv, capsys):
    assert main(["identify", csv]) == 0
    text = capsys.readouterr().out
    assert "Stiffness: you set 300 N/m, you rendered 299." in text or "you rendered 300." in text
    assert "What the handle is, the hand's mass with it" in text
    assert "not in contact" in text


def test_one_object_and_a_picture(csv, capsys, tmp_path):
    picture = tmp_path / "found.png"
    assert main(["identify", csv, "--json", "--from", "0.5", "--to", "2.5", "--plot", str(picture)]) == 0
    found = json.loads(capsys.readouterr().out)
    stiffness = found["parts"]["rendered"]["estimates"][0]
    assert stiffness["key"] == "stiffness"
    assert stiffness["low"] < 300.0 * 1.001
    assert stiffness["high"] > 300.0 * 0.999
    assert stiffness["set"] == 300.0
    assert (found["from_s"], found["to_s"]) == (0.5, 2.5)
    assert found["written"] == [str(picture)]
    assert picture.stat().st_size > 20_000
    setup = found["setup"]
    assert (setup["Environment"], setup["Stiffness"], setup["Rate"]) == (
        "Wall",
        "300 N/m",
        "1,000 Hz",
    )


def test_a_piece_that_tells_nothing_is_drawn_too(capsys, tmp_path):
    path, picture = tmp_path / "still.csv", tmp_path / "still.png"
    hs.simulate("wall", seconds=1.0).save(path)
    assert main(["identify", str(path), "--json", "--plot", str(picture)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["parts"]["rendered"]["words"][0].startswith("Cannot tell: the piece never touches")
    assert picture.exists()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--from", "9"], "is not in the recording"),
        (["--from", "nan"], "a number of seconds, not nan"),
        (["--terms", "inertia"], "The terms are some of"),
        (["--plot", "found.xyz"], "A picture is one of"),
    ],
)
def test_bad_input_is_one_line(csv, capsys, more, words):
    assert main(["identify", csv, *more]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1
