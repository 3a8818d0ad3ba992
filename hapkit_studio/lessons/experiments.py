"""Reads experiments with people, which are pointing trials and comparisons, from a session's events.

Every pointing trial is measured again from the session's samples.
"""

from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis import discrimination, pointing
from hapkit_studio.analysis.discrimination import COMPARISON, Comparison, Observer, Threshold
from hapkit_studio.analysis.pointing import POINTING, Line, Subject, Trial
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.errors import FileError, ParameterError
from hapkit_studio.haptics import rows
from hapkit_studio.sessions import settings_events
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.file import ABOUT, SETTINGS, Event, SessionError, SessionWriter
from hapkit_studio.sessions.session import Session

_SAME_SECONDS, _SAME_PLACE = 2e-3, 50e-6  # tolerances in s and m: a file rounds times to 1 µs
_CLOCK = 2e-6  # s: tolerance around a trial's samples
_PAUSE = 0.5  # s: pause between two trials of a virtual subject
_RATE = 1000.0  # Hz: sampling rate of a virtual session
_BASE = 200.0  # N/m: stiffness with which a virtual observer compares other stiffnesses


@dataclass(frozen=True)
class Experiments:
    """The pointing trials and comparisons of a session.

    ``remarks`` names trials that contradict their samples.
    """

    trials: tuple[Trial, ...] = ()
    comparisons: tuple[Comparison, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def lines(self) -> list[Line]:
        """Return the pointing results; there is one for each condition."""
        return pointing.evaluate(self.trials)

    @property
    def thresholds(self) -> list[Threshold]:
        """Return the thresholds; there is one for each parameter and base value."""
        return discrimination.evaluate(self.comparisons)


def of_session(session: Session) -> Experiments:
    """Return a session's experiments; raise SessionError if an event has a wrong value."""
    try:
        trials = pointing.trials(_stored(session, POINTING), session.name)
        answers = discrimination.comparisons(_stored(session, COMPARISON), session.name)
    except FileError as error:
        raise SessionError(str(error)) from None
    remarks = (_remark(session, at, one) for at, one in enumerate(trials, 1))
    return Experiments(tuple(trials), tuple(answers), tuple(filter(None, remarks)))


def read(path: str | Path) -> Experiments:
    """Return the experiments in a session's file; raise SessionError if it has none or cannot be read."""
    with closing(Session(path)) as session:
        found = of_session(session)
        if not found.trials and not found.comparisons:
            raise SessionError(f"{session.name} holds no pointing trials and no comparisons.")
        return found


def own_threshold(path: str | Path) -> Threshold:
    """Return a session's threshold with the smallest Weber fraction; raise SessionError if it has none."""
    found = read(path).thresholds
    if not found:
        raise SessionError(
            f"{Path(path).name} contains no comparisons, so it gives no just-noticeable difference."
        )
    return min(found, key=lambda one: one.weber.value)


def _stored(session: Session, kind: str) -> list[dict]:
    return [event.what for event in session.events if event.kind == kind]


def _remark(session: Session, at: int, one: Trial) -> str:
    """Return a line that says how a trial differs from its samples; "" if it does not differ.

    Start and target of a planned trial are symmetric about zero.
    """
    found = session.read(("time", "position"), one.begin - _CLOCK, one.stop + _CLOCK)
    again = pointing.movement(found["time"], found["position"])
    if again is None:
        return f"Pointing trial {at}: the session has no movement from {one.begin:.2f} to {one.stop:.2f} s."
    if abs(again.seconds - one.seconds) > _SAME_SECONDS or abs(again.end - one.end) > _SAME_PLACE:
        given, computed = (f"{s:.3f} s and {1e3 * x:.2f} mm" for s, x in ((one.seconds, one.end), again[:2]))
        return f"For pointing trial {at}, the file says {given}, but its samples give {computed}."
    start = float(found["position"][found["time"] <= max(again.begin, float(found["time"][0]))].mean())
    places = (("start", one.start, start), ("distance", one.distance, 2.0 * abs(one.target)))
    for name, stored, measured in places:
        if abs(stored - measured) > _SAME_PLACE:
            values = f"{1e3 * stored:.2f} mm, but it is {1e3 * measured:.2f} mm"
            return f"For pointing trial {at}, the file says that the {name} is {values}."
    return ""


# --- virtual people


def save_pointing(
    path: str | Path, subject: Subject, targets: Iterable[pointing.Target], seed: int
) -> list[Trial]:
    """Write a session in which a virtual subject points at targets, and return its trials.

    Raise SessionError if the file cannot be written.
    """
    chance, device, found = np.random.default_rng(seed), SimulatedHapkit(), list[Trial]()
    begin = 0.0
    with SessionWriter.whole(path) as writer:
        writer.note(Event(0.0, ABOUT, {"device": "Simulated person", "quantum_m": device.quantum}))
        for target in targets:
            time, place = subject.samples(target, chance, begin, _RATE)
            place = device.quantum * np.floor(place / device.quantum)
            writer.note(Event(begin, SETTINGS, _settings(pointing.ENVIRONMENT, target.condition.values)))
            writer.add(pack(_rows(time, place), device.quantum, 0))
            one = pointing.trial(target, time, place)
            if one is not None:
                writer.note(Event(one.stop, POINTING, pointing.event(one)))
                found.append(one)
            begin = float(time[-1]) + _PAUSE
    return found


def save_comparisons(path: str | Path, observer: Observer, seed: int) -> list[Comparison]:
    """Write a session with a virtual observer's answers, and return the answers.

    Raise SessionError if the file cannot be written.
    """
    found = observer.run(_BASE, np.random.default_rng(seed))
    time = np.arange(len(found) * int(_RATE) // 10) / _RATE
    with SessionWriter.whole(path) as writer:
        writer.note(Event(0.0, ABOUT, {"device": "Simulated person", "quantum_m": SimulatedHapkit().quantum}))
        writer.note(Event(0.0, SETTINGS, _settings("spring", {"stiffness": _BASE})))
        writer.add(pack(_rows(time, np.zeros(len(time))), SimulatedHapkit().quantum, 0))
        for at, one in enumerate(found, 1):
            writer.note(Event(0.1 * at, COMPARISON, discrimination.event(one)))
    return found


def _settings(key: str, values: dict) -> dict:
    environment = environments.named(key)
    try:
        scene = settings_events.of_scene(environment, environment.values(values))
    except ParameterError as error:
        raise SessionError(str(error)) from None
    return {**scene, "state_names": [], "rate_Hz": _RATE}


def _rows(time: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return telemetry rows (n, ROW_WIDTH) of an imposed motion without force."""
    table = np.zeros((len(time), rows.ROW_WIDTH))
    table[:, rows.TICK] = np.arange(len(time))
    table[:, rows.HOST_TIME] = table[:, rows.BOARD_TIME] = time
    table[:, rows.POSITION] = position
    table[:, rows.VELOCITY] = np.gradient(position, time)
    table[:, rows.PERIOD] = 1.0 / _RATE
    return table
