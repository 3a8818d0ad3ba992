"""The command: one object, a table with the front, pictures; one line where it cannot."""

import json

import pytest

from hapkit_studio.cli import main

KEYS = {"chart", "scene", "method", "step_s", "error", "ns_per_simulated_s", "pareto"}


@pytest.mark.slow
def test_one_object_with_a_row_a_point(capsys):
    assert main(["accuracy", "servo", "--scene", "stiffness", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["rows"]) == 14
    for row in found["rows"]:
        assert set(row) == KEYS | {"rate_Hz", "stable_stiffness"}
        better = [
            other
            for other in found["rows"]
            if other["error"] <= row["error"]
            and other["ns_per_simulated_s"] <= row["ns_per_simulated_s"]
            and other != row
        ]
        assert row["pareto"] == (not better)
    (answer,) = found["answers"]
    assert (answer["chart"], answer["scene"], answer["tolerance"]) == ("servo", "stiffness", 1.0)
    assert answer["default"]["rate_Hz"] == 1000.0


@pytest.mark.slow
def test_an_answer_that_rests_on_a_tie_says_so(capsys):
    assert main(["accuracy", "velocity", "--scene", "tremor", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    (answer,) = found["answers"]
    least = min(row["ns_per_simulated_s"] for row in found["rows"])
    tied = [row for row in found["rows"] if row["ns_per_simulated_s"] <= 1.1 * least]
    assert len(tied) > 1
    assert ("As cheap, to 10 %: " in answer["answer"]) == answer["default_is_cheapest"]
    assert "all but FOAW cost the same" in answer["reason"]


@pytest.mark.slow
def test_the_table_marks_front_and_default(capsys, tmp_path):
    picture = tmp_path / "chart.png"
    assert main(["accuracy", "integrators", "--scene", "free", "--plot", str(picture)]) == 0
    text = capsys.readouterr().out
    assert "Cheapest within 2 % at a 1 ms step:" in text
    lines = [line for line in text.splitlines() if line.startswith("  Semi-implicit")]
    assert len(lines) == 6
    assert [line.split()[1] for line in lines if line.endswith("default")] == ["1"]
    assert any("*" in line for line in text.splitlines() if line.startswith("  Exact"))
    assert picture.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["speed"], "there are: integrators"),
        (["servo", "--scene", "nowhere"], "there are: stiffness, contact"),
    ],
)
def test_one_line_and_code_2(capsys, arguments, words):
    assert main(["accuracy", *arguments]) == 2
    error = capsys.readouterr().err.strip()
    assert words in error
    assert "\n" not in error
