"""The program starts, compiles, plots and ends; a wrong option gives a one-line message."""

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QImage

from hapkit_studio import lab
from hapkit_studio.arguments import window_parser
from hapkit_studio.gui.shell import app
from hapkit_studio.gui.state import prepare
from hapkit_studio.gui.widgets.theme import theme
from tests.gui.window_support import PATIENCE_MS

OFF_THE_WAY = (
    *("scipy.linalg", "scipy.optimize", "scipy.signal", "matplotlib", "pandas"),
    *("hapkit_studio.laws.c_source", "hapkit_studio.workshop.sketch"),
    *("hapkit_studio.analysis.stability.on_board", "hapkit_studio.gui.wizard.setup"),
)


def waiting_program() -> subprocess.Popen:
    """Start a program that ends when its input is closed."""
    return subprocess.Popen([sys.executable, "-c", "import sys; sys.stdin.read()"], stdin=subprocess.PIPE)


@pytest.mark.slow
def test_it_starts_prepares_once_and_saves_a_picture(tmp_path):
    picture = tmp_path / "window.png"
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen", "XDG_CACHE_HOME": str(tmp_path)}
    program = (
        "import sys; from hapkit_studio.gui.shell import app; code = app.run(sys.argv[1:]); "
        "print(*sys.modules); sys.exit(code)"
    )
    options = ["--theme", "dark", "--size", "1280x720", "--screenshot", str(picture), "--seconds", "1"]
    command = [sys.executable, "-c", program, *options]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=180, check=False)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    image = QImage(str(picture))
    assert (image.width(), image.height()) == (1280, 720)
    average = image.scaled(1, 1, mode=Qt.TransformationMode.SmoothTransformation).pixelColor(0, 0)
    assert average.lightness() < 60
    # slow imports that are not needed yet must not delay the first sample
    assert not {*OFF_THE_WAY} & {*done.stdout.split()}


SIGNAL = """
import os, signal, sys
from hapkit_studio.gui.shell import app
from hapkit_studio.gui import scenes
paint, left = scenes.SceneView.paintEvent, [20]
def then_signal(view, event):
    paint(view, event)
    left[0] -= 1
    if left[0] == 0:
        os.kill(os.getpid(), signal.{name})
scenes.SceneView.paintEvent = then_signal
sys.exit(app.run([]))
"""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "code"), [("SIGTERM", 0), ("SIGINT", 130)])
def test_a_signal_while_a_picture_is_taken_ends_the_program_without_output(name, code, tmp_path):
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen", "XDG_CACHE_HOME": str(tmp_path)}
    command = [sys.executable, "-c", SIGNAL.format(name=name)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=180, check=False)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    assert "QBackingStore" not in done.stderr


def test_an_unknown_environment_gives_a_one_line_message(qapp, capsys):
    assert app.run(["--environment", "swamp"]) == 2
    output = capsys.readouterr().err
    assert "swamp" in output
    assert output.count("\n") == 1


def test_a_mistake_in_the_labs_file_is_shown_in_the_window_and_no_loop_starts(
    start_window, qtbot, monkeypatch, tmp_path
):
    file = tmp_path / "lab.toml"
    file.write_text("force_limit = 'two'\n", encoding="utf-8")
    monkeypatch.setattr(lab, "path", lambda: file)
    lab.settings.cache_clear()
    compiled = []
    monkeypatch.setattr(prepare, "begin", lambda *part: compiled.append(part))
    try:
        window = start_window("--device", "virtual-board")
        app.begin(window, window_parser().parse_args([]))
        qtbot.waitUntil(lambda: window.banners.get("device") is not None, timeout=PATIENCE_MS)
        notice = window.banners.get("device")
        assert notice.title == "lab.toml: force_limit is 'two'; it must be a number from 0.1 to 100 N."
        assert notice.text.startswith(f"The force stays zero. Correct {file}")
        assert not {"Try again", "Use simulated Hapkit"} & {text for text, _ in notice.buttons}
        assert window.studio.engine is None
        assert [entry.key for entry in window.studio.device.entries()] == ["simulated"]
        assert compiled == []  # nothing delays the message
        window.studio.device.open_simulated()
        qtbot.waitUntil(lambda: window.studio.link.state == "failed", timeout=PATIENCE_MS)
        assert window.studio.engine is None
    finally:
        lab.settings.cache_clear()


def test_the_stamp_depends_on_sources_and_cache(monkeypatch, tmp_path):
    monkeypatch.setattr(prepare.platformdirs, "user_cache_dir", lambda *_, **__: str(tmp_path))
    monkeypatch.setattr(prepare, "_has_law", lambda _key: True)
    before = prepare.stamp("loop")
    assert not prepare.prepared("loop")
    before.touch()
    assert prepare.begin("loop") is None
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "other"))
    assert prepare.stamp("loop") != before
    monkeypatch.undo()
    assert prepare.stamp("loop") != prepare.stamp("boards")


def test_the_window_runs_while_programs_compile_and_ends_them_on_closing(shared_window, qtbot):
    first, last, done = waiting_program(), waiting_program(), []

    def steps():
        yield [None]
        yield [first]
        done.append(first.poll())
        yield [last]
        done.append("never")

    app.Preparation(shared_window, steps()).run()
    assert done == []
    first.stdin.close()
    qtbot.waitUntil(lambda: done == [0])
    shared_window.closed.emit()
    assert last.poll() is not None
    assert done == [0]


@pytest.mark.slow
def test_every_theme_paints_the_whole_window(shared_window, qapp):
    shared_window.resize(1280, 720)
    shared_window.rail_names.dismiss()
    for mode in ("light", "dark", "contrast"):
        theme.set_mode(mode)
        qapp.processEvents()
        image = shared_window.grab().toImage()
        assert image.pixelColor(660, 100).name() in {theme.color(t).name() for t in ("scene", "surface")}
        assert image.pixelColor(70, 400).name() == theme.color("canvas").name()
        assert image.pixelColor(3, 35).name() == theme.color("side").name()


@pytest.mark.slow
def test_a_window_as_large_as_the_screen_is_restored_at_its_size(qapp, start_window):
    """On a screen of the same size, Qt would reduce the window to leave room for a frame."""
    room = qapp.primaryScreen().availableGeometry()
    first = start_window()
    first.setWindowFlag(Qt.WindowType.FramelessWindowHint)
    first.setGeometry(room)
    first.show()
    first.close()
    again = start_window()
    assert again.geometry() == room


@pytest.mark.parametrize("screen", [(1280, 800), (1920, 1080), (960, 540)])
def test_the_first_window_fits_the_screen_with_a_title_bar_of_40_px(screen):
    sizes = []
    window = SimpleNamespace(
        settings=SimpleNamespace(geometry=lambda *_: False),
        restoreGeometry=None,
        screen=lambda: SimpleNamespace(availableSize=lambda: QSize(*screen)),
        resize=sizes.append,
    )
    app._place(window, None)
    (size,) = sizes
    assert size.width() <= screen[0]
    assert size.height() + 40 <= screen[1]
