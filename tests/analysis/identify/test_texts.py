"""Sentences on identified values, and the command's output."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

import hapkit_studio as hs
from hapkit_studio.analysis.identify import from_csv, from_run, identify
from hapkit_studio.analysis.identify.estimates import Estimate, Part, Points
from hapkit_studio.analysis.identify.recording import Handle, Setup
from hapkit_studio.analysis.identify.texts import confirms, deviation, line, measured
from hapkit_studio.charts import identify as charts
from hapkit_studio.charts.style import colors
from hapkit_studio.cli import main
from hapkit_studio.dynamics.hand import GRIPS
from tests.analysis.identify.motions import shaken


@pytest.mark.parametrize(
    ("key", "value", "half", "text"),
    [
        ("stiffness", 287.31, 1.6, "287.3 ± 1.6"),
        ("stiffness", 299.98, 0.02, "300.0 ± 0.1"),
        ("stiffness", 1234.0, 260.0, "1,234 ± 260"),
        ("damping", -0.0001, 0.02, "0.000 ± 0.020"),
        ("mass", 0.0441, 0.0012, "44.1 ± 1.2"),
        ("centre", 0.00502, 0.0001, "5.02 ± 0.10"),
    ],
)
def test_numbers_have_the_decimals_of_their_interval(key, value, half, text):
    assert measured(Estimate(key, value, half)) == text


@pytest.mark.parametrize(
    ("key", "value", "half", "asked", "text"),
    [
        ("stiffness", 599.4, 0.5, 600.0, "0.6 N/m less"),
        ("stiffness", 599.5, 0.5, 600.0, ""),
        ("stiffness", 600.62, 0.5, 600.0, "0.6 N/m more"),
        ("stiffness", 600.0, 0.5, 600.0, ""),
        ("stiffness", 1000.0, 250.0, 600.0, "400 N/m more"),
        ("damping", -0.151, 0.004, 0.0, "0.151 N·s/m less"),
        ("mass", 0.0472, 0.0012, 0.044, "3.2 g more"),
        ("centre", 0.00502, 0.0001, 0.005, ""),
    ],
)
def test_an_interval_without_the_set_value_states_the_deviation(key, value, half, asked, text):
    estimate = Estimate(key, value, half, asked)
    assert deviation(estimate) == text
    assert confirms(estimate) == (not text)
    assert text in line(estimate, "rendered")
    assert ("more" in line(estimate, "rendered") or "less" in line(estimate, "rendered")) == bool(text)


def test_only_determined_and_set_values_are_confirmed():
    assert not confirms(Estimate("stiffness", 600.0, 0.5))
    assert not confirms(Estimate("stiffness", 600.0, 700.0, 600.0, determined=False))
    assert deviation(Estimate("stiffness", 300.0, 0.5)) == ""


def test_the_hands_mass_is_separate_from_the_handles():
    estimate = Estimate("mass", 0.0936, 0.0012, asked=0.094)
    setup = Setup(handle=Handle(0.044, 0.5, 0.1), grip=GRIPS["medium"])
    assert line(estimate, "handle", setup) == (
        "Mass: 44 g of the handle and 50 g of the hand, identified 93.6 ± 1.2 g."
    )
    alone = Estimate("mass", 0.0441, 0.0012, asked=0.044)
    assert line(alone, "handle", setup) == "Mass: the device has 44 g, identified 44.1 ± 1.2 g."


def test_the_loop_is_named_as_the_reason():
    found = shaken(1, values={"stiffness": 400.0}, delay=1e-3)
    text = "\n".join(found.sentences(found.rendered))
    assert "you set 0 N·s/m, the device gave −0.6" in text
    assert found.rendered["damping"].value == pytest.approx(-400.0 * 1.5e-3, rel=0.01)
    assert "The force is late. This alone gives −0.600 N·s/m." in text
    assert "1.5 ms late on average: this removes a damping of 400 N/m × 1.5 ms = 0.6 N·s/m." in text


def test_the_passivity_controller_is_named():
    run = hs.simulate("spring", {"stiffness": 900.0}, hand="pluck", seconds=3.0, delay=2e-3, controller=True)
    found = identify(from_run(run))
    text = "\n".join(found.sentences(found.rendered))
    assert "The measured value is different, so there is also another cause." in text
    assert "The passivity controller added damping in" in text
    assert found.surprises(found.rendered)


@pytest.fixture(scope="module")
def csv(tmp_path_factory):
    path = tmp_path_factory.mktemp("identify") / "run.csv"
    hs.simulate("wall", {"stiffness": 300.0, "damping_mode": "none"}, hand="tap", seconds=3.0).save(path)
    return str(path)


def test_the_command_prints_the_rendered_values(csv, capsys):
    assert main(["identify", csv]) == 0
    text = capsys.readouterr().out
    assert any(f"you set 300 N/m, the device gave {found}." in text for found in (299, 300))
    assert "Properties of the handle, the hand's mass with it" in text
    assert "not in contact" in text
    assert text.rstrip().endswith(
        "The force is not measured, but the simulated motor gives exactly the force that was set."
    )


def test_every_output_states_that_the_force_was_not_measured(csv, capsys, tmp_path, monkeypatch):
    """For a board, whose motor constant may be wrong, every output also states how to measure the force."""
    lines = Path(csv).read_text(encoding="utf-8").splitlines(keepends=True)
    others = [line for line in lines if not line.startswith(("# device", "# hand"))]
    path = tmp_path / "board.csv"
    path.write_text("".join(["# device: hapkit\n", "# hand: own\n", *others]), encoding="utf-8")
    captions = []
    monkeypatch.setattr(charts, "save", lambda *args, caption: captions.append(caption))
    assert main(["identify", str(path)]) == 0
    assert main(["identify", str(path), "--json"]) == 0
    text, found = capsys.readouterr().out.rstrip().rsplit("\n", 1)
    charts.identify_figure(identify(from_csv(path)), tmp_path / "found.png")
    for message in (text, json.loads(found)["force"], captions[0]):
        assert "The force is not measured" in message
        assert "± is only the uncertainty of the fit" in message
        assert "90 % of this one, the real values are 90 % of these" in message
        assert "Measure the constant with known weights, springs or a kitchen scale" in message


def test_a_fit_of_a_constant_force_alone_has_an_empty_chart():
    """The handle did not move, so no term has a varying input."""
    fit = SimpleNamespace(beta=np.zeros(1))
    points = Points(np.arange(3.0), ("offset",), np.ones((3, 1)), np.zeros(3), fit)
    figure = Figure()
    charts.draw(figure, colors(), Part("rendered", points=points), 0.0)
    assert figure.axes == []


@pytest.mark.slow
def test_json_and_picture(csv, capsys, tmp_path):
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
    assert (setup["Environment"], setup["Stiffness"], setup["Rate"]) == ("Wall", "300 N/m", "1,000 Hz")
