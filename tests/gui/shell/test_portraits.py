"""The pictures of README and docs: one command makes them all, one for every environment."""

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
    """Return a cache folder in which what a loop needs counts as compiled: no program does it meanwhile."""
    made = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prepare.platformdirs, "user_cache_dir", lambda _name: str(made / "hapkit-studio"))
        for part in ("loop", "boards", "analysis"):
            prepare.stamp(part).parent.mkdir(exist_ok=True)
            prepare.stamp(part).touch()
    return made


@pytest.fixture(scope="module")
def folder(tmp_path_factory, prepared):
    """Return where the command left its pictures of a short look at each environment."""
    made = tmp_path_factory.mktemp("pictures")
    command = [sys.executable, "-m", "hapkit_studio.gui.shell.portraits", str(made), "--seconds", "0.3"]
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen", "XDG_CACHE_HOME": str(prepared)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return made


def described():
    """Return the environments on the page; a new one comes to it with ``make pictures``."""
    page = resources.path("docs", "environments.md").read_text(encoding="utf-8")
    return {key: e for key, e in LIBRARY.items() if f"| `{key}` |" in page}


@pytest.mark.slow
def test_one_command_takes_every_picture(folder):
    """As many as are kept, and of the same size; what moves in them is another moment."""
    names = {f"{key}{suffix}.png" for key in LIBRARY for suffix in ("", "-scene")}
    pictures = {path.name: QImage(str(path)) for path in folder.iterdir()}
    assert set(pictures) == names
    assert len({bytes(picture.constBits()) for picture in pictures.values()}) == len(names)
    for name in (f"{key}{suffix}.png" for key in described() for suffix in ("", "-scene")):
        assert QImage(str(resources.path("pictures", name))).size() == pictures[name].size()


def test_the_page_about_the_environments_is_up_to_date(monkeypatch, capsys):
    """``make pictures`` writes it; every picture in it is there."""
    monkeypatch.setattr(environments, "discover", described)
    page = resources.path("docs", "environments.md")
    assert main(("environments", "--markdown")) == 0
    wanted = capsys.readouterr().out
    assert page.read_text(encoding="utf-8") == wanted
    for line in wanted.splitlines():
        if line.startswith("!["):
            assert (page.parent / line.partition("(")[2].rstrip(")")).exists()


def test_bad_options_are_one_line(capsys):
    for argv in ([], [str(Path("x")), "--size", "big"], [str(Path("x")), "--seconds", "long"]):
        with pytest.raises(SystemExit) as error:
            portraits.options(argv)
        assert error.value.code == 2
        assert capsys.readouterr().err.count("\n") == 1
