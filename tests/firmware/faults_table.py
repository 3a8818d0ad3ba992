"""Run every fault and print the table: `python -m tests.firmware.faults_table > assets/docs/faults.md`."""

import argparse
import dataclasses
import json
import math
import sys
import tempfile
from pathlib import Path

from hapkit_studio.haptics import arrays
from tests.firmware.faults_cases import BOARD_RENDERS, CASES, TESTED, Case
from tests.firmware.faults_measure import Measured, measure
from tests.firmware.faults_run import run_case

HEAD = """\
# What faults do

Made by `python -m tests.firmware.faults_table > assets/docs/faults.md`; `make test` holds each line to its
bounds.

The real firmware runs in the virtual board, the studio's own compiled loop renders a spring of 120 N/m, and
a hand leads the handle to and fro. Each fault lasts from 0.5 s to 0.8 s. All times are the board's, so every
run is the same. What happened at the pins is from the board's truth log, every 0.1 ms; the force limit is
3.00 N.

* *Force*: the largest at the pins.
* *Off after*: from the fault to the motor's being off, where it has to be off; the bound is beside it.
* *Back after*: from the end of the fault to the full force, a fade of 30 ms included.
* *Lost*, *damaged*: samples that the computer missed; frames that it refused. *Board refused*: what the board
  counted, frames and bytes.
* *Wrong*: recorded positions that differ from the truth by more than a count in a row that nothing marks,
  gaps that are not marked, and forces at the pins that nobody had sent.
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


def run_all(names: list[str], cases: list[Case]) -> list[Measured]:
    """Run the cases, those whose name holds one of the words; all without any."""
    found = []
    for case in cases:
        if names and not any(name in case.name for name in names):
            continue
        with tempfile.TemporaryDirectory() as folder:
            found.append(measure(run_case(case, Path(folder))))
    return found


def _time(value: float, bound: float | None) -> str:
    if bound is None or math.isnan(value):
        return ""
    return f"{1e3 * value:.1f} ms (≤ {1e3 * bound:.0f})"


def line_of(m: Measured, case: Case) -> str:
    """Return one line of the table."""
    cells = [
        "board" if case.board else "computer",
        case.name.removesuffix(BOARD_RENDERS),
        f"{m.peak:.2f} N",
        _time(m.off, case.off),
        _time(m.back, case.back),
        str(m.lost),
        str(m.bad),
        str(m.told),
        str(m.wrong),
        FAULTS.get(m.fault, ""),
    ]
    return "| " + " | ".join(cells) + " |"


def main(words: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="one object for each case of the tests")
    parser.add_argument("names", nargs="*", help="parts of the names of cases")
    given = parser.parse_args(words)
    found = run_all(given.names, TESTED if given.json else CASES)
    if given.json:
        print(json.dumps([dataclasses.asdict(m) for m in found]))
        return
    cases = {case.name: case for case in CASES}
    print(HEAD)
    print("| " + " | ".join(COLUMNS) + " |")
    print("|" + "---|" * len(COLUMNS))
    print("\n".join(line_of(m, cases[m.name]) for m in found))


if __name__ == "__main__":
    sys.exit(main())
