"""The wheel, installed into an empty environment, is complete and starts."""

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from hapkit_studio import __version__, environments

pytestmark = pytest.mark.slow  # all tests share one installation, which takes half a minute
ROOT = Path(__file__).resolve().parent.parent


def run(*command, cwd, **environment):
    """Run a command outside the checkout; return its output."""
    inherited = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env=inherited | environment,
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.strip()


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", folder, ROOT, cwd=folder)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def python(wheel):
    """Return the interpreter of an empty environment with the wheel and its dependencies."""
    home = wheel.parent / "venv"
    run(sys.executable, "-m", "venv", "--without-pip", home, cwd=wheel.parent)
    binary = home / ("Scripts" if os.name == "nt" else "bin") / "python"
    pip = (sys.executable, "-m", "pip", "--python", binary)
    run(*pip, "install", "--quiet", "--no-compile", wheel, cwd=wheel.parent)
    return binary


def test_the_wheel_contains_only_the_package_and_its_assets(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    kept = [path for path in (ROOT / "assets").rglob("*") if path.is_file()]
    in_window = {"lessons.md", "troubleshooting.md"}  # these documentation pages are shown in the window
    only_to_read = {path for path in kept if {"pictures", "docs"} & set(path.parts)}
    only_to_read -= {path for path in only_to_read if path.parent.name == "docs" and path.name in in_window}
    assets = [path for path in kept if path not in only_to_read]
    assert 30 < len(assets) < len(kept)
    assert not {f"hapkit_studio/{path.relative_to(ROOT)}" for path in only_to_read} & names
    assert {f"hapkit_studio/{path.relative_to(ROOT)}" for path in assets} <= names
    modules = [path for path in (ROOT / "hapkit_studio").rglob("*.py")]
    assert {str(path.relative_to(ROOT)) for path in modules} <= names
    assert {name.split("/")[0].split("-")[0] for name in names} == {"hapkit_studio"}


def test_the_installed_window_shows_every_environment(python, tmp_path):
    assert run(python.parent / "hapkit-studio", "--version", cwd=tmp_path) == __version__
    tour = Path(__file__).with_name("installed_tour.py")
    seen = json.loads(run(python, "-I", tour, tmp_path, cwd=tmp_path, QT_QPA_PLATFORM="offscreen"))
    assert seen["found"]
    assert all(Path(seen[what]).is_relative_to(python.parent.parent) for what in ("package", "assets"))
    assert set(seen["visits"]) == set(environments.discover())
    for key, visit in seen["visits"].items():
        assert visit["chosen"] == key
        assert visit["running"]
        assert visit["rows"] >= 200
        assert visit["bytes"] > 20_000
    assert seen["visits"]["spring"]["force"] > 0.0
    assert seen["visits"]["free"]["force"] == 0.0
