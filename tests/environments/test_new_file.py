"""A new environment is one file: nothing else is touched, and the tests of every environment take it too."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
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
def test_a_file_of_its_own_is_all_that_a_new_environment_takes(tmp_path):
    left = shutil.ignore_patterns("__pycache__", "build", ".*")
    for name in ("hapkit_studio", "tests", "assets", "firmware"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=left)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    if (ROOT / "firmware" / "build").is_dir():
        (tmp_path / "firmware" / "build").symlink_to(ROOT / "firmware" / "build")
    (tmp_path / "hapkit_studio" / "environments" / "magnet.py").write_text(NEW, encoding="utf-8")
    around = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    words = [sys.executable, "-m", "pytest", "-v", "-p", "no:cacheprovider", "-m", "not slow and not alone"]
    words += [*(f"tests/{folder}" for folder in LOOK_AT_EACH), "-k", f"magnet or {OF_ALL}"]
    done = subprocess.run(words, cwd=tmp_path, env=around, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
    assert (
        "test_is_described[magnet]"
        in subprocess.run(
            [*words, "--collect-only"], cwd=tmp_path, env=around, capture_output=True, text=True, check=False
        ).stdout
    )
