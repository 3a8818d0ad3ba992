"""The Bode view measures the current scene and loop; after a change, its result is out of date."""

import pytest

from hapkit_studio.analysis.bode import simulation
from hapkit_studio.gui.live.export import write
from hapkit_studio.gui.pages.bode import SIMULATION


@pytest.fixture
def page(reset_window):
    """Return the view with a wall of 300 N/m; nothing is measured automatically."""
    reset_window.studio.choose("wall")
    reset_window.studio.set_value("stiffness", 300.0)
    shown = reset_window.views.page("bode")
    shown.begun.add("loop")
    reset_window.views.show("bode")
    shown.job._needs = ""
    shown.where.show_index(SIMULATION)
    return shown


@pytest.mark.slow
def test_the_current_scene_is_measured_and_out_of_date_after_a_change(page, reset_window, qtbot, tmp_path):
    with qtbot.waitSignal(page.job.finished, timeout=20_000):
        page.bar.run.click()
    (curve,) = page.found.curves
    assert page.found.environment.key == "wall"
    assert page.found.values["stiffness"] == 300.0
    assert curve.setting.rate == reset_window.studio.engine.loop.rate
    assert not page.chart.pale
    figure, numbers = page.exports()
    assert numbers()["curves"][0]["rate_Hz"] == curve.setting.rate
    assert write(tmp_path / "a.png", figure, numbers)
    reset_window.studio.set_value("stiffness", 400.0)
    assert page.chart.pale
    reset_window.studio.set_value("stiffness", 300.0)
    assert not page.chart.pale


@pytest.mark.slow
def test_the_chosen_amplitude_is_used(page, qtbot, monkeypatch):
    asked = []
    real = simulation.measure
    monkeypatch.setattr(
        simulation, "measure", lambda *given, **more: asked.append(given) or real(*given, **more)
    )
    page.amplitude._enter(page.amplitude.quantity.factor * 2e-4)
    with qtbot.waitSignal(page.job.finished, timeout=20_000):
        page.bar.run.click()
    assert asked[0][3] == pytest.approx(2e-4)
    assert page.found.amplitude == pytest.approx(2e-4)
