"""Demos do what their captions say, end when the user acts, and a damaged file changes nothing."""

import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

import hapkit_studio as hs
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import ParameterError
from hapkit_studio.files import MOST_BYTES
from hapkit_studio.gui.state import presets
from hapkit_studio.gui.state.undo import settings_of
from hapkit_studio.gui.teach import demos
from hapkit_studio.haptics import rows
from tests.environments.calling import LIBRARY
from tests.gui.demo_support import Clock, fast_studio, play
from tests.gui.window_support import label_texts, sheet_of

STORY = """title = "Two walls"
seconds = 10.0
[[step]]
at = 0.0
environment = "wall"
set = {stiffness = 900.0, side = "left"}
loop = {delay = 0.002, grip = "firm"}
hand = [[0.0, -5.0], [2.0, 12.0]]
caption = "One"
[[step]]
at = 4.0
set = {stiffness = 100.0}
caption = "Two"
[[step]]
at = 8.0
environment = "spring"
hand = "release"
"""
COUNT = 20.7e-6  # resolution of the simulated sensor in m


def written(folder, text=STORY):
    path = folder / "story.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


# captions


@pytest.fixture
def played_demo(qtbot):
    """Yield a function that plays two rounds of a shipped demo and returns the second round."""
    studio = fast_studio(qtbot)
    yield lambda name: play(studio, demos.shipped()[name], rounds=2)
    studio.close()


def peak_to_peak(out, seconds):
    """Return the peak-to-peak motion of the handle in the last seconds."""
    return np.ptp(out[-round(1000 * seconds) :, rows.TRUE_POSITION])


@pytest.mark.slow
def test_a_wall_buzzes_above_its_limit_and_is_calm_below(played_demo):
    played = played_demo("buzzing_wall")
    steps = {step.at: step.settings for step in played.demo.steps}
    grip = GRIPS[steps[0.0]["loop", "hand"]]

    def limit(at):
        delay = steps[at]["loop", "delay"]
        return hs.stiffness_limit(0.044 + grip.mass, 0.5 + grip.damping, rate=1000.0, delay=delay)

    for at, calm in ((0.0, True), (9.0, False), (16.0, True), (22.0, True)):
        stiffness, out = steps[at]["value", "wall", "stiffness"], played.of(at)
        assert (stiffness < limit(at)) == calm
        assert peak_to_peak(out, 4.0) < COUNT if calm else peak_to_peak(out, 4.0) > 2e-3
        assert out[-1, rows.APPLIED_FORCE] < 0.0 or not calm, "the hand rests in the wall"
    assert {steps[9.0]["value", "wall", "stiffness"], steps[22.0]["value", "wall", "stiffness"]} == {3000.0}


@pytest.mark.slow
def test_friction_keeps_the_handle_where_a_spring_would_return_it(played_demo):
    played = played_demo("friction_that_sticks")
    pulled, free = played.of(0.0)[-1, rows.TRUE_POSITION], played.of(5.0)[-1, rows.TRUE_POSITION]
    assert pulled > 15e-3
    assert abs(free) < 0.1 / 80.0 + COUNT  # friction of 0.1 N holds the paddle against 80 N/m
    held, out = played.of(9.0)[-1, rows.TRUE_POSITION], played.of(14.0)
    anchor = out[-1, rows.STATE]
    assert held > 15e-3
    assert np.abs(out[:, rows.TRUE_POSITION] - anchor).max() < 0.8 / 500.0 + COUNT
    assert peak_to_peak(out, 3.0) == 0.0
    pull = played.of(19.0, 1.0)[:, rows.APPLIED_FORCE]
    breaks = int(np.argmax(pull))
    assert pull[breaks] == pytest.approx(1.5, abs=500.0 * COUNT)
    assert pull[breaks + 500 :] == pytest.approx(0.4, abs=500.0 * COUNT)


def energy(out):
    """Return the energy ½ m v² + ½ k x² in each row, for 0.5 kg, 300 N/m, and a rest position of 10 mm."""
    place, speed = out[:, rows.STATE] - 0.01, out[:, rows.STATE + 1]
    return 0.25 * speed**2 + 150.0 * place**2


@pytest.mark.slow
def test_explicit_euler_gains_energy_as_predicted_and_the_exact_integrator_none(played_demo):
    """Explicit Euler multiplies an undamped energy by 1 + ω²T² per step, where ω² = k/m.

    Implicit Euler multiplies it by the inverse, and the exact integrator by one.
    """
    played = played_demo("integrator_gains_energy")
    for at, factor in ((5.0, 1.0), (12.0, 1.0006), (23.0, 1.0 / 1.0006)):
        held = energy(played.of(at, 0.1))  # the integrator is active and the force has faded in
        np.testing.assert_allclose(held[1:] / held[:-1], factor, rtol=1e-9)
    semi = energy(played.of(16.0, 0.1))
    assert np.ptp(semi) < 1.01 * (600.0**0.5 * 1e-3) * semi.mean()  # varies by ωT, but does not drift
    assert energy(played.of(12.0))[-1] > 4.0 * energy(played.of(5.0))[-1]
    swing = played.of(0.0, 4.0)[:, rows.STATE]
    assert np.ptp(swing) > 0.01
    for at in (5.0, 12.0, 16.0, 23.0):
        assert not played.of(at)[:, rows.APPLIED_FORCE].any(), "the handle stays out of its way"


@pytest.mark.slow
@pytest.mark.parametrize("name", demos.shipped())
def test_every_caption_is_shown_in_order(played_demo, name):
    played = played_demo(name)
    captions = list(dict.fromkeys(played.captions))
    assert captions == [step.caption for step in played.demo.steps]
    assert all(captions)
    assert not (played.rows[:, rows.FLAGS].astype(int) & (rows.STOPPED | rows.FAULT)).any()


# in the window


@pytest.fixture
def shown(reset_window):
    """Return this test file's running window; the test sets the clock of its demos."""
    reset_window.demos.clock = Clock()
    reset_window.history.forget()
    yield reset_window
    reset_window.demos.end()


@pytest.mark.slow
def test_a_demo_follows_its_clock_and_restores_the_settings(shown, tmp_path):
    studio, player = shown.studio, shown.demos
    studio.set_values({"stiffness": 1234.0})
    before, steps = settings_of(studio), shown.history.stack.count()
    hands = []
    studio.engine.move_hand, own = hands.append, studio.engine.move_hand
    try:
        shown.play_demo(written(tmp_path))
        for now, stiffness, side, hand, caption in (
            (0.0, 900.0, 1.0, -0.005, "One"),
            (1.0, 900.0, 1.0, 0.0035, "One"),
            (4.0, 100.0, 1.0, 0.012, "Two"),
            (9.0, None, None, None, "Two"),
            (11.0, 900.0, 1.0, 0.0035, "One"),
        ):
            player.clock.now = now
            player.tick()
            assert hands[-1] == (None if hand is None else pytest.approx(hand))
            assert shown.caption.label.text() == caption
            assert shown.caption.isVisible()
            if stiffness:
                assert (studio.values["stiffness"], studio.values["side"]) == (stiffness, side)
                assert (studio.loop.delay, studio.grip) == (0.002, "firm")
            else:
                assert studio.environment.key == "spring"
        shown.caption.leave.click()
    finally:
        studio.engine.move_hand = own
    assert hands[-1] is None
    assert shown.caption.isHidden()
    assert settings_of(studio) == before
    assert shown.history.stack.count() == steps


def test_moving_the_handle_or_changing_a_setting_ends_a_demo(shown, tmp_path, monkeypatch):
    studio, path = shown.studio, written(tmp_path)
    # on a slow computer, the hand could be released while the demo's stiff wall still accelerates the handle,
    # which would cause an over-speed fault
    monkeypatch.setattr(studio, "release_at_rest", lambda: None)
    before = settings_of(studio)
    scene = shown.centre.scene

    def press_key():
        scene.setFocus()
        QTest.keyClick(scene, Qt.Key.Key_Right)

    def press_mouse():
        QTest.mousePress(scene, Qt.MouseButton.LeftButton, pos=QPoint(scene.width() // 2, 30))
        QTest.mouseRelease(scene, Qt.MouseButton.LeftButton)

    for take in (press_key, press_mouse, shown.display.release_here, studio.stop, shown.demos.end):
        shown.play_demo(path)
        assert studio.values["stiffness"] == 900.0
        take()
        assert shown.demos.demo is None
        assert settings_of(studio) == before
        if studio.stopped:
            assert not shown.actions_by_key.qt["teach.open_demo"].isEnabled()
            studio.release_stop()
        scene.release()
    shown.play_demo(path)
    studio.set_value("damping", 3.0)
    assert shown.demos.demo is None
    assert settings_of(studio) == before | {("value", "wall", "damping"): 3.0}


def test_a_demo_waits_until_its_environments_are_ready(shown, tmp_path, monkeypatch):
    state = {"spring": "preparing"}
    monkeypatch.setattr(shown.studio.readiness, "state", lambda key: state.get(key, "ready"))
    shown.play_demo(written(tmp_path))
    shown.demos.clock.now = 5.0
    shown.demos.tick()
    assert shown.studio.values["stiffness"] == 250.0
    assert shown.caption.label.text() == "The demo begins as soon as everything is ready."
    state.clear()
    shown.demos.tick()
    assert shown.studio.values["stiffness"] == 900.0  # the demo's time starts only now


@pytest.mark.slow
def test_a_demo_on_a_motor_waits_for_render_and_moves_no_hand(board_window, tmp_path):
    window, studio = board_window, board_window.studio
    window.demos.clock = Clock()
    moves = []
    studio.engine.move_hand = moves.append
    window.play_demo(written(tmp_path))
    assert studio.waits_for_render
    assert studio.engine.stopped
    assert (studio.values["stiffness"], studio.loop.rate) == (900.0, 1000.0)
    assert "the force is zero until you press Render" in window.caption.note.text()
    studio.release_stop()
    assert not studio.stopped
    assert window.caption.note.text() == (
        "A board has no virtual hand, so the demo changes settings and captions only."
    )
    window.demos.clock.now = 4.0
    window.demos.tick()
    assert studio.values["stiffness"] == 100.0
    studio.stop()
    assert window.demos.demo is None
    assert moves == []
    assert studio.stopped


def test_no_demo_is_played_while_a_setting_is_locked(shown, tmp_path):
    studio, before = shown.studio, settings_of(shown.studio)
    shown.play_demo(written(tmp_path))
    studio.permissions.set_lock(
        replace(studio.permissions.lock, places=frozenset({("value", "wall", "stiffness")}))
    )
    assert (shown.demos.demo, settings_of(studio)) == (None, before)
    shown.play_demo(written(tmp_path))
    assert "A demo cannot play while settings are locked or hidden." in label_texts(sheet_of(shown))
    assert not shown.actions_by_key.qt["teach.open_demo"].isEnabled()
    studio.permissions.set_lock(replace(studio.permissions.lock, places=frozenset()))


@pytest.mark.slow
def test_shipped_demos_are_in_the_menu_and_on_the_command_line(shown, start_window, capsys):
    entries = [key for key in shown.actions_by_key.qt if key.startswith("teach.demo.")]
    assert [key.rpartition(".")[2] for key in entries] == list(demos.shipped())
    for key in entries:
        shown.actions_by_key.run(key)
        assert shown.demos.demo.title in shown.actions_by_key.qt[key].text()
    shown.actions_by_key.run("teach.end_demo")
    assert shown.demos.demo is None
    for option in ("buzzing_wall", str(demos.shipped()["buzzing_wall"]), None):
        window = start_window("--demo", *([option] if option else []))
        assert window.demos.demo.title == "The limit of a wall"
        window.close()
    with pytest.raises(ParameterError, match=r"no demo or file 'nowhere'.*buzzing_wall"):
        start_window("--demo", "nowhere")


# damaged files


@pytest.mark.slow
@pytest.mark.parametrize(
    ("good", "bad", "message"),
    [
        ("stiffness = 900.0", "stiffness = 5050.0", "0 and 5,000 N/m, not 5,050"),
        ("stiffness = 900.0", "stiffness = nan", "not nan"),
        ("stiffness = 900.0", "stifness = 9.0", "no parameter 'stifness'"),
        ('side = "left"', "side = 1", "not 1"),
        ("delay = 0.002", "delay = 0.101", "0 and 0.1 s, not 0.101"),
        ("delay = 0.002", 'where = "board"', "no 'where'"),
        ('"spring"', '"sprung"', "environment 'sprung' is not installed"),
        ("[2.0, 12.0]", "[2.0, 60.6]", "−60 and 60 mm, not 60.6"),
        ("[2.0, 12.0]", "[0.0, 12.0]", "must increase: 0 s comes after 0 s"),
        ("[2.0, 12.0]", "[2.0]", "[time in s, position in mm], not [2.0]"),
        ('"release"', '"drop"', "not 'drop'"),
        ("at = 4.0", "at = 0.0", "must be between 0 s"),
        ("at = 8.0", "at = 10.0", "and 10 s, not 10 s"),
        ("at = 0.0", "at = 1.0", "first step must be at 0 s, not 1 s"),
        ('caption = "Two"', "caption = 2", "not 2"),
        ('caption = "Two"', 'stop = "now"', "cannot have the entry 'stop'"),
        ("seconds = 10.0", "seconds = 0.5", "1 and 3,600 s, not 0.5"),
        ('title = "Two walls"', "", "title must be one line of at most 40 characters, not None"),
        ("[[step]]", "[step.x]", "steps, each starting with [[step]]"),
    ],
)
def test_an_error_in_a_file_gives_a_one_line_message(shown, tmp_path, good, bad, message):
    before = settings_of(shown.studio)
    text = STORY.replace(good, bad) if bad != "[step.x]" else STORY.partition(good)[0] + bad
    shown.play_demo(written(tmp_path, text))
    shown_texts = label_texts(sheet_of(shown))
    assert shown_texts[0] == "story.toml: no demo was played"
    assert len(shown_texts) == 2
    assert message in shown_texts[1].replace("-60", "−60")
    assert (settings_of(shown.studio), shown.demos.demo) == (before, None)


def damaged(rng, good):
    """Return a demo's text with one error in it."""
    kind = rng.randrange(5)
    if kind == 0:
        at = rng.randrange(len(good))
        return good[:at] + bytes([good[at] ^ 0x80]) + good[at + 1 :]  # no longer UTF-8
    if kind == 1:
        return good[: rng.randrange(1, good.rindex(b"[[step]]"))].rstrip() + b"\n[[step]]\n"
    if kind == 2:
        wrong = rng.choice(["nan", "-inf", "true", '"9"', "[]", "{a = 1}", "1979-05-27", "9" * 400, "-1e3"])
        what = rng.choice([b"3000.0", b"400.0", b"36.0", b"9.0", b"0.003"])
        return good.replace(what, wrong.encode(), 1)
    if kind == 3:
        return good + rng.choice([b"#" * MOST_BYTES, b"x = " + b"[" * 30_000, rng.randbytes(99)])
    word = rng.choice([b"step", b"at", b"set", b"hand", b"caption", b"stiffness", b"title"])
    return good.replace(word, rng.choice([b"__import__('os')", b"_", b'"\\u0000"', b"loop.x"]), 1)


def test_200_damaged_files_give_messages_and_change_nothing(tmp_path):
    good = Path(demos.shipped()["buzzing_wall"]).read_bytes().partition(b"\n")[2]
    rng = random.Random(15)
    for at in range(200):
        path = written(tmp_path, damaged(rng, good))
        with pytest.raises(presets.PresetError) as caught:
            demos.read(path, LIBRARY)
        (line,) = caught.value.lines
        assert 10 < len(line) < 180, at
        assert "\n" not in line
