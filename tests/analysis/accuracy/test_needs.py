"""What it needs: the force limit by statics, crossings, files, texts and cells, a law's terms by count."""

import json
import math

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy import needs
from hapkit_studio.analysis.accuracy.needs import Effect, LawTerm
from hapkit_studio.charts.accuracy import felt_words
from hapkit_studio.cli import main
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.laws import board, machine

LIBRARY = environments.discover()


def test_a_firm_grip_on_the_wall_is_felt_to_miss_the_force_limit():
    """400 N/m pulled to 30 mm: 250 N/m from 5 mm on hold it 2 mm sooner than 3 N do; friction: 0.1 N."""
    limited, free = 0.030 - 3.0 / 400.0, (0.030 * 400.0 + 0.005 * 250.0) / 650.0
    friction = 0.1 / 400.0
    rendered = needs._Rendered(LIBRARY["wall"])
    found = rendered.effect("saturation", ("saturation",))
    assert (found.sense, found.hand) == ("position", "push")
    assert found.felt == pytest.approx((limited - free) / 0.4e-3, abs=friction / 0.4e-3)
    assert found.felt == pytest.approx(5.1, abs=0.05)  # 22.55 instead of 20.51 mm
    assert found.strict == pytest.approx(found.felt * 4.0 / 3.0)


@pytest.mark.parametrize(
    ("felt", "place"),
    [([0.1, 0.5, 2.0, 3.0], 2.0 * 2.0**0.5), ([0.1, 0.2], math.nan), ([1.5, 0.1], 0.0), ([0.5, 1.0], 2.0)],
)
def test_one_jnd_is_crossed_on_a_straight_line_of_logarithms(felt, place):
    found = needs.crossing(np.array([1.0, 2.0, 4.0, 8.0])[: len(felt)], felt)
    assert found == pytest.approx(place, nan_ok=True)


def test_only_the_most_sensitive_people_feel_what_is_marked():
    assert Effect("made", "mass", 0.9, strict=1.1).differs
    assert not Effect("made", "mass", 1.1, strict=1.4).differs
    assert not Effect("made", "mass", 0.1, strict=0.9).differs
    assert (Effect("made", "mass", 1.01).needed, Effect("made", "mass", 0.99).needed) == (True, False)


@pytest.mark.slow
@pytest.mark.parametrize("key", LIBRARY)
def test_what_a_file_says_it_needs_is_what_it_needs(key):
    """Where a term changes about as much as is just felt, another machine's rounding may decide."""
    said, found = LIBRARY[key].needs, needs.compute(LIBRARY[key])
    assert list(said) == [term for term in TERMS if term in said]
    near = {e.term for e in found.effects if 0.9 <= (e.felt or 0.0) <= 1.1}
    assert set(said) ^ set(found.needs) <= near
    assert found.together.felt <= 1.0


def test_the_terms_of_a_law_cost_what_is_counted():
    puck = LIBRARY["puck"]
    found = {term.key: term for term in needs.law_terms(puck)}
    assert set(found) == {"contact_damping", "friction"}
    for n, value in enumerate((25.0, 0.0)):
        values = puck.values({"contact_damping": value})
        rate = found["contact_damping"].rate[n]
        program = board.compile(puck.force, values, 1.0 / rate, machine.ARENA)
        counted = machine.mean_cycles(program.code, program.slots, program.given)[0]
        assert found["contact_damping"].cycles[n] == pytest.approx(counted, rel=0.01)
        frames = rate / math.ceil(rate / 1000.0)
        assert rate * (counted + machine.REST) + frames * machine.FRAME <= 0.8 * 16e6
    assert found["contact_damping"].limit[1] > found["contact_damping"].limit[0]


def test_cells_and_texts_agree(capsys, monkeypatch):
    monkeypatch.setattr(needs.trials, "variants", lambda trial: ())  # scripts alone
    assert main(("fidelity", "free", "--json")) == 0  # the former name
    (found,) = json.loads(capsys.readouterr().out)["needs"]
    assert main(("accuracy", "free", "--needs")) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"free needs {', '.join(found['needs'])}"
    for effect in found["effects"]:
        line = next(one for one in lines if one.strip().startswith(TERMS[effect["term"]].word))
        assert felt_words(effect["felt"]) in line
        assert effect["sense"] in line
        assert effect["hand"] in line


def test_numbers_in_words():
    felt = {None: "–", 0.049: "0", 0.96: "1.0", 9.96: "10", 99.4: "99", math.inf: "> 99"}
    assert {one: felt_words(one) for one in felt} == felt
    said = [
        Effect("made", "sampling", 1.0, since=2416.0).since_words,
        Effect("made", "delay", 1.0, since=1.95e-4).since_words,
        Effect("made", "mass", 1.0, since=232.4).since_words,
        Effect("made", "mass", 1.0, since=0.0).since_words,
        Effect("made", "delay", 1.0, limit=334.0, without=1002.0).gain_words,
        LawTerm("b", "Damping", (200.0, 100.0), (1e3, 2e3), (400.0, 900.0)).words,
    ]
    assert said == [
        "up to 2,400 Hz", "from 0.2 ms", "from 230 N/m", "always", "+668 N/m",
        "Damping = 0: 200 → 100 cycles a tick, 1,000 → 2,000 Hz, stable up to 400 → 900 N/m",
    ]  # fmt: skip
