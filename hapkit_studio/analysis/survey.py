"""Survey of stiffness limits: estimator × rate × delay × hand × damping, millions of points in one file.

A point is the exact stiffness limit in N/m of one loop with the usual handle. A row contains all dampings of
one loop. A sweep computes the rows, locally or on a cluster, and writes each chunk at once. After an
interruption, the same call resumes the survey.
"""

import json
import math
import sqlite3
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import closing, contextmanager
from dataclasses import astuple, dataclass, fields
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from hapkit_studio import discovery
from hapkit_studio.analysis.stability.hands import DAMPING, MASS, STIFFNESS
from hapkit_studio.analysis.stability.limits import checked_loop
from hapkit_studio.analysis.sweeps import LostWorkers, Progress, no_progress, sweep
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.hand import GRIPS, Grip
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.dynamics.sampled_loop import stiffness_limits
from hapkit_studio.errors import StudioError
from hapkit_studio.files import checked_list, checked_number, open_regular, parse_json

Hand = tuple[float, float, float]
"""Mass in kg, damping in N·s/m, stiffness in N/m; all 0 for a released handle."""
_MARK = 0x48504C53  # SQLite's application_id, which identifies survey files
_TABLES = {
    "about": "CREATE TABLE about (axes TEXT)",
    "limits": "CREATE TABLE limits (row INTEGER PRIMARY KEY, limits BLOB)",
}
_MOST_LOOPS = 1 << 26  # largest number of loops in a survey, 256 MB of results
_LONGEST = 1 << 20  # bytes: largest size of a value in the file
# valid ranges of axes in a file: rates in Hz, delays in s, dampings and hands
_RATE, _DELAY, _PART = (1.0, 1e5), (0.0, 1.0), (0.0, 1e6)
_NUMBER = np.dtype("<f4")
_RATES, _DELAYS, _DAMPINGS = (250.0, 10_000.0), (0.0, 5e-3), (0.0, 20.0)


class SurveyError(StudioError):
    """The file is not a survey, or it has other axes than requested."""


@dataclass(frozen=True)
class Axes:
    """The axes: names of estimators, rates in Hz, delays in s, hands, dampings of scenes in N·s/m."""

    estimators: tuple[str, ...]
    rates: tuple[float, ...]
    delays: tuple[float, ...]
    hands: tuple[Hand, ...]
    damping: tuple[float, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the lengths of the axes; all axes but the last one index the rows."""
        return tuple(map(len, astuple(self)))

    @property
    def text(self) -> str:
        """Return the lengths of the axes as text."""
        names = "estimators", "rates", "delays", "hands", "dampings"
        return " × ".join(f"{count} {name}" for count, name in zip(self.shape, names, strict=True))

    def limits(self, row: int) -> np.ndarray:
        """Return a row's limits (dampings,) in N/m; a limit is 0 if the damping alone is unstable."""
        e, r, d, h = (int(k) for k in np.unravel_index(row, self.shape[:-1]))
        usual, hand = LoopSettings(), self.hands[h]
        sampling = self.rates[r], self.delays[d], self.estimators[e]
        grip = Grip(*hand) if any(hand) else None
        loop = checked_loop(usual.mass, usual.viscous, 0.0, *sampling, grip, usual.quantum)
        return stiffness_limits(loop, np.array(self.damping))


def usual_axes(rates: int = 25, delays: int = 20) -> Axes:
    """Return axes with this many rates and delays, every linear estimator, 20 hands and 25 dampings."""
    grips = [(g.mass, g.damping, g.stiffness) if g else (0.0, 0.0, 0.0) for g in GRIPS.values()]
    people = product(np.geomspace(*MASS, 4).tolist(), DAMPING, STIFFNESS)
    return Axes(
        tuple(key for key, method in ESTIMATORS.items() if method.response is not None),
        tuple(np.geomspace(*_RATES, rates).tolist()),
        tuple(np.linspace(*_DELAYS, delays).tolist()),
        (*grips, *people),
        tuple(np.linspace(*_DAMPINGS, 25).tolist()),
    )


def compute_rows(axes: Axes, rows: Sequence[int]) -> list[bytes]:
    """Return each row's limits as float32; this is the task of the sweep."""
    return [axes.limits(row).astype(_NUMBER).tobytes() for row in rows]


def compute(
    path: Path, axes: Axes, executor: Executor | None = None, progress: Progress = no_progress
) -> int:
    """Compute the missing rows of a survey's file and return their number.

    The file is created if it is missing. Raise SurveyError if the file has different axes or is no survey.
    ``progress`` counts all rows, including those that were already computed.
    """
    _check_size(axes)
    with _opened(path, axes) as database:
        known = {row for row, _ in _rows(database, axes)}
        missing = np.setdiff1d(np.arange(np.prod(axes.shape[:-1])), list(known))
        # a random order, so that partial results are a fair sample
        missing = np.random.default_rng(0).permutation(missing).tolist()

        def store(rows: Sequence[int], found: list[bytes]) -> None:
            with database:
                database.executemany("INSERT INTO limits VALUES (?, ?)", zip(rows, found, strict=True))

        def report(done: int, _of: int) -> None:
            progress(len(known) + done, len(known) + len(missing))

        try:
            sweep(partial(compute_rows, axes), missing, executor=executor, progress=report, store=store)
        except LostWorkers as error:
            hint = f"The results so far are kept in {path.name}. Run the same command again."
            raise SurveyError(f"{error} {hint}") from error
    return len(missing)


def read(path: Path) -> tuple[Axes, np.ndarray]:
    """Return the axes, and the limits in N/m with the shape of the axes; limits not yet computed are NaN."""
    with _opened(path) as database:
        axes = _axes(database, path.name)
        table = np.full((math.prod(axes.shape[:-1]), axes.shape[-1]), np.nan, _NUMBER)
        for row, limits in _rows(database, axes):
            table[row] = limits
    return axes, table.reshape(axes.shape)


def known(limits: np.ndarray) -> int:
    """Return the number of computed limits."""
    return int(np.count_nonzero(~np.isnan(limits)))


def _rows(database: sqlite3.Connection, axes: Axes) -> Iterator[tuple[int, np.ndarray]]:
    """Yield each computed row and its limits (dampings,) in N/m; raise DataError for an invalid row."""
    rows, dampings = math.prod(axes.shape[:-1]), axes.shape[-1]
    for row, blob in database.execute("SELECT row, limits FROM limits"):
        fits = isinstance(blob, bytes) and len(blob) == dampings * _NUMBER.itemsize
        limits = np.frombuffer(blob if fits else b"", _NUMBER)
        if not (0 <= row < rows and fits and np.all(limits >= 0.0)):  # `not >=`, because `<` is false for NaN
            raise sqlite3.DataError(f"its row {row} is damaged; there are rows 0 to {rows - 1:,}")
        yield row, limits


def _axes(database: sqlite3.Connection, name: str) -> Axes:
    """Return the validated axes in a survey's file; raise FileError or DataError if they are invalid."""
    found, place = database.execute("SELECT axes FROM about").fetchall(), f"{name}: axes"
    if len(found) != 1 or not isinstance(found[0][0], str):
        raise sqlite3.DataError("its axes are damaged")
    names = [axis.name for axis in fields(Axes)]
    given = checked_list(parse_json(found[0][0], place), place, len(names))
    lists = (checked_list(values, f"{place}.{axis}") for axis, values in zip(names, given, strict=True))
    estimators, rates, delays, hands, damping = lists
    for estimator in estimators:
        discovery.named(ESTIMATORS, estimator, f"estimator (of {place})")

    def numbers(axis: str, values: list, limits: tuple[float, float]) -> tuple[float, ...]:
        return tuple(checked_number(value, f"{place}.{axis}", *limits) for value in values)

    axes = Axes(
        tuple(estimators),
        numbers("rates", rates, _RATE),
        numbers("delays", delays, _DELAY),
        tuple(numbers("hands", checked_list(hand, f"{place}.hands", 3), _PART) for hand in hands),  # type: ignore[misc]
        numbers("damping", damping, _PART),
    )
    _check_size(axes)
    return axes


def _check_size(axes: Axes) -> None:
    loops = math.prod(axes.shape)
    if loops > _MOST_LOOPS:
        raise SurveyError(f"A survey can compute at most {_MOST_LOOPS:,} control loops, not {loops:,}.")


@contextmanager
def _opened(path: Path, axes: Axes | None = None) -> Iterator[sqlite3.Connection]:
    """Open a survey's file; with axes, create it if it is missing. Convert all errors to SurveyError."""
    if axes is None and not path.exists():
        raise SurveyError(f"There is no survey file {path}.")
    if path.exists():
        open_regular(path).close()
    mode = "ro" if axes is None else "rwc"
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode={mode}", uri=True)) as database:
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LONGEST)
            if axes is not None and not database.execute("SELECT name FROM sqlite_master").fetchall():
                _begin(database, axes)
            mark = database.execute("PRAGMA application_id").fetchone()
            if mark != (_MARK,) or dict(database.execute("SELECT name, sql FROM sqlite_master")) != _TABLES:
                raise SurveyError(f"{path.name} is not a survey.")
            there = _axes(database, path.name)
            if axes not in (None, there):
                raise SurveyError(
                    f"{path.name} contains {there.text}: use these values, or choose another file."
                )
            yield database
    except sqlite3.Error as error:
        raise SurveyError(f"{path.name} cannot be used: {error}.") from None


def _begin(database: sqlite3.Connection, axes: Axes) -> None:
    database.execute("PRAGMA journal_mode=WAL")
    database.executescript(f"BEGIN; {'; '.join(_TABLES.values())}; PRAGMA application_id={_MARK}; COMMIT;")
    with database:
        database.execute("INSERT INTO about VALUES (?)", (json.dumps(astuple(axes)),))
