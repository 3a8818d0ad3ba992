"""In the figure of a run, the law's curve and the force limit are drawn as in the window."""

import math
import os
from datetime import datetime

import numpy as np
import pytest
from matplotlib.figure import Figure

import hapkit_studio as hs
from hapkit_studio.charts import run as charts
from hapkit_studio.charts.style import colors
from hapkit_studio.cli import main
from tests.environments.calling import LIBRARY
from tests.workshop.student import END, text, write


def drawn(run, **given):
    """Return the axes of force over time, and of force over position or velocity."""
    figure = Figure(figsize=(11.0, 6.2), layout="constrained")
    charts.draw(figure, colors(), run, **given)
    return figure.axes[2], figure.axes[3]


def curve(axes):
    """Return the law's curve as drawn (2, n), or an empty array if it is not drawn."""
    found = [line for line in axes.lines if line.get_label() == "theory"]
    return np.array(found[0].get_data())[:, ::-1] if found else np.empty((2, 0))


def limits(axes):
    return sorted(float(text.xy[1]) for text in axes.texts if text.get_text().startswith("limit"))


def test_the_laws_curve_covers_the_visible_range():
    _, axes = drawn(hs.simulate("wall", {"stiffness": 400.0}, hand="press", seconds=1.5))
    x, force = curve(axes)
    assert force == pytest.approx(-0.4 * np.maximum(x - 5.0, 0.0), abs=2e-3)
    low, high = axes.get_xlim()
    assert x[0] < low < 0.0 < 9.0 < high < x[-1]
    assert axes.get_xlabel() == "position, mm"


def test_a_detents_peak_is_drawn_completely():
    _, axes = drawn(hs.simulate("detents", hand="sweep", seconds=1.0))
    assert curve(axes)[1].max() == pytest.approx(1.2, abs=1e-3)
    assert axes.get_ylim()[1] > 1.2


@pytest.mark.parametrize(
    ("key", "over", "has"),
    [("damping", "velocity", True), ("friction", "velocity", True), ("puck", "position", False)],
)
def test_the_curve_is_over_the_laws_variable(key, over, has):
    _, axes = drawn(hs.simulate(key, hand="stroke", seconds=0.7))
    assert axes.get_xlabel().startswith(over)
    assert bool(curve(axes).size) == has
    _, axes = drawn(hs.simulate(key, hand="stroke", seconds=0.7), over="position")
    assert axes.get_xlabel() == "position, mm"


@pytest.mark.parametrize(("max_force", "shown"), [(1.0, True), (3.0, False), (math.inf, False)])
def test_the_force_limit_is_drawn_if_visible(max_force, shown):
    """The wall's force at 10 mm is 2 N; a motor of 1 N gives half of it, a motor of 3 N all of it."""
    device = hs.SimulatedHapkit(max_force=max_force)
    run = hs.simulate("wall", {"stiffness": 400.0}, hand="press", seconds=1.5, device=device)
    for axes in drawn(run):
        assert (-max_force in limits(axes)) == shown
        assert shown or not limits(axes)


def test_a_stiff_law_leaves_room_for_the_data():
    """A wall of 5,000 N/m has 25 N at 5 mm, but the axis ends at 1.35 times the limit of 3 N."""
    run = hs.simulate("wall", {"stiffness": 5000.0}, hand=hs.Prescribed(lambda t: 0.01 * t), seconds=1.0)
    _, axes = drawn(run)
    assert curve(axes)[1].min() < -24.0
    assert -5.0 < axes.get_ylim()[0] < -3.0


def test_a_users_own_file_is_drawn_with_its_law_by_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for variable in ("XDG_DATA_HOME", "HAPKIT_STUDIO_FOLDER"):
        monkeypatch.setenv(variable, str(tmp_path / variable))
    found = []

    def save(paint, path, size, caption):
        figure = Figure(figsize=(11.0, 6.2), layout="constrained")
        paint(figure, colors())
        found.append((figure.axes[3], caption))

    monkeypatch.setattr(charts, "save", save)
    path = write(tmp_path, text("return -p.stiffness * abs(x)", end=END))
    assert main(["run", str(path), "--trust", "--hand", "press", "--plot", "mine.png"]) == 0
    axes, caption = found[0]
    x, force = curve(axes)
    assert force == pytest.approx(-0.2 * np.abs(x), abs=2e-3)
    assert caption.replace("\N{NO-BREAK SPACE}", " ").startswith(
        "Mine: stiffness 200 N/m, mass 0.1 kg, side right\n"
    )


def test_the_date_of_a_session_is_that_of_its_file(tmp_path, monkeypatch):
    path = tmp_path / "a.hapkit"
    hs.simulate("wall", hand="press", seconds=1.0).save(path)
    end = datetime(2026, 3, 4, 5, 7, 0).timestamp()
    os.utime(path, (end, end))
    run = hs.open_session(path)
    assert run.date == "2026-03-04 05:06"
    captions = []
    monkeypatch.setattr(charts, "save", lambda *given, caption: captions.append(caption))
    run.plot(tmp_path / "a.png")
    assert "2026-03-04" in captions[0]


def test_invalid_settings_are_drawn_without_a_curve():
    run = hs.simulate("wall", hand="press", seconds=1.0)
    run.settings.update(environment="gone")
    assert curve(drawn(run)[1]).size == 0
    own = LIBRARY["spring"]
    run.settings.update(environment="mine", parameters={"stiffness": 100.0})
    x, force = curve(drawn(run, known={"mine": own})[1])
    assert force == pytest.approx(-0.1 * x, abs=2e-3)
