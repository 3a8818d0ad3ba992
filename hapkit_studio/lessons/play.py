"""Plays a lesson without a window: a scripted student uses the simulated Hapkit.

Authors of lessons and tests use it.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import SCRIPTS, Grip, Hand
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics import headless, rows
from hapkit_studio.lessons.evaluate import Result, evaluate
from hapkit_studio.lessons.lesson import Check, Lesson, Play, Question, Step
from hapkit_studio.lessons.samples import Samples
from hapkit_studio.sessions import settings_events
from hapkit_studio.settings_log import LoggedSettings

_PAUSE = 0.5  # s: pause between two runs
DEVICE = SimulatedHapkit()


@dataclass(frozen=True)
class Played:
    """A scripted student's work in one step: the runs' telemetry rows, their settings, and the answers."""

    tables: tuple[np.ndarray, ...]
    settings: tuple[LoggedSettings, ...]
    answers: Mapping[str, str]

    def samples(self, known: Mapping[str, Environment] | None = None) -> Samples:
        """Return the runs as one recording."""
        starts = [float(table[0, rows.HOST_TIME]) for table in self.tables]
        log = [(start - starts[0], one) for start, one in zip(starts, self.settings, strict=True)]
        return Samples.of_rows(np.concatenate(self.tables), log, known)


def hand_of(play: Play) -> Hand:
    if isinstance(play.path, str):
        script = SCRIPTS[play.path]
        if play.path == "released" or play.grip is None:
            return SCRIPTS["released"]
        target, release = script.target, min(script.release, play.release)
    else:
        times, places = (np.array(column) for column in zip(*play.path, strict=True))

        def target(t):
            return np.interp(t, times, places)

        release = play.release
    grip = play.grip or Grip(0.0, 0.0, 0.0)
    return Hand(grip.mass, grip.damping, grip.stiffness, target, release, vectorised=True)


def render(play: Play) -> np.ndarray:
    """Return a run's telemetry rows (n, ROW_WIDTH); the handle starts at rest at the path's first point."""
    start = 0.0 if isinstance(play.path, str) else play.path[0][1]
    device = SimulatedHapkit(initial_position=start)
    scene = headless.Scene(play.environment, play.values, device, play.loop)
    out, _ = headless.render(scene, hand_of(play), round(play.seconds * play.loop.rate))
    return out


def settings_in(play: Play) -> LoggedSettings:
    """Return a run's settings in the form in which sessions store them."""
    return {
        **settings_events.of_scene(play.environment, dict(play.values)),
        "state_names": list(play.environment.state_names),
        "hand": "own",
        "rate_Hz": play.loop.rate,
        "delay_s": play.loop.delay,
        "estimator": list(play.loop.estimator)
        if isinstance(play.loop.estimator, tuple)
        else play.loop.estimator,
        "controller": play.loop.controller,
        "max_force_N": DEVICE.max_force,
        "device": "Simulated Hapkit",
        "quantum_m": DEVICE.quantum,
    }


def play_step(step: Step, plays: Iterable[Play] | None = None, begin: float = 0.0) -> Played:
    """Play a step's runs one after another, starting at ``begin`` in s.

    ``plays`` replaces the step's runs.
    """
    tables: list[np.ndarray] = []
    settings: list[LoggedSettings] = []
    for play in step.plays if plays is None else plays:
        table = render(play)
        table[:, rows.HOST_TIME] = table[:, rows.BOARD_TIME] = begin + np.arange(len(table)) / play.loop.rate
        begin = float(table[-1, rows.HOST_TIME]) + _PAUSE
        tables.append(table)
        settings.append(settings_in(play))
    answers = {question.key: question.example for question in step.questions}
    return Played(tuple(tables), tuple(settings), answers)


def play_lesson(lesson: Lesson) -> list[tuple[Step, Played]]:
    """Play every step that has runs or questions; all steps have a common time axis."""
    found: list[tuple[Step, Played]] = []
    begin = 0.0
    for step in lesson.steps:
        played = play_step(step, begin=begin)
        if played.tables:
            begin = float(played.tables[-1][-1, rows.HOST_TIME]) + _PAUSE
        found.append((step, played))
    return found


def results(played: Iterable[tuple[Step, Played]]) -> list[tuple[Check | Question, Result]]:
    """Return the result of every check and question; each is evaluated on the samples of its own step."""
    found: list[tuple[Check | Question, Result]] = []
    for step, one in played:
        samples = one.samples() if one.tables else None
        for block in step.blocks:
            if isinstance(block, Question):
                found.append((block, Result(*block.judge(one.answers[block.key]))))
            elif isinstance(block, Check):
                nothing = Result("waiting", "Nothing was recorded: this step has no `play` block.")
                found.append((block, nothing if samples is None else evaluate(block, samples)))
    return found
