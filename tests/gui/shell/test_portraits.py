"""One command takes the pictures of all environments for the README and the documentation."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtGui import QImage

from hapkit_studio import environments, resources
from hapkit_studio.cli import main
from hapkit_studio.gui.shell import portraits
from hapkit_studio.gui.state import prepare

LIBRARY = environments.discover()


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """Return a cache folder that marks everything as compiled, so that no program compiles in the test."""
    made = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prepare.platformdirs, "user_cache_dir", lambda *_, **__: str(made / "hapkit-studio"))
        for part in ("loop", "boards", "analysis"):
            prepare.stamp(part).parent.mkdir(exist_ok=True)
            prepare.stamp(part).touch()
    return made


@pytest.fixture(scope="module")
def folder(tmp_path_factory, prepared):
    """Return the folder with the pictures that the command took of each environment."""
    made = tmp_path_factory.mktemp("pictures")
    command = [sys.executable, "-m", "hapkit_studio.gui.shell.portraits", str(made), "--seconds", "0.3"]
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen", "XDG_CACHE_HOME": str(prepared)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return made


def described():
    """Return the environments that the page describes; ``make pictures`` adds a new environment to it."""
    page = resources.path("docs", "environments.md").read_text(encoding="utf-8")
    return {key: e for key, e in LIBRARY.items() if f"| `{key}` |" in page}


@pytest.mark.slow
def test_one_command_takes_every_picture(folder):
    """The pictures have the same number and sizes as the stored ones; their content varies."""
    names = {f"{key}{suffix}.png" for key in LIBRARY for suffix in ("", "-scene")}
    pictures = {path.name: QImage(str(path)) for path in folder.iterdir()}
    assert set(pictures) == names
    assert len({bytes(picture.constBits()) for picture in pictures.values()}) == len(names)
    for name in (f"{key}{suffix}.png" for key in described() for suffix in ("", "-scene")):
        assert QImage(str(resources.path("pictures", name))).size() == pictures[name].size()


def test_the_environments_page_is_up_to_date(monkeypatch, capsys):
    """``make pictures`` writes the page; all its pictures exist."""
    monkeypatch.setattr(environments, "discover", described)
    page = resources.path("docs", "environments.md")
    assert main(("environments", "--markdown")) == 0
    wanted = capsys.readouterr().out
    assert page.read_text(encoding="utf-8") == wanted
    for line in wanted.splitlines():
        if line.startswith("!["):
            assert (page.parent / line.partition("(")[2].rstrip(")")).exists()


def test_wrong_options_give_a_one_line_message(capsys):
    for argv in ([], [str(Path("x")), "--size", "big"], [str(Path("x")), "--seconds", "long"]):
        with pytest.raises(SystemExit) as error:
            portraits.options(argv)
        assert error.value.code == 2
        assert capsys.readouterr().err.count("\n") == 1
