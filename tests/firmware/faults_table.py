"""Measure every fault and print the table: `python -m tests.firmware.faults_table > assets/docs/faults.md`.

The figures come from the board's truth log and the studio's rows.
"""

import argparse
import dataclasses
import json
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hapkit_studio.haptics import arrays, rows
from tests.firmware.faults import BOARD_RENDERS, CASES, END, START, STIFFNESS, Case, Run, run_case
from tests.firmware.vb import FULL_FORCE, QUANTUM

DUTY = 255
NOT_RENDERED = rows.STALE | rows.STOPPED | rows.FAULT | rows.FADING
MARKED = rows.STALE | rows.STOPPED | rows.FAULT
COUNTS = 1.1
"""Permitted difference in counts between recording and truth: a sensor step, and the log's 0.1 ms."""
STEP = 0.05
"""Force in N of two steps of the duty at 1 N."""
LATELY = 20
"""Number of log rows in which a position may have been sampled, sent and answered."""
BRIDGED = 0.01
LONGEST_WAY = 0.40
"""Longest delay of a command in s, by the longest stall and the queue behind it."""


@dataclass
class Measured:
    """The figures of one run, which are NaN if they do not apply."""

    name: str
    peak: float  # largest force in N at the motor's pins
    off: float  # time in s from START until the motor was off
    on_while_off: float  # time in s before END in which the motor was on again, although it must be off
    back: float  # time in s from END until the full force was back
    rows: int
    wrong_rows: int  # number of rows that have a wrong position and no gap mark
    unmarked_gaps: int
    foreign: int  # number of log rows with a force that was never sent (falsely accepted)
    lost: int
    bad: int
    counted: int  # number of damaged messages that the board counted and reported, modulo 256
    stale: int
    fault: int
    overruns: int  # number of bytes that the chip's port lost
    late_ticks: int  # number of samples that the board did not take at its period
    silent_offs: int
    hurt_to: int  # number of bytes damaged on purpose, to the board and from it
    hurt_from: int

    @property
    def wrong(self) -> int:
        """Return the number of errors: wrong rows, unmarked gaps, and forces that were never sent."""
        return self.wrong_rows + self.unmarked_gaps + self.foreign


def measure(case: Case) -> Measured:
    """Run one case and measure it."""
    with tempfile.TemporaryDirectory() as folder:
        run = run_case(case, Path(folder))
    truth = run.truth
    off = time_off(run)
    return Measured(
        name=case.name,
        peak=float(np.abs(truth.motor_force).max()),
        off=off,
        on_while_off=on_again(run, off),
        back=time_back(run),
        rows=sum(map(len, run.rows)),
        wrong_rows=sum(wrong_rows(run, k) for k in range(len(run.rows))),
        unmarked_gaps=sum(unmarked_gaps(found) for found in run.rows),
        foreign=(foreign_to_the_law if case.board else foreign_to_the_loop)(run),
        overruns=run.summary["overruns"],
        late_ticks=sum(late_ticks(found) for found in run.rows),
        **{key: run.summary[key] for key in ("silent_offs", "hurt_to", "hurt_from")},
        **{key: run.counters[key] for key in ("lost", "bad", "counted", "stale", "fault")},
    )


def time_off(run: Run) -> float:
    """Return the time from START until the motor was off, or NaN if the case does not require it."""
    if run.case.off is None:
        return np.nan
    after = run.truth[run.truth.time >= START]
    return float(after.time[np.flatnonzero(after.duty == 0)[0]] - START)


def on_again(run: Run, off: float) -> float:
    """Return the time in s for which the motor was on although it had to be off."""
    if run.case.off is None:
        return 0.0
    span = run.truth[(run.truth.time > START + off) & (run.truth.time < END)]
    return float(np.count_nonzero(span.duty) * np.median(np.diff(run.truth.time)))


def time_back(run: Run) -> float:
    """Return the time from END until the full force was back, or NaN if the case does not require it."""
    if run.case.back is None:
        return np.nan
    found = run.rows[-1]
    full = (found[:, rows.FLAGS].astype(int) & NOT_RENDERED) == 0
    after = found[full & (found[:, rows.HOST_TIME] > END), rows.HOST_TIME]
    on = run.truth[(run.truth.duty != 0) & (run.truth.time >= after[0])].time if len(after) else []
    return float(on[0] - END) if len(on) else np.inf


def errors(run: Run, found: np.ndarray, start: float) -> np.ndarray:
    """Return the difference (n,) in counts between rows and truth; the board's clock starts at ``start``."""
    time = found[:, rows.BOARD_TIME] + start
    error = found[:, rows.POSITION] - np.interp(time, run.truth.time, run.truth.position)
    first = np.argmin(found[:, rows.FLAGS].astype(int) & MARKED)
    return (error - error[first]) / QUANTUM


def start_of_clock(run: Run) -> float:
    """Return the start of the board's clock in s, to 25 µs, by the best fit of rows before START."""
    found = run.rows[0]
    found = found[found[:, rows.BOARD_TIME] < START]
    tried = np.arange(0.0, 1e-3, 25e-6)
    spread = np.array([np.ptp(errors(run, found, start)) for start in tried])
    return float(np.mean(tried[spread < spread.min() + 0.01]))


def start_of_connection(run: Run, number: int) -> float:
    """Return the start of the board's clock for a connection: the program's start, or the reset."""
    reset = number == 1 and any("reset" in line for line in run.case.script)
    return start_of_clock(run) + (START if reset else 0.0)


def wrong_rows(run: Run, number: int) -> int:
    """Return the number of a connection's rows whose position is wrong and that are not marked as gaps."""
    found = run.rows[number]
    if not len(found):
        return 0
    start = start_of_connection(run, number)
    time, error = found[:, rows.BOARD_TIME] + start, errors(run, found, start)
    marked = (found[:, rows.FLAGS].astype(int) & MARKED) != 0
    if run.case.wrong:
        # the board bridges wrong readings, and marks these rows as gaps
        marked |= (found[:, rows.FLAGS].astype(int) & rows.GAP) != 0
        marked |= (time >= START) & (time <= END + 1e-3)
    return int(np.count_nonzero((np.abs(error) > COUNTS) & ~marked))


def unmarked_gaps(found: np.ndarray) -> int:
    """Return the number of jumps of the board's time by more than a period in rows without a gap mark."""
    steps = np.diff(found[:, rows.BOARD_TIME])
    gap = (found[1:, rows.FLAGS].astype(int) & rows.GAP) != 0
    return int(np.count_nonzero((np.abs(steps - 1e-3) > 0.5e-3) & ~gap))


def late_ticks(found: np.ndarray) -> int:
    """Return the number of samples that miss the board's period by at least a quarter of a millisecond."""
    steps = np.diff(found[:, rows.BOARD_TIME]) / 0.25e-3
    return int(np.count_nonzero(np.abs(steps - np.round(steps)) > 0.05))


def foreign_to_the_law(run: Run) -> int:
    """Return the number of log rows whose force is not between 0 and the spring's force at recent positions.

    Forces that the computer sent before the takeover are those of the same spring. Every connection has its
    own zero, and the sensor may be wrong during a fault.
    """
    truth, case = run.truth, run.case
    held = np.isnan(truth.time)
    if case.wrong:
        held |= (truth.time >= START) & (truth.time <= END + BRIDGED)
    spring = np.array([-STIFFNESS * (truth.position - zero) for zero in zeros(run)])
    most = _lately(np.maximum(spring.max(axis=0), 0.0), np.max)
    least = _lately(np.minimum(spring.min(axis=0), 0.0), np.min)
    beyond = (truth.motor_force > most + STEP) | (truth.motor_force < least - STEP)
    return int(np.count_nonzero(beyond & ~held))


def zeros(run: Run) -> list[float]:
    """Return the zero of each connection in m."""
    found = []
    for number, some in enumerate(run.rows):
        first = some[np.argmin(some[:, rows.FLAGS].astype(int) & MARKED)]
        time = first[rows.BOARD_TIME] + start_of_connection(run, number)
        found.append(float(np.interp(time, run.truth.time, run.truth.position)))
    return found


def _lately(values: np.ndarray, what) -> np.ndarray:
    """Return the largest or smallest of the last LATELY values at each row."""
    padded = np.concatenate((np.full(LATELY, values[0]), values))
    return what(np.lib.stride_tricks.sliding_window_view(padded, LATELY + 1), axis=1)


def foreign_to_the_loop(run: Run) -> int:
    """Return the number of log rows whose duty differs by more than a step from every recent force.

    A log row may fall between the writes of duty and direction, 1 µs apart: then the next row decides.
    """
    times = np.array([t for t, _ in run.forces])
    sent = duty_of(np.array([f for _, f in run.forces]))
    others = [0.0, *duty_of(np.array(run.case.extra))]

    def unknown(row) -> bool:
        first, last = np.searchsorted(times, [row.time - LONGEST_WAY, row.time])
        known = np.concatenate((sent[first:last], others))
        return not np.any(np.abs(known - row.duty) <= 1.0)

    some = range(0, len(run.truth) - 1, 5)
    return sum(unknown(run.truth[k]) and unknown(run.truth[k + 1]) for k in some)


def duty_of(force: np.ndarray) -> np.ndarray:
    """Return the signed duty of a force in N; the force is full force * duty^2."""
    return np.sign(force) * DUTY * np.sqrt(np.minimum(np.abs(force) / FULL_FORCE, 1.0))


# --- print the table
HEAD = """\
# What faults do

Made by `python -m tests.firmware.faults_table > assets/docs/faults.md`; `make test-all` holds each line to
its bounds.

The virtual board executes the real firmware. The studio's own compiled loop renders a spring of 120 N/m, and
a simulated hand moves the handle to and fro. Each fault lasts from 0.5 s to 0.8 s. All times are those of the
board's clock, so every run is the same. The forces at the motor's pins come from the truth log of the virtual
board, every 0.1 ms. The force limit is 3.00 N.

* *Force*: the largest force at the pins.
* *Off after*: the time from the fault until the motor is off, if the motor has to be off; its bound is in
  brackets.
* *Back after*: the time from the end of the fault until the full force is back, with a fade of 30 ms; its
  bound is in brackets.
* *Lost*: the number of samples that the computer missed. *Damaged*: the number of frames that the computer
  refused. *Board refused*: the number of frames and bytes that the board refused and counted.
* *Wrong*: the number of errors. An error is a recorded position that differs from the truth by more than a
  count in a row that is not marked, a gap that is not marked, or a force at the pins that nobody sent.
* *Latched*: the fault that remains until the user clears it.
"""

COLUMNS = (
    "rendered by", "fault", "force", "off after", "back after",
    "lost", "damaged", "board refused", "wrong", "latched",
)  # fmt: skip
FAULTS = {
    arrays.OVER_SPEED: "over-speed",
    arrays.STALE_SENSOR: "stale, three times",
    arrays.DEVICE_GONE: "device gone",
}


def line_of(m: Measured, case: Case) -> str:
    """Return one line of the table."""

    def within(value: float, bound: float | None) -> str:
        return "" if bound is None else f"{1e3 * value:.1f} ms (≤ {1e3 * bound:.0f})"

    cells = [
        "board" if case.board else "computer",
        case.name.removesuffix(BOARD_RENDERS),
        f"{m.peak:.2f} N",
        within(m.off, case.off),
        within(m.back, case.back),
        str(m.lost),
        str(m.bad),
        str(m.counted),
        str(m.wrong),
        FAULTS.get(m.fault, ""),
    ]
    return "| " + " | ".join(cells) + " |"


def main(args: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--serve", action="store_true", help="an object for each name of a case that is read")
    parser.add_argument("names", nargs="*", help="parts of the names of cases")
    given = parser.parse_args(args)
    if given.serve:
        cases = {case.name: case for case in CASES}
        for line in sys.stdin:
            print(json.dumps(dataclasses.asdict(measure(cases[line.strip()]))), flush=True)
        return
    print(HEAD)
    print("| " + " | ".join(COLUMNS) + " |")
    print("|" + "---|" * len(COLUMNS))
    for case in CASES:
        if not given.names or any(name in case.name for name in given.names):
            print(line_of(measure(case), case))


if __name__ == "__main__":
    sys.exit(main())
