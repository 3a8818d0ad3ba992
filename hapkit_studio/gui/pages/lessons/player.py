"""Runs a lesson: applies each step's scene, checks the device's data, and stores the progress."""

import json
import math
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.errors import ParameterError, StudioError
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.state.background import Job
from hapkit_studio.gui.state.lock import LOOP, Place
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.state.undo import ENVIRONMENT, HAND, Snapshot, differing, put, settings_of
from hapkit_studio.lessons.lesson import Lesson, Question, Scene, Step
from hapkit_studio.lessons.progress import Evaluated, Progress, evaluate_rows, file_of, load
from hapkit_studio.lessons.recent import Recent

if TYPE_CHECKING:
    from hapkit_studio.devices import DeviceEntry

READ_MS, EVALUATE_MS, SAVE_MS = 100, 500, 2000
_LOOP = "rate", "delay", "estimator", "controller"  # loop settings that a step sets
_RATE = "loop", "rate"
# key of the setting with the recordings' paths; maximum number of recordings per lesson
_RECORDINGS, _MOST_RECORDINGS = "lesson_recordings", 20
_SIMULATED = "simulated"


def scene_settings(scene: Scene) -> Snapshot:
    """Return the settings at the start of a step, with the keys that undo uses."""
    key = scene.environment.key
    found: Snapshot = {ENVIRONMENT: key, HAND: scene.grip}
    found |= {("value", key, name): value for name, value in scene.values.items()}
    return found | {("loop", name): getattr(scene.loop, name) for name in _LOOP}


def locked_places(scene: Scene) -> set[Place]:
    """Return the settings that a step locks."""
    key = scene.environment.key
    names = {"loop": LOOP, "environment": ENVIRONMENT}
    return {names.get(name, ("value", key, name)) for name in scene.lock}


class LessonPlayer(QObject):
    """Opens lessons and steps, evaluates the open step's checks twice a second, and saves the progress.

    ``opened`` is emitted when a lesson was opened or closed. ``step_changed`` is emitted when the user goes
    to another step. ``evaluated`` is emitted when a result has changed. ``applied`` is emitted when the
    step's scene is active. ``failed`` is emitted with a sentence that says which action failed, and why.
    """

    opened = Signal()
    step_changed = Signal()
    applied = Signal()
    evaluated = Signal()
    failed = Signal(str, str)

    def __init__(self, studio: Studio, live: Live, parent: QObject):
        super().__init__(parent)
        self._studio, self._live = studio, live
        self.progress: Progress | None = None
        self.student = ""
        self._recent = Recent()
        self._before: Snapshot = {}
        self._device_before: DeviceEntry | None = None
        self._waiting = False
        self._reads = QTimer(self, interval=READ_MS)
        self._reads.timeout.connect(self._recent.read)
        self._evaluations = QTimer(self, interval=EVALUATE_MS)
        self._evaluations.timeout.connect(self.evaluate)
        self._save_soon = QTimer(self, interval=SAVE_MS, singleShot=True)
        self._save_soon.timeout.connect(self.save)
        self._job = Job(self, needs="")
        self._job.finished.connect(self._take)
        self._job.failed.connect(lambda why: self.failed.emit("The checks cannot be evaluated.", why))
        self._saving = Job(self, needs="", must_finish=True)
        self._saving.failed.connect(lambda why: self.failed.emit("The progress was not saved.", why))
        self._settings = StoredSettings()
        self._newest = studio.recording.newest
        studio.recording.changed.connect(self._note_recording)
        studio.engine_changed.connect(self._follow)
        studio.readiness.changed.connect(self._go_on)

    # the lesson

    @property
    def lesson(self) -> Lesson | None:
        """Return the open lesson."""
        return None if self.progress is None else self.progress.lesson

    @property
    def step(self) -> Step | None:
        """Return the open step."""
        return None if self.progress is None else self.progress.lesson.steps[self.progress.step]

    def progress_of(self, lesson: Lesson) -> Progress:
        """Return the user's progress in any lesson; a file that cannot be read is renamed."""
        if self.progress is not None and self.progress.lesson is lesson:
            return self.progress
        path = file_of(lesson)
        if not path.exists():
            return Progress(lesson)
        try:
            return load(path, lesson, self._studio.environments)
        except StudioError as error:
            aside = path.with_suffix(".damaged")
            with suppress(OSError):
                path.replace(aside)
            self.failed.emit(
                f"{lesson.title} starts from the beginning.", f"{error} The file was renamed to {aside.name}."
            )
            return Progress(lesson)

    def open(self, lesson: Lesson) -> None:
        """Open a lesson at the step that was last open."""
        self.leave()
        self._studio.permissions.set_lesson()  # a running demo ends, and its changes are undone
        self.progress = self.progress_of(lesson)
        self._before = settings_of(self._studio)
        self._follow()
        self.opened.emit()
        self.go(self.progress.step)
        self._reads.start()
        self._evaluations.start()

    def leave(self) -> None:
        """Close the lesson: save the progress and restore the settings from before it was opened."""
        if self.progress is None:
            return
        self.save()
        self._saving.wait()  # the file must be complete, because the list of lessons reads it next
        for timer in (self._reads, self._evaluations, self._save_soon):
            timer.stop()
        self._job.cancel()
        self._recent.follow(None)
        self.progress, self._waiting = None, False
        self._live.history.evaluated = None
        studio = self._studio
        studio.permissions.set_lesson()
        self._put(self._before)
        device, self._device_before = self._device_before, None
        if device is not None:
            studio.device.open(device)
        self.opened.emit()

    def end(self) -> None:
        """Close the lesson and wait until its file is written; the window calls this before it closes."""
        self.leave()
        self._job.end()
        self._saving.end()

    # steps

    def go(self, step: int) -> None:
        """Open a step, counted from 0, if it exists, and apply its scene."""
        if self.progress is None or not 0 <= step < len(self.progress.lesson.steps):
            return
        self._job.cancel()
        self.progress.step = step
        self._recent.clear()
        self._live.history.evaluated = None
        self.set_up()
        self.step_changed.emit()
        self._save_soon.start()

    def set_up(self) -> None:
        """Apply the open step's device, settings and locks as soon as its law is compiled."""
        if self.step is None:
            return
        studio, scene = self._studio, self.step.scene
        studio.permissions.set_lesson()
        self._choose_device(scene)
        key = scene.environment.key
        self._waiting = studio.readiness.state(key) in ("preparing", "next")
        if self._waiting:
            studio.readiness.request(key)
            return
        self._put(scene_settings(scene))
        studio.permissions.set_lesson(locked_places(scene), scene.hide)
        self.applied.emit()

    def _choose_device(self, scene: Scene) -> None:
        """Use the simulated Hapkit in a step that requires it, otherwise the device that was used before."""
        studio, before = self._studio, self._device_before
        if scene.device == _SIMULATED and studio.entry is not None and studio.entry.key != _SIMULATED:
            self._device_before = studio.entry
            studio.device.open_simulated()
        elif scene.device != _SIMULATED and before is not None:
            self._device_before = None
            studio.device.open(before)

    def _put(self, settings: Snapshot) -> None:
        """Apply settings that the user has not chosen; a motor waits for *Render* before it renders them."""
        studio = self._studio
        changes = differing(studio, settings)
        if studio.opened is None or studio.opened.own_clock:
            changes.pop(_RATE, None)
        if not changes:
            return
        studio.stop_state.wait_for_render()
        with studio.temporarily():
            try:
                put(studio, changes)
            except ParameterError as error:  # the environment's file may have been deleted
                self.failed.emit("The settings cannot be changed.", str(error))

    def _go_on(self) -> None:
        if self._waiting:
            self.set_up()

    def _follow(self) -> None:
        if self.progress is not None:
            self._recent.follow(self._studio.engine)

    # answers and checks

    def answer(self, question: Question, given: str) -> None:
        """Store the answer to a question."""
        if self.progress is not None and self.progress.answers.get(question.key, "") != given:
            self.progress.answers[question.key] = given
            self.evaluated.emit()
            self._save_soon.start()

    def evaluate(self) -> None:
        """Evaluate the open step's checks in a thread, unless the previous evaluation is still running."""
        if self.progress is None or self.step is None or self._waiting or self._job.running:
            return
        checks, found = [(self.progress.step + 1, check) for check in self.step.checks], self._recent.rows()
        if checks and found.tables:
            known = dict(self._studio.environments)
            self._job.start(lambda _progress: evaluate_rows(checks, found, known))

    def _take(self, found: dict[str, Evaluated]) -> None:
        progress = self.progress
        if progress is None:
            return
        changed = [key for key, one in found.items() if progress.note(key, one)]
        self._show_interval()
        if changed:
            self.evaluated.emit()
            self._save_soon.start()

    def _show_interval(self) -> None:
        """Mark in the plots the interval that was evaluated last in this step."""
        assert self.progress is not None
        assert self.step is not None
        keys = [check.key for check in self.step.checks]
        found = [self.progress.evaluated[key] for key in keys if key in self.progress.evaluated]
        spans = [(one.stop, one.start) for one in found if math.isfinite(one.stop)]
        stop, start = max(spans, default=(0.0, 0.0))
        self._live.history.evaluated = (start, stop) if spans else None

    # files

    def save(self) -> None:
        """Save the progress in a thread if a lesson is open."""
        if self.progress is None or not self.progress.begun:
            return
        self._recent.read()
        path, rows = file_of(self.progress.lesson), self._recent.rows()
        if not rows.tables and not any(one.part for one in self.progress.evaluated.values()):
            return
        copy = self._copy()
        self._saving.wait()
        self._saving.start(lambda _progress: copy.save(path, self.student, rows))

    def write(self, path: Path, student: str) -> None:
        """Write the file that the student hands in; raise SessionError if writing fails."""
        assert self.progress is not None
        self._recent.read()
        recordings = [Path(str(one)) for one in self._recordings().get(self.progress.lesson.key, [])]
        self._copy().save(path, student, self._recent.rows(), recordings)

    def _recordings(self) -> dict[str, Any]:
        """Return the paths of the sessions that were recorded during each lesson, by the lesson's key."""
        return {key: one for key, one in self._settings.table(_RECORDINGS).items() if isinstance(one, list)}

    def _note_recording(self) -> None:
        """Store the path of a session recorded in the lesson; it can contain the trials of an experiment."""
        newest = self._studio.recording.newest
        if newest == self._newest:
            return
        self._newest = newest
        if newest is not None and self.progress is not None:
            known = self._recordings()
            key = self.progress.lesson.key
            known[key] = [*known.get(key, []), str(newest[0])][-_MOST_RECORDINGS:]
            self._settings.setValue(_RECORDINGS, json.dumps(known))

    def _copy(self) -> Progress:
        assert self.progress is not None
        progress = self.progress
        return replace(progress, answers=dict(progress.answers), evaluated=dict(progress.evaluated))
