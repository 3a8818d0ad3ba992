"""The stability map's cells by other programs: the same handle, force held between samples, same rule."""

import numpy as np
from scipy.integrate import solve_ivp

from hapkit_studio.analysis.stability import rendered
from hapkit_studio.haptics import survey

MASS, VISCOUS, PERIOD = 0.044, 0.5, 1e-3
COUNT = round(rendered.SECONDS / PERIOD)


def verdicts(speed: np.ndarray, lost: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Return the class of every cell from its speeds (COUNT, n) m/s at the samples, by the studio's rule."""
    pull = np.diff(speed, axis=0, prepend=0.0) / PERIOD
    power = pull**2 + stiffness / MASS * speed**2
    parts = np.zeros((speed.shape[1], survey.PARTS, 3))
    parts[:, :, survey.POWER] = power.reshape(survey.PARTS, -1, speed.shape[1]).sum(axis=1).T
    ends = np.where(lost, survey.LEFT_RANGE, survey.COMPLETED)
    return rendered.by_envelope(survey.Found(parts, ends, np.full(speed.shape[1], COUNT)))


def scipy_cell(stiffness: float, damping: float) -> int:
    """Return one cell's class by solve_ivp: a segment from sample to sample, an event where x is far."""

    def motion(t, y, force):
        return y[1], (force - VISCOUS * y[1]) / MASS

    def far(t, y, force):
        return rendered.LINEAR_FAR - abs(y[0])

    far.terminal = True  # type: ignore[attr-defined]
    x, v, before = rendered.LINEAR_START, 0.0, rendered.LINEAR_START
    speed, lost = np.zeros((COUNT, 1)), False
    for k in range(COUNT):
        speed[k] = v
        force = -stiffness * x - damping * (x - before) / PERIOD
        before = x
        part = solve_ivp(motion, (0.0, PERIOD), (x, v), events=far, args=(force,), rtol=1e-8, atol=1e-16)
        x, v = part.y[:, -1]
        if part.status == 1:
            lost = True
            break
    return int(verdicts(speed, np.array([lost]), np.array([stiffness]))[0])


def mujoco_model():
    """Return a model of a slider with a motor; None where MuJoCo is not installed.

    RK4, because the semi-implicit steps take the held force as if it came without the half period of delay,
    and so call springs stable that are not.
    """
    try:
        import mujoco
    except ImportError:
        return None
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{PERIOD}" gravity="0 0 0" integrator="RK4">'
        '<flag contact="disable" constraint="disable"/></option>'
        f'<worldbody><body><joint name="hand" type="slide" axis="1 0 0" damping="{VISCOUS}"/>'
        f'<geom type="sphere" size="0.002" mass="{MASS}"/></body></worldbody>'
        '<actuator><motor joint="hand"/></actuator></mujoco>'
    )


def mujoco_cell(model, stiffness: float, damping: float) -> int:
    """Return one cell's class by mj_step, one step a sample."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[0] = before = rendered.LINEAR_START
    speed, lost = np.zeros((COUNT, 1)), False
    for k in range(COUNT):
        x = float(data.qpos[0])
        speed[k] = data.qvel[0]
        data.ctrl[0] = -stiffness * x - damping * (x - before) / PERIOD
        before = x
        mujoco.mj_step(model, data)
        if not abs(x) <= rendered.LINEAR_FAR:
            lost = True
            break
    return int(verdicts(speed, np.array([lost]), np.array([stiffness]))[0])
