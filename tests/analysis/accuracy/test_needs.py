"""Tests of the table of the terms that each scene needs.

The effect of the force limit is compared with statics, and every other effect with a loop in plain Python.
The cycles of a law's terms are counted.
"""

import json
import math

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy import needs, trials
from hapkit_studio.analysis.accuracy.needs import Effect, LawTerm
from hapkit_studio.charts.accuracy import felt_text
from hapkit_studio.cli import main
from hapkit_studio.devices.simulated import TERMS, SimulatedHapkit
from hapkit_studio.laws import board, machine
from tests.analysis.accuracy.reference_loop import LowPass, rendered

LIBRARY = environments.discover()


def test_a_firm_grip_on_the_wall_feels_the_missing_force_limit():
    """A hand of 400 N/m pulls the handle to 30 mm, into a wall of 250 N/m at 5 mm; friction is 0.1 N.

    Without the force limit of 3 N, the wall stops the handle 2 mm earlier.
    """
    limited, free = 0.030 - 3.0 / 400.0, (0.030 * 400.0 + 0.005 * 250.0) / 650.0
    friction = 0.1 / 400.0
    rendered = needs._Rendered(LIBRARY["wall"])
    found = rendered.effect("saturation", ("saturation",))
    assert (found.sense, found.hand) == ("position", "push")
    assert found.felt == pytest.approx((limited - free) / 0.4e-3, abs=friction / 0.4e-3)
    assert found.felt == pytest.approx(5.1, abs=0.05)  # the handle stops at 22.55 instead of 20.51 mm
    assert found.strict == pytest.approx(found.felt * 4.0 / 3.0)


@pytest.mark.parametrize(
    ("felt", "place"),
    [([0.1, 0.5, 2.0, 3.0], 2.0 * 2.0**0.5), ([0.1, 0.2], math.nan), ([1.5, 0.1], 0.0), ([0.5, 1.0], 2.0)],
)
def test_one_jnd_is_found_by_logarithmic_interpolation(felt, place):
    found = needs.crossing(np.array([1.0, 2.0, 4.0, 8.0])[: len(felt)], felt)
    assert found == pytest.approx(place, nan_ok=True)


def test_effects_with_a_mark_are_felt_by_the_most_sensitive_people_only():
    assert Effect("made", "mass", 0.9, strict=1.1).differs
    assert not Effect("made", "mass", 1.1, strict=1.4).differs
    assert not Effect("made", "mass", 0.1, strict=0.9).differs
    assert (Effect("made", "mass", 1.01).needed, Effect("made", "mass", 0.99).needed) == (True, False)


PARTS = {"sampling": "rate", "delay": "delay", "filter": "velocity", "quantization": "sensor"}
PARTS["saturation"] = "limit"
# after a throw or a release, rounding errors determine the handle's rest position
DECIDED_BY_ROUNDING = {("texture", "quantization"), ("friction", "sampling")}
# a cat does not purr above a stroking speed; rounding errors determine when a rubbing hand exceeds this speed
CROSSED_BY_ROUNDING = {("cat", "sampling")}


def plain_felt(key, term, trial, rate=1000.0, delay=1e-3):
    """Return the perceptible effect in JND of removing a term, computed by the loop in plain Python."""
    scene, runs = LIBRARY[key], []
    for gone in ((), (term,)):
        device = SimulatedHapkit().without(gone if gone != ("mass",) or trial.holds else ())
        real = set(PARTS.values()) - {PARTS.get(one) for one in gone}
        runs.append(rendered(trial, device, scene, scene.values(), real, rate, delay, LowPass))
    return trials.felt(scene, trial, *runs).most


@pytest.mark.slow
@pytest.mark.parametrize("key", LIBRARY)
def test_every_cell_agrees_with_plain_python_and_files_list_the_needed_terms(key):
    """If a term's effect is close to a JND, rounding errors of another machine may change the result."""
    found, scripts = needs.compute(LIBRARY[key]), [*trials.scripts(LIBRARY[key]), trials.script("push")]
    hands = {t.label: t for one in scripts for t in (*trials.variants(one), one)}
    for effect in found.effects:
        wanted = plain_felt(key, effect.term, hands[effect.hand])
        if effect.needed and (key, effect.term) not in DECIDED_BY_ROUNDING:
            assert effect.felt == pytest.approx(wanted, rel=0.12), effect.term
        else:
            assert wanted <= 1.0
        if (key, effect.term) in CROSSED_BY_ROUNDING:
            continue
        if effect.term in ("sampling", "delay") and effect.since > 0.0:
            down, places = effect.term == "sampling", needs.DELAYS
            places = needs.RATES[::-1] if down else places
            first = int(np.argmax(places <= effect.since if down else places >= effect.since))
            for place, low, high in ((places[first - 1], 0.0, 1.1), (places[first], 0.9, math.inf)):
                at = {PARTS[effect.term]: float(place)}
                assert low <= max(plain_felt(key, effect.term, one, **at) for one in scripts) <= high
    near = {e.term for e in found.effects if 0.9 <= (e.felt or 0.0) <= 1.1}
    assert list(LIBRARY[key].needs) == [term for term in TERMS if term in LIBRARY[key].needs]
    assert set(LIBRARY[key].needs) ^ set(found.needs) <= near
    assert found.together.felt <= 1.0


@pytest.mark.parametrize("key", [pytest.param(k, marks=[pytest.mark.slow] * (k != "puck")) for k in LIBRARY])
def test_the_cost_of_a_laws_terms_is_the_counted_one(key):
    scene = LIBRARY[key]
    found = {term.key: term for term in needs.law_terms(scene)}
    assert key != "puck" or set(found) == {"contact_damping", "friction"}
    for name, term in found.items():
        parameter = next(p for p in scene.parameters if p.key == name)
        for n, value in enumerate((parameter.default or 0.5 * parameter.high, 0.0)):
            rate = term.rate[n]
            program = board.compile(scene.force, scene.values() | {name: value}, 1.0 / rate, machine.ARENA)
            counted = machine.mean_cycles(program.code, program.slots, program.given)[0]
            assert term.cycles[n] == pytest.approx(counted, rel=0.01)
            frames = rate / math.ceil(rate / 1000.0)
            assert rate * (counted + machine.REST) + frames * machine.FRAME <= 0.8 * 16e6
        assert term.limit[1] >= term.limit[0]


@pytest.mark.slow
def test_cells_and_texts_agree(capsys, monkeypatch):
    monkeypatch.setattr(needs.trials, "variants", lambda trial: ())  # compute with the hands' scripts only
    assert main(("fidelity", "free", "--json")) == 0  # "fidelity" is the former name of the command
    (found,) = json.loads(capsys.readouterr().out)["needs"]
    assert main(("accuracy", "free", "--needs")) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"free needs {', '.join(found['needs'])}"
    for effect in found["effects"]:
        line = next(one for one in lines if one.strip().startswith(TERMS[effect["term"]].word))
        assert felt_text(effect["felt"]) in line
        assert effect["sense"] in line
        assert effect["hand"] in line


def test_numbers_are_formatted_for_people():
    felt = {None: "–", 0.049: "0", 0.96: "1.0", 9.96: "10", 99.4: "99", math.inf: "> 99"}
    assert {one: felt_text(one) for one in felt} == felt
    texts = [
        Effect("made", "sampling", 1.0, since=2416.0).since_text,
        Effect("made", "delay", 1.0, since=1.95e-4).since_text,
        Effect("made", "mass", 1.0, since=232.4).since_text,
        Effect("made", "mass", 1.0, since=0.0).since_text,
        Effect("made", "delay", 1.0, limit=334.0, without=1002.0).gain_text,
        LawTerm("b", "Damping", (200.0, 100.0), (1e3, 2299.0), (400.0, 900.0)).text,
    ]
    assert texts == [
        "up to 2,400 Hz", "from 0.2 ms", "from 230 N/m", "always", "+668 N/m",
        "Damping = 0: 200 → 100 processor cycles per period, 1,000 → 2,300 Hz, stable up to 400 → 900 N/m",
    ]  # fmt: skip
