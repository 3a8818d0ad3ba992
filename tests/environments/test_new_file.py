"""A new environment is one module: no other file changes, and the tests of every environment include it."""

import pytest

from tests.project_copy import copy_with, run_tests

NEW = '''"""Magnet: pulls to its place, strongest a little beside it."""

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


@law
def force(p, s, x, v, dt):
    away = x - p.position
    return -p.strength * away / (p.reach * p.reach + away * away)


ENVIRONMENT = Environment(
    key="magnet",
    title="Magnet",
    summary="Pulls to its place",
    parameters=(
        Parameter("strength", "Strength", "J", 0.01, 0.0, 0.05, "Twice the strongest pull times the reach"),
        Parameter("reach", "Reach", "m", 0.01, 0.005, 0.05, "Where it pulls most"),
        Parameter("position", "Position", "m", 0.0, -0.04, 0.04, "Where it pulls to"),
    ),
    force=force,
    formula="<i>F</i> = −<i>S d</i> / (<i>r</i>² + <i>d</i>²)",
    explanation="A magnet pulls to its place: near it like a spring, far from it weaker and weaker, so that "
    "there is a place where it pulls most.",
    impedance=lambda p: (p["strength"] / p["reach"] ** 2, 0.0),
    hands=("released", "stroke"),
    needs=("mass", "viscous", "coulomb", "delay"),
)
'''
OF_ALL = "library or gallery or actions or drawing or up_to_date or every_word"
LOOK_AT_EACH = ("environments", "analysis", "laws", "gui")


@pytest.mark.slow
def test_a_new_environment_needs_one_module(tmp_path):
    copy = copy_with(tmp_path, "hapkit_studio/environments/magnet.py", NEW)
    folders = [f"tests/{folder}" for folder in LOOK_AT_EACH]
    output = run_tests(copy, "-m", "not slow and not alone", *folders, "-k", f"magnet or {OF_ALL}")
    assert "test_is_described[magnet]" in output
