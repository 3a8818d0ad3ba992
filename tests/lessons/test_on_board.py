"""Three lessons run on the firmware in the virtual board, with the scripted student's hand."""

import time

import numpy as np
import pytest

from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.lessons import library
from hapkit_studio.lessons.play import hand_of
from hapkit_studio.lessons.progress import Progress, evaluate_rows
from hapkit_studio.lessons.recent import Recent
from tests.firmware.vb import needs_board
from tests.lateness import ATTEMPTS, LATENESS
from tests.waiting import wait_until

# frames that a busy machine reads too late leave gaps in the samples, so these tests run alone
pytestmark = [needs_board, pytest.mark.alone]

KEYS = ("virtual_spring", "damping", "virtual_wall")
BEGIN = 2.0  # time in s of the board's clock by which the board is connected and renders
STEP = 0.02  # time in s between two commands to the hand


def commands(play):
    """Return the commands that move the board's hand like the scripted student's, by the board's clock."""
    hand, grip = hand_of(play), play.grip
    times = np.arange(0.0, min(play.seconds, play.release), STEP) if grip is not None else []
    moves = [
        f"{BEGIN + t:.3f} hand {float(hand.target(t + STEP)):.6f} "
        f"{grip.stiffness} {grip.damping} {grip.mass} {STEP}"
        for t in times
    ]
    return [*moves, f"{BEGIN + min(play.release, play.seconds):.3f} release"]


def rows_of(play, folder):
    """Return the rows of the engine's loop in one run on a board in lockstep.

    Raise an error for any fault except lateness.
    """
    script = folder / "hand.txt"
    script.write_text("\n".join(commands(play)) + "\n")
    engine = Engine(VirtualBoard("lockstep", script=script), play.environment.key, realtime=False)
    engine.start()
    try:
        engine.set_environment(play.environment, dict(play.values))
        loop = play.loop
        engine.change_loop({"delay": loop.delay, "estimator": loop.estimator, "controller": loop.controller})
        recent, begun = Recent(), []
        recent.follow(engine)

        def over():
            recent.read()
            tables = recent.rows().tables
            now = float(tables[-1][-1, rows.BOARD_TIME]) if tables else 0.0
            if not begun and now > BEGIN - 0.2:
                begun.append(now)
                recent.clear()
            return now > BEGIN + play.seconds or engine.fault is not None

        wait_until(over)
        assert engine.fault is None or engine.fault.code in LATENESS, engine.fault
        return recent.rows()
    finally:
        engine.close()


@pytest.mark.parametrize("key", KEYS)
def test_every_check_of_a_lesson_passes_on_the_board(key, tmp_path):
    lesson = library().lessons[key]
    progress = Progress(lesson)
    for number, step in enumerate(lesson.steps, 1):
        checks = [(number, check) for check in step.checks]
        for attempt in range(ATTEMPTS):
            if all(progress.result(check).correct for _, check in checks):
                break
            time.sleep(0.1 * attempt)
            for play in step.plays:
                for name, found in evaluate_rows(checks, rows_of(play, tmp_path), {}).items():
                    progress.note(name, found)
    texts = {check.key: progress.result(check).text for step in lesson.steps for check in step.checks}
    assert texts
    assert {name: text for name, text in texts.items() if "This is correct" not in text} == {}
