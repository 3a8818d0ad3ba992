"""Presets are saved, compared and restored; a damaged file gives one line per error and changes nothing."""

import random
import tomllib
from dataclasses import replace

import pytest

from hapkit_studio.dynamics.loop_settings import USUAL_LOOP
from hapkit_studio.errors import ParameterError
from hapkit_studio.files import MOST_BYTES
from hapkit_studio.gui.panel.preset_row import CompareDialog, SavePresetDialog
from hapkit_studio.gui.state import presets
from hapkit_studio.gui.state.undo import settings_of
from tests.environments.calling import LIBRARY
from tests.gui.window_support import label_texts, sheet_of, usual_loop

STIFF = {"stiffness": 900.0, "damping": 2.5, "position": -0.0125, "side": 1.0, "damping_mode": 1.0}


@pytest.fixture
def window(reset_idle_window):
    """Return this test file's window in its initial state, without a selected preset or undo steps."""
    reset_idle_window.presets._chosen.clear()
    reset_idle_window.history.forget()
    return reset_idle_window


def preset(folder, text):
    path = folder / "given.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize("key", LIBRARY)
def test_every_environments_values_are_restored_from_a_file(home, key):
    """The file is plain TOML: numbers in SI units, options by name."""
    environment = LIBRARY[key]
    rng = random.Random(key)
    settings = {
        ("value", key, p.key): p.default if p.discrete else rng.uniform(p.low, p.high)
        for p in environment.parameters
    }
    path = presets.write(environment, "Lab 3", settings)
    assert presets.found(key) == {"Lab 3": path}
    read = presets.read(path, LIBRARY) if not environment.check(environment.values()) else {}
    table = tomllib.loads(path.read_text())["values"]
    for p in environment.parameters:
        value = settings["value", key, p.key]
        assert table[p.key] == (p.text(value) if p.discrete else value)
        assert read.get(("value", key, p.key), value) == value


@pytest.mark.slow
def test_a_preset_is_saved_selected_and_restored_in_one_undo_step(window, home):
    studio, row = window.studio, window.panel.preset
    assert row.button.text() == "Default values"
    studio.set_values(STIFF)
    assert row.button.text() == "Your own values"
    window.presets.save("Lab 3, stiff wall", with_loop=False)
    assert (row.name.text(), row.button.text()) == ("Preset", "Lab 3, stiff wall")
    studio.reset_values()
    studio.set_values({"stiffness": 300.0, "damping": 2.5, "position": -0.0125})
    assert row.name.text() == "Changed preset"
    assert "stiffness 300 → 900 N/m" in row.button.toolTip()
    assert "position" not in row.button.toolTip()
    before, steps = settings_of(studio), window.history.stack.count()
    row.fill()
    (action,) = [a for a in row.menu.actions() if a.text() == "Lab 3, stiff wall"]
    assert "side Right → Left" in action.toolTip()
    action.trigger()
    assert studio.values == STIFF
    assert window.history.stack.count() == steps + 1
    assert window.history.stack.undoText() == "preset Lab 3, stiff wall"
    window.history.undo()
    assert settings_of(studio) == before
    window.actions_by_key.run("environment.restore_preset")
    assert studio.values == STIFF


def test_differences_are_listed_until_the_preset_is_applied(window, home):
    """Both values have the unit that the window shows, and the list follows later changes."""
    studio = window.studio
    studio.set_values(STIFF)
    studio.set_loop(delay=0.002, controller=True)
    window.presets.save("stiff", with_loop=True)
    studio.reset_values()
    studio.set_loop(**usual_loop())
    window.actions_by_key.run("environment.compare_presets")
    dialog = sheet_of(window, CompareDialog)
    lines = [
        ("Setting", "Present value", "Value in the preset"),
        ("Stiffness, N/m", "250", "900"),
        ("Damping, N·s/m", "0.0", "2.5"),
        ("Position, mm", "5.0", "−12.5"),
        ("Side", "Right", "Left"),
        ("Damping acts", "On the way in", "Both ways"),
        ("Added delay, ms", "0.0", "2.0"),
        ("Passivity controller", "off", "on"),
    ]
    assert dialog.table.texts() == lines
    studio.set_value("stiffness", 900.0)
    assert dialog.table.texts() == [lines[0], *lines[2:]]
    dialog.use.click()
    assert (studio.values, studio.loop.delay) == (STIFF, 0.002)
    assert dialog.table.texts() == lines[:1]
    assert dialog.verdict.label.text() == "The settings of this preset are already set."
    studio.choose("spring")
    assert not dialog.isVisible()


def test_the_next_start_shows_the_presets_name_and_differences(window, home):
    window.studio.set_values(STIFF)
    window.presets.save("stiff", with_loop=False)
    window.studio.set_value("stiffness", 300.0)
    window.state.save()
    window.presets._chosen.clear()
    window.state.restore()
    row = window.panel.preset
    assert (row.name.text(), row.button.text()) == ("Changed preset", "stiff")
    assert window.studio.values["stiffness"] == 300.0
    for damage in ("nothing", None):
        path = presets.found("wall")["stiff"]
        path.write_text(damage) if damage else path.unlink()
        window.presets._chosen.clear()
        window.state.restore()
        assert row.button.text() == "Your own values"


@pytest.mark.parametrize("model", ["everything", "frictionless"])
def test_the_loop_is_saved_in_a_preset_only_on_request(window, home, model):
    studio = window.studio
    chosen = {"rate": 2000.0, "delay": 0.002, "estimator": ("iir", {"cutoff": 50.0}), "controller": True}
    loop = replace(USUAL_LOOP, **chosen, model=model, hand="firm")
    studio.set_loop(**chosen, model=model, hand="firm")
    window.presets.save("alone", with_loop=False)
    window.presets.save("whole", with_loop=True)
    for name, after in (("alone", USUAL_LOOP), ("whole", loop)):
        studio.set_loop(**usual_loop())
        window.presets.apply(presets.found("wall")[name])
        assert studio.loop == after


def test_the_dialog_requires_a_valid_file_name(window, home):
    window.actions_by_key.run("environment.save_preset")
    dialog = sheet_of(window, SavePresetDialog)
    for name, good in (("", False), ("../up", False), ("a/b", False), ("x" * 24, True), ("x" * 25, False)):
        dialog.name.setText(name)
        assert dialog.save.isEnabled() == good, name
    dialog.name.setText("Übung 2 (soft)")
    dialog.save.click()
    assert presets.found("wall").keys() == {"Übung 2 (soft)"}
    assert not dialog.isVisible()


def test_a_preset_with_errors_lists_each_in_one_line_and_changes_nothing(window, tmp_path):
    """The limit of 5000 N/m is accepted; 1 % more is refused."""
    text = """
    environment = "wall"
    colour = "red"
    [values]
    stiffness = 5050.0
    stifness = 400.0
    side = "up"
    damping_mode = 1
    [loop]
    rate = true
    estimator = "magic"
    where = "board"
    grip = "soft"
    """
    before = settings_of(window.studio)
    window.presets.import_file(preset(tmp_path, text))
    texts = label_texts(sheet_of(window))[1:]
    for message in (
        "'colour'",
        "5,050",
        "'stifness'",
        "'up'",
        "not 1",
        "not True",
        "'magic'",
        "'where'",
        "'soft'",
    ):
        assert sum(message in line for line in texts) == 1, message
    assert len(texts) == 9
    assert settings_of(window.studio) == before
    assert window.history.stack.count() == 0
    assert presets.found("wall") == {}
    window.presets.import_file(preset(tmp_path, 'environment = "wall"\n[values]\nstiffness = 4950.0\n'))
    assert window.studio.values["stiffness"] == 4950.0
    assert presets.found("wall").keys() == {"given"}


def test_incompatible_values_are_refused(tmp_path):
    text = 'environment = "button"\n[values]\nsnap_start = 0.0035\ntravel = 0.003\n'
    with pytest.raises(ParameterError, match="press depth"):
        presets.read(preset(tmp_path, text), LIBRARY)


def damaged(rng, good):
    """Return a preset's text with one error in it, or random bytes."""
    kind = rng.randrange(6)
    if kind == 0:
        return rng.randbytes(rng.randrange(1, 400))
    if kind == 1:
        return good[: rng.randrange(1, len(good) - 1)] + b"\xff" + rng.randbytes(3)
    if kind == 2:
        wrong = rng.choice(
            ["nan", "inf", "true", '"900"', "[9]", "{a = 1}", "1979-05-27", "9" * 400, "9" * 5000]
        )
        return good.replace(b"900.0", wrong.encode())
    if kind == 3:
        return good + b"\nx = " + b"[" * rng.choice([500, 30_000])
    if kind == 4:
        return good + b"#" * MOST_BYTES
    return good.replace(b"stiffness", rng.choice([b"__import__('os')", b"_", b'"\\u0000"', b"values.x"]))


def test_200_damaged_files_give_messages_and_change_nothing(window, tmp_path, home, monkeypatch):
    window.studio.set_values(STIFF)
    window.presets.save("good", with_loop=True)
    good = presets.found("wall")["good"].read_bytes()
    rng, before = random.Random(15), settings_of(window.studio)
    texts = []
    monkeypatch.setattr(window.presets, "_show_message", lambda _title, lines: texts.append(lines))
    window.history.forget()
    for at in range(200):
        window.presets.import_file(preset(tmp_path, damaged(rng, good)))
        assert len(texts) == at + 1
        assert 1 <= len(texts[at]) < 4, at
        assert all(10 < len(line) < 170 and "\n" not in line for line in texts[at])
    assert settings_of(window.studio) == before
    assert window.history.stack.count() == 0
    assert presets.found("wall").keys() == {"good"}


def test_a_missing_file_gives_a_message(window, tmp_path):
    window.presets.import_file(tmp_path / "away.toml")
    assert "Cannot read away.toml: No such file or directory." in label_texts(sheet_of(window))
