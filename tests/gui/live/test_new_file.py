"""A new plot needs one file: a new signal is drawn live and in a replay, and read by cursors."""

import pytest

from tests.project_copy import copy_with, run_tests

NEW = '''"""How late each sample came."""

from hapkit_studio.gui.live.plots.declared import TimePlot, Trace

PLOT = TimePlot(
    key="lateness",
    title="Lateness",
    decimals=0,
    reach=50.0,
    share=20,
    order=9,
    traces=(Trace("lateness", "lateness", "hold", help="After the time at which it was due"),),
    folds=5,
)
'''


@pytest.mark.slow
def test_a_new_plot_needs_one_file(tmp_path):
    copy = copy_with(tmp_path, "hapkit_studio/gui/live/plots/lateness.py", NEW)
    files = [
        f"tests/gui/live/test_{name}.py"
        for name in ("every_plot", "kept_curves", "live", "time_plots", "time_view")
    ]
    output = run_tests(copy, "-m", "not slow and not alone", *files, "tests/gui/teach/test_projector.py")
    assert "test_the_last_signal_of_every_plot_is_drawn_and_read[replayed-lateness] PASSED" in output
