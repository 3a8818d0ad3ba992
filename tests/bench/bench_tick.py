"""Time of a tick, and of a tick with the paddle's physics, relative to MuJoCo with the same wall."""

import statistics
import time

import numpy as np

from hapkit_studio import environments
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.tick import tick
from tests.bench.frame import Row

NAME, ORDER = "tick", 20
TICKS, BLOCKS = 10_000, 15

SLIDER_AND_WALL = """
<mujoco>
  <option timestep="0.001" gravity="0 0 0" integrator="implicitfast"/>
  <worldbody>
    <body>
      <joint name="hand" type="slide" axis="1 0 0" damping="0.5"/>
      <geom type="sphere" size="0.002" mass="0.044"/>
    </body>
    <geom type="box" size="0.01 0.05 0.05" pos="0.017 0 0" solref="-250 -2"/>
  </worldbody>
  <actuator><position joint="hand" kp="300" kv="2"/></actuator>
</mujoco>
"""


@compiled
def many_ticks(r, positions, period, out):
    """Render a sample at every position (n,) in m, as the live loop does, but without reading a clock."""
    for k in range(positions.shape[0]):
        tick(r, positions[k], period, 0.0, out[k])


def nanoseconds(function, count: int) -> float:
    """Return the time in ns per repetition, as the median over blocks."""
    function()
    times = []
    for _ in range(BLOCKS):
        start = time.perf_counter()
        function()
        times.append(1e9 * (time.perf_counter() - start) / count)
    return statistics.median(times)


def wall() -> headless.Scene:
    return headless.Scene(environments.named("wall"), environments.named("wall").values({"damping": 2.0}))


def tick_alone() -> float:
    """Return the time in ns of a tick, while the handle goes in and out of the wall."""
    r, _ = wall().prepare()
    positions = 0.005 + 0.003 * np.sin(2.0 * np.pi * 1e-3 * np.arange(TICKS))
    out = headless.new_rows(TICKS)
    per_tick = nanoseconds(lambda: many_ticks(r, positions, 1e-3, out), TICKS)
    if not 0.4 < np.mean(out[:, rows.APPLIED_FORCE] < 0.0) < 0.6:
        raise RuntimeError("the wall does not push back")
    return per_tick


def tick_with_paddle() -> float:
    """Return the time in ns of a tick with the simulated Hapkit and a hand that pushes and lets go."""
    r, body = wall().prepare()
    grip = GRIPS["medium"]
    hand = np.array([grip.mass, grip.damping, grip.stiffness])
    targets = 0.01 * np.sin(2.0 * np.pi * 1e-3 * np.arange(TICKS + 1))
    holding, out = np.ones(TICKS, dtype=np.int64), headless.new_rows(TICKS)
    return nanoseconds(lambda: headless.run_batch(r, body, hand, targets, holding, out), TICKS)


def mujoco_step() -> float | None:
    """Return the time in ns of a MuJoCo step with the same hand and wall, or None without MuJoCo."""
    try:
        import mujoco
    except ImportError:
        return None
    model = mujoco.MjModel.from_xml_string(SLIDER_AND_WALL)
    data = mujoco.MjData(model)
    steps = TICKS // 10

    def push() -> None:
        data.ctrl[0] = 0.01
        mujoco.mj_step(model, data, nstep=steps)

    per_step = nanoseconds(push, steps)
    if data.ncon != 1:
        raise RuntimeError("the slider does not touch the wall")
    return per_step


def run() -> list[Row]:
    """Return two rows: the tick, with MuJoCo's step as reference, and the tick with the paddle."""
    alone, whole, reference = tick_alone(), tick_with_paddle(), mujoco_step()
    ratio = reference / alone if reference else None
    reached = alone < 60.0 and (ratio is None or ratio >= 25.0)
    name = "MuJoCo step"
    return [
        Row("one tick", alone, "ns", name, reference, ratio, "< 60 ns, ≥ 25 × faster", reached),
        Row("tick and paddle", whole, "ns", name, reference, reference / whole if reference else None),
    ]
