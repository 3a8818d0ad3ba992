"""Invented failures for tests of the page: one has a known growth, one is slow, and one raises an error."""

import math
import threading
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.failures.base import Curve, Evidence, Failure, Live, Plot
from hapkit_studio.analysis.failures.plane import Field, Panel, Plane
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Choice, Parameter

SECONDS, OMEGA = 4.0, 9.0
KNOB = Parameter("stiffness", "Stiffness", "N/m", 100.0, 1.0, 1000.0, "Of the spring", "K")
DAMPING = Parameter("damping", "Damping", "N·s/m", 2.0, 0.5, 8.0, "Of the handle", "b")


def limit(case):
    """Return a stiffness limit that is proportional to the damping."""
    return 100.0 * case["damping"]


def probe(stiffness, case):
    """Return an oscillation whose growth is proportional to the stiffness above the limit."""
    rate = stiffness / limit(case) - 1.0
    time = np.linspace(0.0, SECONDS, 400)
    text = f"{'decays' if rate < 0.0 else 'grows'} by {abs(rate):.3g} 1/s; in truth it decays by 1 1/s"
    trace = np.exp(rate * time) * np.cos(OMEGA * time)
    return Evidence(trace, time[1], "position", "mm", rate < 0.0, rate, "1/s", text)


PLOT = Plot(
    "stiffness, N/m",
    np.linspace(0.5, 1.5, 5),
    (
        Curve("formula", lambda x, case: x / limit(case) - 1.0, "theory"),
        Curve("measured", lambda x, case: x / limit(case) - 1.0),
    ),
    "limit",
    level_label="neither",
)


def live(stiffness, case):
    """Return the window's settings for a spring of this stiffness."""
    values = {"stiffness": stiffness, "damping": case["damping"]}
    loop = {"rate": 500.0, "delay": 0.001, "estimator": "difference"}
    return Live("spring", values, loop, "medium", "Pull the handle.")


def made(**given):
    """Return the invented failure with some parts replaced."""
    texts = {"summary": "Above a stiffness it grows", "formula": "K < 100 b_h", "explanation": "So it is."}
    parts = {"key": "grows", "title": "A spring too stiff", "knob": KNOB, "limit": limit, "probe": probe}
    parts |= {"plot": PLOT, "options": (DAMPING, Choice("hand", "Hand", ("none", "firm"))), "live": live}
    return Failure(**{**texts, **parts, **given})


def plane(case):
    """Return a stability map whose limit is 100 N/m for each N·s/m of damping."""
    grid = np.geomspace(10.0, 1000.0, 20)
    z = np.where(grid < 100.0, 0.5, 3.0) * np.ones((20, 1))
    return Plane(
        "Only the ratio counts", "stiffness over damping", "anything", (Panel(Field(grid, grid, z)),),
        lambda value: (value / case["damping"], 50.0),
    )  # fmt: skip


class Gate:
    """A chart function that waits until it is released, then reports progress."""

    def __init__(self):
        self.begun, self.go_on = threading.Event(), threading.Event()
        self.plot = replace(PLOT, at=self._wait)

    def _wait(self, case):
        self.begun.set()
        self.go_on.wait()
        return limit(case) * PLOT.at


def refuse(case):
    """Raise the error of an analysis that rejects a case."""
    raise ParameterError("Damping of 2 N·s/m has no limit here: choose 1 N·s/m or less.")


def library(gate):
    """Return failures by key: ordinary, slow, raising an error, with a map, and impossible to feel."""
    step = Parameter("step", "Step", "s", 1e-3, 1e-5, 0.2, "Of the loop", "dt")
    return {
        "grows": made(),
        "slow": made(key="slow", title="A spring measured slowly", plot=gate.plot),
        "refuses": made(key="refuses", title="A limit that nobody knows", limit=refuse),
        "mapped": made(key="mapped", title="A spring on a map", plane=plane),
        "step": made(
            key="step", title="A step too long", knob=step, live=None, margin=0.05, span=(0.2, 2.0),
            limit=lambda case: 2e-3,
            probe=lambda value, case: probe(value * 1e5, {"damping": 2.0}),
            plot=Plot(
                "time step, ms", np.linspace(0.2, 2.0, 5),
                (Curve("measured", lambda x, case: -1.0 if x < 2e-3 else math.inf),), "limit", factor=1e3,
            ),
        ),
    }  # fmt: skip


def measured(page, qtbot):
    """Wait until the chosen failure is measured."""
    qtbot.waitUntil(lambda: page.record.complete and not page.job.running)


def settled(page, qtbot):
    """Wait until the knob's current value has been measured."""
    qtbot.waitUntil(lambda: "here" not in page.record.old)
