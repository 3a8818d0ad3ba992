"""The stability command prints text, a table and JSON, and draws a figure."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis.stability.kb_plane import Cells, Points, exact_boundary, plane
from hapkit_studio.charts import stability as charts
from hapkit_studio.charts.style import colors, new_figure
from hapkit_studio.cli import main
from hapkit_studio.dynamics.loop_settings import LoopSettings

FILTER = "Low-pass filtered difference, cutoff 35.5 Hz"
LATE = ("--viscous", "0.18", "--delay", "0.001", "--estimator", "iir:cutoff=35.5", "-K", "620", "-B", "2")


def run(capsys, *args):
    try:
        code = main(("stability", *args))
    except SystemExit as end:
        code = end.code
    out, err = capsys.readouterr()
    return code, out, err


def test_the_margin_is_the_first_line(capsys):
    """The limits are those of the tables in test_kb_plane."""
    code, out, err = run(capsys, *LATE)
    assert (code, err) == (0, "")
    assert out.startswith(
        "620 N/m and 2 N·s/m: Stiffness 1.4 × below the limit (no hand).\n"
        "After you let go, the handle is stable, 1.4 × below"
    )
    assert FILTER in out
    for text in ("Exact", "Simple rule", "Passive", "firm grip 6,023.3"):
        assert text in out
    assert "measured" not in out


@pytest.mark.slow
def test_the_json_has_columns_in_si_units(capsys, monkeypatch):
    monkeypatch.setattr("hapkit_studio.commands.stability.COLUMNS", 4)
    code, out, err = run(capsys, *LATE, "--measure", "--to", "4", "--json")
    assert (code, err) == (0, "")
    assert out.count("\n") == 1
    found = json.loads(out, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    assert found["text"].startswith(
        "After you let go, the handle is stable, 1.4 × below the limit. Limit without friction: "
    )
    assert found["handle"]["released"]["push"] is None
    assert found["setting"]["estimator_options"] == {"cutoff": 35.5}
    columns, measured = found["columns"], found["measured"]
    assert len({len(column) for column in columns.values()}) == 1
    assert columns["damping"][-1] == measured["damping"][-1] == 4.0
    assert columns["simple"][0] == pytest.approx(120.0)
    assert found["passivity_line"]["stiffness"][0] == pytest.approx(120.0, rel=1e-5)
    exact = np.interp(measured["damping"], columns["damping"], columns["exact"])
    assert measured["stiffness"] == pytest.approx(exact, rel=0.01)
    assert found["coulomb_line"] == pytest.approx(0.2 / 20.7e-6)
    assert found["map"] is None
    assert found["measuring_seconds"] > 0.0


def test_several_stable_intervals_are_reported(capsys):
    """With 3.2 N·s/m, stable intervals of the worked example in test_limits end at 256, 341 and 1,562 N/m."""
    loop = ("--mass", "0.03133", "--viscous", "0.82441", "--rate", "1430.93", "-B", "3.2", "-K", "300")
    more = "--estimator", "butterworth:cutoff=10.81613", "--to", "5.12", "--map", "--json"
    code, out, _ = run(capsys, *loop, *more)
    found = json.loads(out)
    assert code == 0
    assert found["text"].endswith("Stable again from 341 to 1,562 N/m.")
    ((low, high),) = found["stable_again"]
    assert (round(found["limit"]), round(low), round(high)) == (256, 341, 1562)
    cells = found["map"]
    column = cells["damping"].index(pytest.approx(3.2))
    for k, line in zip(cells["stiffness"], cells["classes"], strict=True):
        assert (line[column] == 0) == (k < found["limit"] or low < k < high), k


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """Return a function that draws a plane and returns the texts in its figure."""
    from matplotlib.text import Text

    drawn_texts = []
    draw = Text.draw
    monkeypatch.setattr(
        Text, "draw", lambda self, *a, **k: (drawn_texts.append(self.get_text()), draw(self, *a, **k))[1]
    )

    def texts(found, **more):
        drawn_texts.clear()
        charts.stability_figure(found, tmp_path / "map.png", **more)
        return drawn_texts

    return texts


@pytest.mark.slow
def test_the_figure_contains_regions_verdict_and_conditions(drawn):
    setting = LoopSettings(viscous=0.18, delay=1e-3, estimator="iir")
    texts = drawn(plane(setting, 620.0, 2.0))
    wanted = {
        "grows after a small push, no hand",
        "stable, no hand",
        "passive: stable in any hand",
        "× 1.4",
    }
    wanted |= {"Simple rule (too optimistic here)", "620 N/m, 2.0 N·s/m"}
    assert wanted <= set(texts)
    assert "Stiffness 1.4 × below the limit (no hand)." in texts
    below = " ".join(texts).replace("\u00a0", " ").replace("\n", " ")
    for label in (FILTER, "Limit, no hand 867 N/m", "Limit, firm grip 6,023 N/m"):
        assert label in below
    for label in (
        "Mass 0.044 kg",
        "Viscous damping 0.18 N·s/m",
        "Exact boundary: from the roots of the sampled loop",
    ):
        assert label in below
    assert "Measured boundary" not in texts


@pytest.mark.slow
def test_the_figure_shows_the_measurement(drawn):
    found = plane(LoopSettings(quantum=61.4e-6, coulomb=0.02), 500.0, 0.5)
    some = np.linspace(0.0, found.width, 3)
    points = Points(some, np.array([1000.0, np.inf, 3000.0]), True, True, np.array([0.4e-3, np.nan, 2.3e-3]))
    cells = Cells(some, np.linspace(0.0, found.top, 4), np.arange(12).reshape(4, 3) % 3, True, True)
    texts = drawn(replace(found, points=points, cells=cells))
    wanted = {"Bounded to ±2.3 mm", "Friction stops sensor buzz", "comes to rest, no hand"}
    assert wanted | {"keeps moving without growing", "grows, no hand"} <= set(texts)
    label = "found by simulations on both sides; below this line, the motion does not grow, with friction"
    assert label in " ".join(texts).replace("\u00a0", " ").replace("\n", " ")
    assert "stable, no hand" not in texts


@pytest.mark.slow
def test_measurements_beyond_the_map_do_not_change_its_layout(tmp_path):
    found = plane(LoopSettings(controller=True), 300.0, 0.0)
    places = []
    for stiffness in (0.5 * found.top, 2.0 * found.top):
        points = Points(np.array([1.0]), np.array([stiffness]), False, True)
        figure = new_figure(tmp_path / "map.png", (8.84, 6.36))
        charts.draw(figure, colors(), charts.Map(replace(found, points=points)))
        figure.draw_without_rendering()
        places.append(figure.axes[0].get_position().bounds)
    assert places[0] == pytest.approx(places[1], abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "damping"), [(620.0, 2.0), (800.0, 1.5), (1100.0, 1.5), (250.0, 0.05), (1400.0, 11.8)]
)
def test_the_dots_label_covers_no_line_and_stays_inside(stiffness, damping, tmp_path):
    found = plane(LoopSettings(viscous=0.18, delay=1e-3, estimator="iir"), stiffness, damping)
    hands = {
        hand: exact_boundary(LoopSettings(delay=1e-3, hand=hand), found.damping) for hand in ("light", "firm")
    }
    figure = new_figure(tmp_path / "map.png", (8.84, 6.36))
    dot = charts.draw(figure, colors(), charts.Map(found, hands=hands))
    figure.draw_without_rendering()
    frame = dot.label.axes.get_window_extent()
    for label in (w for w in figure.axes[0].texts if w.get_text()):
        box = label.get_window_extent()
        assert frame.x0 < box.x0 < box.x1 < frame.x1
        assert frame.y0 < box.y0 < box.y1 < frame.y1
        for line in figure.axes[0].lines[:-1]:  # matplotlib's last line is the dot
            corners = line.get_transform().transform(line.get_xydata())
            along = np.linspace(0, len(corners) - 1, 20_000)
            x, y = (np.interp(along, range(len(corners)), corner) for corner in corners.T)
            assert not ((box.x0 < x) & (x < box.x1) & (box.y0 < y) & (y < box.y1)).any()


def test_a_picture_of_pure_damping_has_its_limits_in_their_own_unit(drawn):
    """The picture has the limits of damping, and no lines of stiffness."""
    found = plane(LoopSettings(viscous=0.18), 0.0, 2.0)

    def below(**more):
        return " ".join("".join(drawn(found, **more)).replace("\u00a0", " ").split())

    assert "Limit, no hand" in below()
    limits = below(dampings={"released": 41.26}).rsplit("Hand no hand", 1)[1]
    assert limits == " · Limit, no hand 41.3 N·s/m"


@pytest.mark.parametrize("removed", ["--jitter", "--object"])
def test_a_removed_option_gives_a_one_line_error(capsys, removed):
    found = run(capsys, removed, "puck")
    assert found == (2, "", f"hapkit-studio: unrecognized arguments: {removed} puck\n")


@pytest.mark.slow
def test_the_worst_of_all_hands_is_printed(capsys, tmp_path):
    args = ("--viscous", "0.4", "--delay", "0.001", "--to", "2", "-B", "0", "--hands")
    code, out, err = run(capsys, *args, "--plot", str(tmp_path / "hands.png"))
    assert (code, err) == (0, "")
    assert "Scientific Reports 5:18004, 2015, fig. 3\n" in out
    assert "J. Biomechanical Engineering 119(1), 1997 (from memory)" in out
    found = json.loads(run(capsys, *args, "--json")[1])["hand_family"]
    assert min(found["people"]) > (0.4 + min(hand["damping"][0] for hand in found["known"])) / 1.5e-3
    assert "not linear" in run(capsys, "--hands", "--estimator", "foaw")[2]
