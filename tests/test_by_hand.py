"""A real mouse and real keys are used to push, freeze, compare, record, reopen and export two walls."""

import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not (shutil.which("Xvfb") and shutil.which("xdotool")), reason="needs Xvfb and xdotool"
    ),
]
QUANTUM = 2.07e-5  # the sensor's step in m


@pytest.fixture
def display():
    """Return the display of a separate X server."""
    ours, theirs = os.pipe()
    command = ["Xvfb", "-displayfd", str(theirs), "-screen", "0", "1280x720x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, pass_fds=[theirs], stderr=subprocess.DEVNULL) as server:
        os.close(theirs)
        with os.fdopen(ours) as answer:
            yield f":{answer.readline().strip()}"
        server.terminate()


def by_hand(display, folder):
    """Run tests.by_hand; return its results, and for each push the match object of the slope shown."""
    folder.mkdir()
    environment = {
        **os.environ,
        "DISPLAY": display,
        "QT_QPA_PLATFORM": "xcb",
        "XDG_CONFIG_HOME": str(folder / "settings"),
        "HAPKIT_STUDIO_FOLDER": str(folder),
    }
    done = subprocess.run(
        [sys.executable, "-m", "tests.by_hand", str(folder)],
        env=environment, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout.splitlines()[-1])
    return seen, [re.match(r"−([\d,.]+) ± ", text) for text in seen["slopes"]]


def test_two_pushes_are_felt_compared_recorded_and_exported(display, tmp_path):
    """If the computer is late, the samples lie on no straight line and have no slope: then push again."""
    for _ in range(3):
        shutil.rmtree(tmp_path)
        seen, found = by_hand(display, tmp_path)
        if all(found):
            break
    assert all(found), seen
    slopes = [float(slope[1]) for slope in found]
    assert slopes == pytest.approx([250.0, 300.0], rel=0.01)
    assert seen["held"] == 1
    ring, table = np.load(tmp_path / "ring.npy"), read_csv(tmp_path / "felt.csv")
    kept = table["position_m"]
    first = next(
        k for k in range(len(ring) - len(kept) + 1)
        if np.allclose(ring[k : k + len(kept), 1], kept, rtol=0.0, atol=1e-3 * QUANTUM)
    )  # fmt: skip
    assert len(kept) > 2000
    assert (np.diff(ring[first : first + len(kept), 0]) == 1.0).all()
    np.testing.assert_allclose(
        table["force_applied_N"], ring[first : first + len(kept), 2], rtol=0.0, atol=1e-6
    )


def read_csv(path):
    """Return a table's columns by the names in its header."""
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("# ")
    names, *rows = [line for line in lines if not line.startswith("#")]
    return dict(zip(names.split(","), np.loadtxt(rows, delimiter=",").T, strict=True))
