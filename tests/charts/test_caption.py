"""Captions of figures have scene, device and date, and every change with its time."""

from dataclasses import replace

import pytest

import hapkit_studio as hs
from hapkit_studio.charts.caption import caption, scene
from hapkit_studio.parameters import Choice
from hapkit_studio.sessions.settings_events import of_scene
from tests.environments.calling import LIBRARY

DATE = "2026-11-26 14:05"


def lines(log, known=None):
    return caption(log, known or {}, DATE).replace("\N{NO-BREAK SPACE}", " ").split("\n")


def of(key, **values):
    return of_scene(LIBRARY[key], LIBRARY[key].values(values))


def test_a_runs_caption_has_scene_device_date_hand_and_loop():
    values = {"stiffness": 400.0, "damping": 2.0}
    run = hs.simulate("wall", values, hand="press", seconds=0.1, delay=1e-3, estimator="iir", controller=True)
    assert lines(run.log) == [
        "Wall: stiffness 400 N/m, damping 2 N·s/m, position 5 mm, side right, damping acts on the way in",
        "Simulated Hapkit · 2026-11-26 14:05 · hand: press · 1,000 Hz · delay 1 ms · "
        "Low-pass filtered difference, cutoff 35.5 Hz · passivity controller",
    ]
    assert lines(hs.simulate("free", seconds=0.1).log)[0] == "Free"
    board = {**of("spring"), "device": "Hapkit on ttyUSB0", "render": "board", "hand": "own", "grip": "firm"}
    assert (
        lines([(0.0, board)])[1] == "Hapkit on ttyUSB0 · 2026-11-26 14:05 · own hand · rendered on the board"
    )


@pytest.mark.parametrize("key", LIBRARY)
def test_scenes_are_captioned_with_title_and_active_parameters(key):
    environment = LIBRARY[key]
    values = environment.values()
    text = scene(of(key), {}).replace("\N{NO-BREAK SPACE}", " ")
    assert text.startswith(environment.title)
    assert "_" not in text
    unused = environment.unused(values)
    for p in environment.parameters:
        assert (f"{p.label[1:]} " in text) == (p.key not in unused)
        if isinstance(p, Choice):
            assert p.key in unused or p.phrase(values[p.key]) in text
        elif p.unit == "m" and p.key not in unused:
            assert f"{1e3 * values[p.key]:.4g} mm" in text


def test_each_change_has_its_time_and_both_values():
    wall = {**of("wall"), "device": "Kit", "rate_Hz": 1000.0}
    stiffer = {**of("wall", stiffness=600.0, damping_mode="both"), "device": "Kit", "rate_Hz": 1000.0}
    log = [(0.0, wall), (1.5, stiffer), (2.25, {**stiffer, "rate_Hz": 2000.0}), (3.0, of("spring"))]
    assert lines(log)[2:] == [
        "At 1.50 s: stiffness 250 → 600 N/m, damping acts on the way in → both ways",
        "At 2.25 s: servo rate 1,000 → 2,000 Hz",
        "At 3.00 s: Spring: stiffness 80 N/m, damping 0 N·s/m, centre 0 mm",
    ]
    many = [(float(n), of("wall", stiffness=100.0 + n)) for n in range(9)]
    assert lines(many)[2:] == [
        *(f"At {n}.00 s: stiffness {99 + n} → {100 + n} N/m" for n in range(1, 5)),
        "and 4 more changes, the last at 8.00 s",
    ]


def test_own_environments_are_named_by_title_and_unknown_ones_by_key():
    own = replace(LIBRARY["spring"], key="mine", title="My spring")
    settings = {**of("spring", center=0.01), "environment": "mine"}
    assert lines([(0.0, settings)], {"mine": own})[0].startswith("My spring: stiffness 80 N/m")
    assert lines([(0.0, settings)])[0] == "mine: stiffness 80 N/m, damping 0 N·s/m, center 10 mm"


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"environment": 5, "parameters": [1], "units": None, "device": 3, "hand": [], "rate_Hz": "x"},
        {"environment": "wall", "parameters": {"stiffness": "x"}, "estimator": [[]], "delay_s": None},
        {"environment": "wall", "parameters": {"none": 1.0}, "units": {"none": 7}, "estimator": {"a": 1}},
    ],
)
def test_invalid_settings_still_give_a_caption(settings):
    first = lines([(0.0, settings), (1.0, {**settings, "device": "other"})])
    assert first[1].startswith("Simulated Hapkit · 2026-11-26 14:05")
    assert first[-1].startswith("At 1.00 s: ")
