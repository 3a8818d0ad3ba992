"""Own environments: no foreign file runs without permission, and a changed file needs permission again."""

from dataclasses import replace

import pytest
from numba.core import event
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.gui.state.environment_library import EnvironmentLibrary
from hapkit_studio.gui.state.own_environments import BARE, describe, with_fitting_scene
from hapkit_studio.workshop import folder, reading
from hapkit_studio.workshop.functions import Functions
from hapkit_studio.workshop.source import read, typed
from hapkit_studio.workshop.trying import TrialResult, failed
from tests.gui.own_support import law_tab, put, spring, wait_for_verdict


def leaving(marker, text: str) -> str:
    """Return the text of a law that creates a file when it is executed."""
    return f"open({str(marker)!r}, 'w').close()\n{text}"


def passed(window, path):
    """Mark a file as tried, without starting a trial process."""
    tried = read(path)
    return lambda: window.own.runner.finished.emit((tried, TrialResult()))


@pytest.fixture
def window(home, reset_idle_window):
    """Return this test file's window with this test's folder as home."""
    reset_idle_window.own.runner.end()
    reset_idle_window.own.refresh()
    reset_idle_window.own.choose_built_in("wall")
    reset_idle_window.editor.close()
    return reset_idle_window


@pytest.mark.slow
def test_a_foreign_file_runs_only_after_its_source_was_shown(home, make_window, qtbot):
    marker = home / "it ran"
    path = put(home, "ada.py", leaving(marker, spring("ada", "Ada's spring")), trusted=False)
    window = make_window()
    row, source = window.gallery.own_rows[path], window.editor.editor.source
    assert (row.title, row.summary, row.picture) == ("Ada's spring", "File from someone else", "lock")
    QTest.mouseClick(row, Qt.MouseButton.LeftButton)
    assert source.isVisible()
    assert source.code.toPlainText() == path.read_text(encoding="utf-8")
    assert source.code.isReadOnly()
    assert window.gallery.rows["wall"].isChecked()
    source.leave.click()
    assert not source.isVisible()
    assert not marker.exists()
    window.own.choose(path)
    verdict = wait_for_verdict(window, qtbot, source.run.click)
    assert verdict.ok
    assert marker.exists()
    assert window.studio.environment.key == "ada"
    assert row.isChecked()
    assert row.summary == "For a test"
    again = make_window()
    verdict = wait_for_verdict(again, qtbot, lambda: again.own.choose(path))
    assert verdict.calls == 0  # the file was tried before, so it is loaded without a trial
    assert again.studio.environment.key == "ada"


def test_permission_for_one_text_allows_no_other_text(home, window):
    marker = home / "it ran"
    path = put(home, "ada.py", spring("ada"), trusted=False)
    window.own.refresh()
    window.own.choose(path)
    put(home, "ada.py", leaving(marker, spring("ada")), trusted=False)
    window.editor.editor.source.run.click()
    assert window.own.checking is None
    assert window.editor.editor.source.isVisible()
    assert window.editor.editor.source.code.toPlainText() == leaving(marker, spring("ada"))


def test_a_file_opened_from_another_folder_is_copied_after_asking(home, make_window, qtbot, tmp_path):
    marker, stranger = home / "it ran", tmp_path / "downloads" / "ada.py"
    stranger.parent.mkdir()
    stranger.write_text(leaving(marker, spring("ada")), encoding="utf-8")
    window = make_window()
    window.editor.bring(stranger)
    source = window.editor.editor.source
    assert source.isVisible()
    assert window.own.files == []
    stranger.write_text("raise SystemExit", encoding="utf-8")  # the file changes after its text was shown
    source.run.click()
    path = home / "environments" / "ada.py"
    window.own.runner.cancel()
    assert path.read_text(encoding="utf-8") == leaving(marker, spring("ada"))
    assert window.editor.path == path
    assert not marker.exists()


def test_a_changed_file_needs_permission_again(home, window, qtbot):
    path = put(home, "mine.py", spring("mine"))
    window.own.refresh()
    wait_for_verdict(window, qtbot, passed(window, path))
    assert window.studio.environment.key == "mine"
    window.studio.choose("wall")
    marker = home / "it ran"
    put(home, "mine.py", leaving(marker, spring("mine")), trusted=False)
    window.file_watcher.check_files()
    assert window.gallery.own_rows[path].picture == "lock"
    window.own.choose(path)
    assert window.editor.editor.source.isVisible()
    assert window.studio.environment.key == "wall"
    assert not marker.exists()


def test_the_loaded_text_is_the_tried_text(home, window, qtbot):
    path = put(home, "mine.py", spring("mine"))
    window.own.refresh()
    tried_out = passed(window, path)
    put(home, "mine.py", leaving(home / "it ran", spring("mine")), trusted=False)
    assert wait_for_verdict(window, qtbot, tried_out).ok
    assert window.studio.environment.source.text == spring("mine")
    assert not (home / "it ran").exists()
    assert window.gallery.own_rows[path].picture == "lock"


@pytest.mark.slow
def test_an_endless_function_is_switched_off_and_named_below_the_parameters(home, window, qtbot):
    check = "def check(p):\n    while 123 < p['stiffness'] < 124:\n        pass\n    return ''\n\n\n"
    text = spring("mine").replace("ENVIRONMENT = ", f"{check}ENVIRONMENT = ")
    path = put(home, "mine.py", text.replace("    force=force,", "    force=force,\n    check=check,"))
    window.own.refresh()
    assert wait_for_verdict(window, qtbot, passed(window, path)).ok
    assert window.studio.environment.functions.ready
    assert window.panel.warnings.texts == []
    window.studio.set_value("stiffness", 123.5)
    (line,) = window.panel.warnings.texts
    assert line.startswith("`check` of mine.py took more than 1 s")
    assert window.studio.values["stiffness"] == 123.5


def test_the_newer_of_two_texts_of_a_file_is_active(home, window, qtbot, monkeypatch):
    started = []
    monkeypatch.setattr(Functions, "begin", lambda self: None)
    monkeypatch.setattr(Functions, "ready", property(lambda self: bool(started)))
    check = "    force=force,\n    check=lambda p: '',"
    path = put(home, "mine.py", spring("mine", "First").replace("    force=force,", check))
    window.own.refresh()
    passed(window, path)()
    put(home, "mine.py", spring("mine", "Second"))
    assert wait_for_verdict(window, qtbot, passed(window, path)).ok
    started.append(True)
    QTest.qWait(100)
    assert window.studio.environment.title == "Second"


def test_a_law_open_in_the_editor_follows_its_file(home, make_window):
    path = put(home, "mine.py", spring("mine"))
    window = make_window()
    window.editor.edit(path)
    put(home, "mine.py", spring("mine", force="-p.stiffness * x * 2.0"), trusted=False)
    window.file_watcher.check_files()
    assert "* 2.0" in window.editor.page.text
    assert "Another program has changed this file" in window.editor.message.label.text()
    QTest.keyClicks(window.editor.page.code, "#")
    text = window.editor.page.text
    put(home, "mine.py", spring("mine"), trusted=False)
    window.file_watcher.check_files()
    assert window.editor.page.text == text


def test_two_files_with_the_same_key_are_distinguished(home, window, qtbot):
    first, second = put(home, "a.py", spring("same")), put(home, "b.py", spring("same", "Other"))
    window.own.refresh()
    assert wait_for_verdict(window, qtbot, passed(window, first)).ok
    verdict = wait_for_verdict(window, qtbot, passed(window, second))
    assert str(verdict.problems[0]) == 'The key "same" is already used by a.py: choose another one.'
    assert window.own.active == first


def test_a_deleted_file_leaves_the_gallery_and_the_loop(home, window, qtbot):
    path = put(home, "mine.py", spring("mine"))
    window.own.refresh()
    wait_for_verdict(window, qtbot, passed(window, path))
    assert window.gallery.own_rows[path].isChecked()
    path.unlink()
    window.editor.forget(path)
    assert window.gallery.own_rows == {}
    assert not window.gallery.own_heading.isVisible()
    assert window.studio.environment.key == "free"
    assert "mine" not in window.studio.environments


def test_endless_and_binary_files_do_no_harm(home, window):
    other = put(home, "bytes.py", spring())
    other.write_bytes(b"\xff\xfe\x00")
    path = put(home, "endless.py", "while True:\n    pass\n")
    window.own.refresh()
    assert window.gallery.own_rows[other].summary == "The file does not run yet"
    window.gallery.own_rows[other].click()
    assert window.studio.environment.key == "wall"
    window.own.choose(path)
    assert window.gallery.own_rows[path].summary == "Checking the file…"
    window.own.runner.end()


@pytest.mark.parametrize(
    ("text", "title", "summary"),
    [
        (spring(title="One"), "One", "For a test"),
        ("ENVIRONMENT = Environment(title='Not ' + 'read', summary='Two  words')", "A file", "Two words"),
        ("def broken(", "A file", ""),
        ("", "A file", ""),
    ],
)
def test_title_and_summary_are_read_without_running_the_file(tmp_path, text, title, summary):
    found = describe(tmp_path / "a_file.py", text, "ready")
    assert (found.title, found.summary) == (title, summary)


def version(tmp_path, *parameters: str):
    """Return an environment with the given parameters."""
    text = spring().replace(
        'Parameter("stiffness", "Stiffness", "N/m", 100.0, 0.0, 500.0)', ", ".join(parameters)
    )
    text = text.replace("import Parameter", "import Choice, Parameter").replace("-p.stiffness * x", "0.0")
    return reading.load_source(typed(tmp_path / "version.py", text))


def number(key: str, default: float, high: float = 9.0) -> str:
    return f'Parameter("{key}", "{key}", "N", {default}, 0.0, {high})'


def choice(*options: str) -> str:
    return f'Choice("side", "Side", {options!r})'


@pytest.mark.parametrize(
    ("scene", "parameter", "drawn"),
    [
        ("wall", number("position", 0.0, high=0.04), "wall"),
        ("wall", number("position", 0.0, high=0.05), BARE),
        ("wall", 'Choice("position", "P", ("a", "b"))', BARE),
        ("puck", number("mass", 0.5, high=1.0), BARE),  # the scene reads a state that the law does not have
        ("nowhere", number("position", 0.0), "nowhere"),
    ],
)
def test_a_library_scene_is_used_only_if_it_fits_the_law(tmp_path, scene, parameter, drawn):
    environment = version(tmp_path, parameter)
    assert with_fitting_scene(replace(environment, scene=scene)).scene == drawn


@pytest.mark.parametrize("template", folder.templates()[:2], ids=lambda t: t.key)
def test_a_template_uses_its_scene_as_long_as_it_fits(template, tmp_path):
    made = reading.load_source(typed(tmp_path / "mine.py", template.text))
    assert with_fitting_scene(made).scene == template.key
    wider = reading.load_source(typed(tmp_path / "mine.py", template.text.replace("0.04", "0.4")))
    assert with_fitting_scene(wider).scene == BARE


def test_values_are_kept_if_their_parameters_still_exist(tmp_path):
    moved, narrowed, untouched = number("a", 1.0), number("b", 1.0), number("c", 1.0)
    first = version(tmp_path, moved, narrowed, untouched, choice("left", "right"))
    library = EnvironmentLibrary({first.key: first})
    library.values[first.key].update(a=5.0, b=8.0, side=1.0)
    moved, narrowed, untouched = number("a", 2.0), number("b", 2.0, high=6.0), number("c", 3.0)
    library.put(
        version(tmp_path, moved, narrowed, untouched, choice("middle", "left", "right"), number("e", 4.0))
    )
    # an unchanged value follows its default; an option is kept by its name
    assert library.values[first.key] == {"a": 5.0, "b": 2.0, "c": 3.0, "side": 2.0, "e": 4.0}


# files that are added, removed or fail while the window is open


@pytest.mark.slow
def test_a_copied_or_removed_file_is_noticed_immediately(home, make_window, qtbot):
    window = make_window()
    assert window.own.files == []
    path = put(home, "ada.py", spring("ada", "First"), trusted=False)
    qtbot.waitUntil(lambda: path in window.gallery.own_rows)
    row = window.gallery.own_rows[path]
    path.write_text(spring("ada", "Second"), encoding="utf-8")
    qtbot.waitUntil(lambda: row.title == "Second")
    path.unlink()
    qtbot.waitUntil(lambda: window.own.files == [])


@pytest.mark.slow
def test_a_file_that_failed_is_still_marked_after_a_restart(home, make_window):
    path = put(home, "mine.py", spring("mine", force="-p.stifness * x"))
    fine = put(home, "fine.py", spring("fine"))
    window = make_window()
    assert window.gallery.own_rows[path].picture != "triangle"
    window.own.runner.finished.emit((read(path), failed("wrong", 10)))
    again = make_window()
    assert again.gallery.own_rows[path].summary == "The file does not run yet"
    assert again.gallery.own_rows[fine].summary == "For a test"
    put(home, "mine.py", spring("mine"))
    again.file_watcher.check_files()
    assert again.gallery.own_rows[path].summary == "For a test"


def test_selecting_a_built_in_environment_closes_a_shown_source(home, window):
    path = put(home, "ada.py", spring("ada"), trusted=False)
    window.own.refresh()
    source = window.editor.editor.source
    for leave in (
        lambda: QTest.mouseClick(window.gallery.rows["wall"], Qt.MouseButton.LeftButton),  # already active
        lambda: window.studio.choose("spring"),
        lambda: (path.unlink(), window.own.refresh()),
    ):
        window.own.choose(path)
        assert source.isVisible()
        leave()
        assert not source.isVisible()
        assert law_tab(window) is None


@pytest.mark.slow
def test_saving_a_law_does_not_compile_it_in_the_window_process(home, reset_window, qtbot):
    window = reset_window
    path = put(home, "mine.py", spring("mine"))
    window.editor.edit(path)
    wait_for_verdict(window, qtbot, window.editor.save)
    window.editor.page.code.setPlainText(spring("mine", force="-p.stiffness * x * 2.0"))
    with event.install_recorder("numba:compile") as compiled:
        assert wait_for_verdict(window, qtbot, window.editor.save).ok
        QTest.qWait(100)
    assert [str(e.data) for _, e in compiled.buffer] == []
