"""The real firmware renders each law on an imposed motion: what it asks for is what the Python law asks for.

Up to 1 kHz every tick is told: position and velocity as the board had them, and the force. The Python law
gets the same rows from the first on.
"""

import numpy as np
import pytest

from tests.firmware import board_runs
from tests.firmware.vb import QUANTUM, needs_board
from tests.laws.board_laws import ENVIRONMENTS, Job, by_python

pytestmark = needs_board

BOUND = 2e-3  # N
# Held still at first, then into things and out of them, to both sides.
MOTION = ("0 position 0", "0.2 position 0.013 0.06", "0.27 position -0.02 0.1", "0.38 position 0.011 0.08")
CASES = {
    "spring": {"damping": 3.0},
    "wall": {"damping": 5.0},
    "friction": {},
    "hard_surface": {},
    "bump_valley": {"width": 0.04},
    "texture": {"kind": "sandpaper"},
    "button": {},
    "detents": {},
    "mass_spring_damper": {"integrator": "verlet"},
    "puck": {},
    "cat": {},
}
MORE = [
    ("friction", {"model": "lugre"}),
    ("texture", {"kind": "grating"}),
    ("bump_valley", {"law": "height"}),
    ("mass_spring_damper", {"integrator": "rk4"}),
]


def on_the_board(folder, key, values, rate):
    """Return the telemetry of a run; skip what this board leaves out."""
    try:
        return board_runs.render(folder, key, list(values.values()), rate, 0.4, script=MOTION).telemetry
    except KeyError as error:
        if error.args != (key,):
            raise
        pytest.skip(f"the board has no {key}")


def first_whole(frames):
    """Return the frames of the scene, none of them lost."""
    inside = [f for f in frames if f.generation == 1]
    steps = np.diff([f.seq for f in inside]) & 0xFFFF
    assert (steps == 1).all()
    return inside


@pytest.mark.parametrize(("key", "given"), [*CASES.items(), *MORE])
def test_the_firmware_asks_for_what_the_law_says(key, given, tmp_path):
    environment = ENVIRONMENTS[key]
    values = environment.values(given)
    rate = min(1000, environment.board_rate(values))
    frames = first_whole(on_the_board(tmp_path, key, values, rate))
    quantum = float(np.float32(QUANTUM))
    rows = np.array([(f.count * quantum, f.velocity) for f in frames])
    assert np.ptp(rows[:, 0]) > 0.02
    wanted, _ = by_python(Job(environment, values, 1.0 / rate, rows))
    asked = np.array([f.asked for f in frames])
    assert np.abs(wanted).max() > 0.05
    apart = np.abs(asked - wanted) > BOUND
    assert not apart.any(), (int(np.argmax(apart)), asked[apart][:3], wanted[apart][:3], rows[apart][:3])
