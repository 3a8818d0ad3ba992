"""The Identify view uses the newest samples with the current settings, and a hand that shakes the handle."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.identify import Estimate, Handle, Part, Setup, from_run, identify
from hapkit_studio.analysis.identify.texts import conditions
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import StudioError
from hapkit_studio.gui.live.export import write
from hapkit_studio.gui.pages.identify import newest_samples
from hapkit_studio.gui.state import prepare
from tests.gui.pages.drawing_support import drawn, outside
from tests.gui.shell.test_layout import cut_off

LEFT_OVER = "time, s (residual: the force that no term explains)"


@pytest.fixture(autouse=True)
def nothing_compiled(monkeypatch):
    """Prevent the page from starting a program that compiles."""
    monkeypatch.setattr(prepare, "begin", lambda *_, **__: None)


@pytest.fixture
def page(idle_window):
    idle_window.views.show("identify")
    return idle_window.views.page("identify")


@pytest.fixture(scope="module")
def found():
    run = hs.simulate("wall", {"stiffness": 300.0, "damping": 2.0}, hand="tap", seconds=3.0)
    return identify(from_run(run))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("value", "half", "asked", "sign", "text"),
    [
        (599.4, 0.5, 600.0, "info", "the device gave 599.4 ± 0.5 N/m, 0.6 N/m less."),
        (599.6, 0.5, 600.0, "check", "the device gave 599.6 ± 0.5 N/m."),
        (599.6, 0.5, None, "info", "Stiffness: 599.6 ± 0.5 N/m."),
    ],
)
def test_a_check_mark_requires_that_the_interval_contains_the_set_value(
    page, found, value, half, asked, sign, text
):
    one = Estimate("stiffness", value, half, asked, asked)
    page.show_result(replace(found, rendered=replace(found.rendered, estimates=(one,), points=None)))
    assert page.answer.sign.name == sign
    assert page.answer.label.text().endswith(text)


@pytest.mark.slow
def test_each_part_first_shows_an_instruction_then_its_terms(page, found):
    assert page.answer.label.text() == (
        "Move the handle or press Shake handle. Then press Identify to "
        "compare the rendered values with those you set."
    )
    assert page.how.text() == "Push against the scene and let go, slowly and fast, in both directions."
    page.press()
    assert page.bar.status.text() == "Connect a device first."
    assert not page.shaking.isEnabled()

    page.show_result(found)
    assert page.answer.label.text().startswith("Stiffness: you set 300 N/m, the device gave 29")
    titles = [axes.get_xlabel() for axes in drawn(page.chart)]
    assert titles[1:] == ["velocity into the wall, mm/s", "velocity out of the wall, mm/s", LEFT_OVER]
    for axes, name in zip(drawn(page.chart)[:3], found.rendered.points.names, strict=False):
        across, up = axes.get_xlim(), axes.get_ylim()
        own, force = found.rendered.points.share(name)
        assert across[0] < 1e3 * own.min() < 1e3 * own.max() < across[1]
        assert up[0] < -force.max() < -force.min() < up[1]
    rows = {row[0]: row[1:] for row in page.table.texts()}
    assert rows["Term"] == ("Chosen", "Rendered")
    asked, rendered = rows["Damping on the way in\nN·s/m"]
    assert asked == "2"
    assert rendered.startswith("2.0")
    assert page.point.text().endswith(found.force_known)
    page.parts.button(1).click()
    assert page.point.text().endswith(found.force_known)
    assert page.answer.label.text().startswith("Mass: 44 g of the handle and 50 g of the hand, identified 9")
    titles = [axes.get_xlabel() for axes in drawn(page.chart)]
    assert titles == ["acceleration, m/s²", "velocity, mm/s", "direction of motion", LEFT_OVER]

    page.parts.button(0).click()
    nothing = replace(found, rendered=Part("rendered", advice="No."), handle=Part("handle", advice="No."))
    still = identify(from_run(hs.simulate("wall", seconds=1.0)))
    for what, text, shown in (
        (found, found.sentences(found.rendered)[0], True),
        (still, "Unknown: the handle never touched the surface. Push into it.", False),
        (nothing, "No.", False),
    ):
        page.show_result(what)
        assert page.answer.label.text() == text
        assert page.answer.sign.name == ("info" if shown else "triangle")
        assert page.chart.isVisible() == shown
        assert page.how.isVisible() != shown
        assert page.bar.export.isEnabled() == shown


@pytest.mark.slow
def test_before_the_first_result_an_example_is_shown(page, found, qtbot):
    qtbot.waitUntil(page.chart.isVisible)
    assert page.how.isVisible()
    assert "example" in page.how.text()
    assert page.chart.pale
    assert page.found is None
    assert not page.bar.export.isEnabled()
    page.parts.button(1).click()
    qtbot.waitUntil(lambda: len(drawn(page.chart)) > 0)
    assert drawn(page.chart)[0].get_xlabel() == "acceleration, m/s²"
    page.parts.button(0).click()
    page._fresh.begin()
    page.show_result(found)
    assert not page.chart.pale
    assert not page.how.isVisible()


@pytest.mark.slow
def test_texts_fit_and_a_result_of_other_settings_is_out_of_date(page, found, idle_window):
    studio = idle_window.studio
    idle_window.resize(1280, 720)
    page._fresh.begin()
    page.show_result(found)
    stiffness, scene = studio.values["stiffness"], studio.environment.key
    changes = (
        (
            "values",
            lambda: studio.set_value("stiffness", 123.0),
            lambda: studio.set_value("stiffness", stiffness),
        ),
        ("scene", lambda: studio.choose("spring"), lambda: studio.choose(scene)),
        ("loop", lambda: studio.set_loop(rate=500.0), lambda: studio.set_loop(rate=1000.0)),
    )
    for what, change, back in changes:
        change()
        assert page.answer.label.text() == (
            f"The result is out of date, because the {what} changed. Press Identify again."
        )
        assert page.answer.sign.name == "circle"
        assert page.chart.pale
        back()
        assert page.answer.sign.name == "info"
        assert not page.chart.pale
    idle_window.grab()
    assert cut_off(page) == cut_off(page.side) == []


@pytest.mark.slow
def test_a_result_is_exported_and_a_low_window_shows_the_upper_axes(page, found, idle_window, qapp, tmp_path):
    page.show_result(found)
    write(tmp_path / "found.json", *page.exports())
    written = json.loads((tmp_path / "found.json").read_text())
    assert written["parts"]["rendered"]["estimates"][0]["set"] == 300.0
    assert written["setup"]["Stiffness"] == "300 N/m"
    write(tmp_path / "found.png", *page.exports())
    assert (tmp_path / "found.png").read_bytes().startswith(b"\x89PNG")
    for size, shown in (((960, 600), False), ((1440, 900), True)):
        idle_window.resize(*size)
        for _ in range(3):
            qapp.processEvents()
        titles = [axes.get_xlabel() for axes in drawn(page.chart)]
        assert (LEFT_OVER in titles) == shown
        assert outside(page.chart) == []


@pytest.mark.slow
def test_shaking_ends_with_a_result(window, qtbot):
    window.live.start()
    window.studio.choose("spring")
    qtbot.waitUntil(lambda: window.studio.environment.key == "spring")
    window.studio.set_values({"stiffness": 200.0})
    window.views.show("identify")
    page = window.views.page("identify")
    page.pieces.button(0).click()
    page.shaking.click()
    assert page.shaking.text() == "Let go"
    qtbot.waitUntil(lambda: page.found is not None)
    stiffness = page.found.rendered["stiffness"]
    assert stiffness.asked == 200.0
    assert stiffness.value == pytest.approx(200.0, rel=0.02)
    assert page.found.rendered["damping"].value == pytest.approx(-0.1, abs=0.02)
    assert page.found.handle["mass"].value == pytest.approx(0.094, rel=0.05)
    assert page.shaking.text() == "Shake handle"
    # newest_samples() fixes the range of rows: later rows are left out, even if the thread starts late
    take = newest_samples(window.studio, window.live, 2.0)
    first, reader = take(), window.studio.engine.reader()
    qtbot.waitUntil(lambda: len(reader.read()) > 0)
    np.testing.assert_array_equal(take().position, first.position)
    np.testing.assert_array_equal(take().time, first.time)
    # rows before a change of settings are not included
    window.studio.set_values({"stiffness": 100.0})
    with pytest.raises(StudioError, match=r"The settings changed 0\.\d s ago"):
        newest_samples(window.studio, window.live, math.inf)()
    # since this change, no hand has held the handle
    window.live.tick()
    qtbot.waitUntil(lambda: window.live.history.now > window.live.history.changes[-1] + 0.5)
    assert (first.setup.grip, newest_samples(window.studio, window.live, 0.3)().setup.grip) == (MEDIUM, None)


MEDIUM = GRIPS["medium"]
PADDLE = Handle(0.044, 0.5, 0.1)


@pytest.mark.parametrize(
    ("setup", "released", "hand"),
    [
        (Setup(), False, "not known"),
        (Setup(), True, "none"),
        (Setup(handle=PADDLE), False, "none"),
        (Setup(handle=PADDLE, grip=MEDIUM), False, f"{1e3 * MEDIUM.mass:g} g"),
        (Setup(handle=PADDLE, grip=MEDIUM), True, "N/m, and let go"),
    ],
)
def test_the_grip_of_the_samples_is_named(setup, released, hand):
    """The hand on a real Hapkit is unknown, unless the user states that no hand holds the handle."""
    assert hand in dict(conditions(setup, released))["Hand"]


@pytest.mark.slow
def test_the_hand_shakes_at_the_surface_until_a_stop_or_another_view(window, qtbot):
    window.views.show("identify")
    page = window.views.page("identify")
    places = np.array([page.hand_target(t) for t in np.arange(0.0, 10.0, 0.01)])
    assert places[0] == pytest.approx(0.005 + 0.003)  # the target starts 3 mm inside the wall
    assert places.min() < 0.0
    assert 0.015 < places.max() < 0.05
    page.shaking.click()
    window.studio.stop()
    assert not page.shake.isActive()
    assert page.found is None
    window.studio.release_stop()
    page.shaking.click()
    window.views.show("live")
    assert not page.shake.isActive()
    window.studio.set_loop(hand="released")
    assert not page.shaking.isEnabled()
