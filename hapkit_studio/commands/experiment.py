"""Results of experiments with people: the pointing trials or the comparisons in a session."""

import argparse
from typing import Any

from hapkit_studio.analysis import pointing
from hapkit_studio.analysis.discrimination import Observer
from hapkit_studio.analysis.pointing import Subject
from hapkit_studio.charts.experiments import (
    pointing_columns,
    pointing_figure,
    threshold_figure,
    threshold_text,
)
from hapkit_studio.columns import text_lines
from hapkit_studio.commands.base import PLOT, Command, Result, drawn, option, with_files
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import number, plain
from hapkit_studio.lessons import experiments

EDITED = 2
"""Exit code if the samples of a trial contradict its result."""


def run(options: argparse.Namespace) -> Result:
    """Print the results of a session, or those of a virtual person, whose session is written first."""
    written = []
    if options.virtual:
        if options.action == "pointing":
            experiments.save_pointing(
                options.session, Subject(), pointing.plan(seed=options.seed), options.seed
            )
        else:
            experiments.save_comparisons(options.session, Observer(), options.seed)
        written = [options.session]
    found = experiments.read(options.session)
    return (_pointing if options.action == "pointing" else _threshold)(options, found, written)


def _pointing(options: argparse.Namespace, found: experiments.Experiments, written: list[str]) -> Result:
    if not found.trials:
        raise ParameterError(f"{options.session} has no pointing trials.")
    results = found.lines
    lines = [*text_lines(pointing_columns(), results), *found.remarks]
    if options.virtual:
        a, b = 1e3 * Subject().intercept, 1e3 * Subject().slope
        lines.append(f"True values: a = {number(a, 0)} ms, b = {number(b, 0)} ms/bit.")
    as_json: dict[str, Any] = {
        "conditions": [_numbers(line) for line in results],
        "trials": [pointing.event(one) for one in found.trials],
        "remarks": list(found.remarks),
    }
    files = written + drawn(options.plot, pointing_figure, results)
    return with_files("\n".join(lines), as_json, files, EDITED if found.remarks else 0)


def _numbers(line: pointing.Line) -> dict[str, Any]:
    cells = [{**vars(cell), "difficulty": cell.difficulty} for cell in line.cells]
    estimates = {
        name: getattr(line, name)._asdict() for name in ("intercept", "slope", "throughput", "change")
    }
    return plain({**vars(line), "cells": cells, **estimates, "missed": line.missed, "count": line.count})


def _threshold(options: argparse.Namespace, found: experiments.Experiments, written: list[str]) -> Result:
    results = found.thresholds
    if not results:
        raise ParameterError(f"{options.session} has no comparisons.")
    lines = [threshold_text(one) for one in results]
    if options.virtual:
        lines.append(f"True Weber fraction: {number(100.0 * Observer().threshold, 1)} %.")
    as_json = {
        "thresholds": [
            {**plain(one), "threshold": one.threshold._asdict(), "weber": one.weber._asdict()}
            for one in results
        ]
    }
    return with_files("\n".join(lines), as_json, written + drawn(options.plot, threshold_figure, results[-1]))


COMMAND = Command(
    "experiment",
    "the results of an experiment with a person: pointing with friction, just-noticeable difference",
    run,
    (
        option("action", choices=("pointing", "threshold")),
        option("session", help="a session with the trials; with --virtual a new file"),
        option("--virtual", action="store_true", help="a virtual person does the experiment first"),
        option("--seed", type=int, default=0, metavar="N", help="of the virtual person"),
        PLOT,
    ),
    65,
)
