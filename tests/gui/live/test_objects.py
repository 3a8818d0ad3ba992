"""The second body is stored with the samples, and drawn and named in the position plot."""

from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.environments.base import MovingObject
from hapkit_studio.errors import LawError
from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import LIBRARY, RATE, canvas_of, colored, telemetry


def test_the_history_stores_the_objects_position_and_nan_without_an_object():
    history, place = LiveHistory(seconds=60.0, rate=RATE), np.random.default_rng(3).normal(size=9000)
    history.append(telemetry(1000))
    history.append(telemetry(9000, start=1000), object_position=place)  # more samples than an internal block
    kept = history.between(-np.inf, np.inf).y["object"]
    assert np.isnan(kept[:1000]).all()
    np.testing.assert_array_equal(kept[1000:], place)
    columns = history.window(np.array([1.0, 2.0, 3.0])).y["object"].reshape(-1, 2)
    for column, part in zip(columns, (place[:1000], place[1000:2000]), strict=True):
        assert sorted(column) == [part.min(), part.max()]


@pytest.mark.slow
def test_the_stored_position_follows_the_current_environments_state(reset_window, qtbot):
    window = reset_window
    live, studio = window.live, window.studio
    qtbot.waitUntil(lambda: studio.engine.settled)
    live.tick()
    live.history.clear()
    reader = studio.engine.reader()
    studio.choose("puck")
    qtbot.waitUntil(lambda: studio.environment.key == "puck" and studio.engine.settled)
    live.tick()
    begin = live.history.now
    studio.move_hand(0.012)
    qtbot.waitUntil(lambda: live.tick() or live.history.now > begin + 0.3)
    table = reader.read()
    window_of = live.history.between(-np.inf, table[-1, rows.HOST_TIME]).known()
    kept, times = window_of.y["object"], window_of.x
    assert np.isnan(kept[times < live.history.begin]).all()
    state = rows.STATE + LIBRARY["puck"].state_names.index("object")
    known = np.isfinite(kept)
    assert known[times > begin].all()
    there = np.isin(table[:, rows.HOST_TIME], times[known])
    np.testing.assert_array_equal(kept[known], table[there, state])
    assert np.ptp(kept[known]) > 1e-4  # the object was pushed


def test_an_object_is_drawn_at_its_samples_and_labelled_with_its_position(plots):
    header = plots.headers[0]
    canvas = canvas_of(plots, "position")
    assert not any(part.isVisible() for part in header.object)
    assert not len(colored(canvas.viewport().grab().toImage(), "objline"))
    history = LiveHistory(seconds=60.0, rate=RATE)
    history.append(telemetry(14_000), object_position=np.full(14_000, -0.0085))
    plots.view.set_history(history)
    plots.set_environment(LIBRARY["puck"], LIBRARY["puck"].values(), 3.0)
    plots._update_headers()
    plots.refresh()
    assert header.object[1].text() == "puck −8.50 mm"
    assert all(part.isVisible() for part in header.object)
    picture = canvas.viewport().grab().toImage()
    seen = colored(picture, "objline")[:, 1] / picture.devicePixelRatio()
    canvas.measure()
    assert np.median(seen) == pytest.approx(canvas.pixel(0.0, -8.5).y(), abs=1.5)
    plots.set_environment(LIBRARY["wall"], LIBRARY["wall"].values(), 3.0)
    plots._update_headers()
    assert not any(part.isVisible() for part in header.object)


def test_the_position_axis_includes_the_object(plots):
    history = LiveHistory(seconds=60.0, rate=RATE)
    history.append(telemetry(14_000), object_position=np.full(14_000, 0.037))
    plots.view.set_history(history)
    plots.refresh()
    assert canvas_of(plots, "position").view.viewRange()[1][1] > 37.0


def test_a_cap_rests_until_the_handle_pushes_it():
    button = LIBRARY["button"]
    values = button.values({"position": 0.005})
    places = button.place(values, np.array([-0.02, 0.004, 0.006, 0.011]), np.zeros((4, 5)))
    assert places == pytest.approx([0.005, 0.005, 0.006, 0.011])
    assert LIBRARY["wall"].place(values, np.zeros(4), np.zeros((4, 0))) is None


@pytest.mark.parametrize("moves", [MovingObject("puck", state="objekt"), MovingObject("cap", rests="there")])
def test_an_object_must_name_an_existing_state_or_parameter(moves):
    with pytest.raises(
        LawError, match=f"`(state|rests)` of the moving object '{moves.name}' must be one of: .*(object|mass)"
    ):
        replace(LIBRARY["puck"], moves=moves)
