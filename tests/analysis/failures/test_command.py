"""The command break-it: a table, one failure with its options, one object, pictures."""

import json

import pytest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.cli import main


def run(capsys, *words):
    try:
        code = main(("break-it", *words))
    except SystemExit as end:
        code = end.code
    out, err = capsys.readouterr()
    return code, out, err


@pytest.mark.slow
def test_without_a_key_it_is_a_table_of_all(capsys):
    code, out, err = run(capsys)
    assert (code, err) == (0, "")
    for key, failure in failures().items():
        assert f"{key:<18}{failure.title}" in out
    assert out.count("inside  holds") == out.count("outside fails") == len(failures())
    assert "15 of 15 hold inside their limit and fail outside." in out


def test_one_failure_in_words_with_its_options_and_another_try(capsys):
    code, out, _ = run(capsys, "course", "-p", "method=explicit_euler", "--at", "0.001")
    assert code == 0
    assert "limit: step 0.7692 ms" in out
    assert "1 ms fails: grows by 0.075 1/s" in out
    assert "method=explicit_euler" in out


def test_one_object_has_both_sides_of_the_limit(capsys):
    code, out, err = run(capsys, "sampled_spring", "-p", "mass=0.05", "-p", "rate=1000", "--json")
    assert (code, err) == (0, "")
    (row,) = json.loads(out)["failures"]
    assert row["limit"] == pytest.approx(1001.67, abs=0.01)
    assert (row["knob"], row["knob_unit"]) == ("stiffness", "N/m")
    assert row["inside"]["value"] == pytest.approx(0.99 * row["limit"])
    assert (row["inside"]["holds"], row["outside"]["holds"], row["as_theory_says"]) == (True, False, True)
    assert row["inside"]["measure"] < 0.0 < row["outside"]["measure"]
    assert row["options"] == {"mass": 0.05, "viscous": 0.5, "damping": 0.0, "rate": 1000.0, "delay": 0.0}


@pytest.mark.parametrize("key", ["sampled_spring", "large_push", "texture_counts"])
def test_a_picture_is_drawn_of_one(capsys, tmp_path, key):
    path = tmp_path / "broken.png"
    code, out, _ = run(capsys, key, "--plot", str(path))
    assert code == 0
    assert f"wrote {path}" in out
    assert path.read_bytes()[:4] == b"\x89PNG"
    assert path.stat().st_size > 20_000


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("spring",), "There is no failure 'spring'"),
        (("course", "-p", "rate=3"), "has no parameter 'rate'"),
        (("course", "--at", "5"), "Step goes from 0.0001 to 0.2 s, not 5"),
        (("--at", "5"), "belong to one failure"),
        (("course", "--plot", "broken.exe"), "A picture is one of"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(capsys, words, says):
    code, out, err = run(capsys, *words)
    assert (code, out) == (2, "")
    assert says in err
    assert err.count("\n") == 1
