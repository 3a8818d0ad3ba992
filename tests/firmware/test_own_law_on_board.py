"""A fourteenth environment, one file in a student's folder, renders on the virtual board as it is."""

import numpy as np

from hapkit_studio.workshop import reading
from tests.firmware import board_runs
from tests.firmware.test_laws_simavr import ARENA, BOUND, rate_of, rendered
from tests.firmware.vb import needs_board
from tests.laws.twins import Compiled

pytestmark = needs_board

FILE = '''"""Two walls and something sticky between them."""

import math

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter


def wall(depth, stiffness):
    if depth <= 0.0:
        return 0.0
    return stiffness * depth


@law(state={"warmth": 0.0})
def force(p, s, x, v, dt):
    s.warmth += dt * (abs(v) - 2.0 * s.warmth)
    right, left = wall(x - p.gap, p.stiffness), wall(-p.gap - x, p.stiffness)
    sticky = p.honey * math.tanh(20.0 * v) / (1.0 + s.warmth) if p.filling == "honey" else 0.0
    return left - right - sticky


ENVIRONMENT = Environment(
    key="honey_pot",
    title="Honey pot",
    summary="Sticky between two walls",
    parameters=(
        Parameter("stiffness", "Stiffness", "N/m", 300.0, 0.0, 2000.0),
        Parameter("gap", "Gap", "m", 0.008, 0.0, 0.04),
        Parameter("honey", "Honey", "N", 0.8, 0.0, 2.0),
        Choice("filling", "Filling", ("honey", "air")),
    ),
    force=force,
)
'''


def test_a_file_in_a_persons_folder_renders(tmp_path):
    file = tmp_path / "honey_pot.py"
    file.write_text(FILE, encoding="utf-8")
    environment = reading.load(file)
    values = environment.values()
    program = board_runs.program(environment, values, 1000, ARENA)
    rate = rate_of(program)
    assert rate == 1000
    assert program.size <= ARENA
    found = rendered(tmp_path, program, rate)
    law = Compiled(environment.force, values, 1.0 / rate)
    wanted = np.array([law.call(x, v) for x, v in found.rows.astype(float).tolist()])
    assert np.abs(wanted).max() > 0.5
    assert np.abs(found.forces - wanted).max() <= BOUND
