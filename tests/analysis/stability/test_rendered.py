"""The measured map and boundary agree with the exact limit, and with the published effect of friction."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from hapkit_studio import environments
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.analysis.stability import kb_plane, rendered
from hapkit_studio.analysis.stability.kb_plane import exact_boundary
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.analysis.stability.rendered import BUZZES, DECAYS, GROWS
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import Cancelled
from hapkit_studio.haptics import headless, rows

LINEAR = ["difference", "iir", ("butterworth", {"cutoff": 20.0}), "kalman"]
# values of Diolaiti et al. 2006: 1000 N/m, 0.05 kg, 1 kHz, 20 µm
STIFFNESS, STEP = 1000.0, 20e-6


@pytest.fixture
def threads():
    """Return threads of normal priority, so that other tests do not delay them."""
    with ThreadPoolExecutor(2) as made:
        yield made


def exact(setting: LoopSettings, damping: float) -> float:
    return float(exact_boundary(setting, [damping])[0])


def some_settings(rng: np.random.Generator, count: int):
    """Yield settings, each with a damping at which some spring is stable."""
    while count:
        rate = float(rng.choice([250.0, 1000.0, 4000.0]))
        mass, viscous = float(10 ** rng.uniform(-2, -0.5)), float(10 ** rng.uniform(-1, 0.5))
        setting = LoopSettings(
            mass=mass,
            viscous=viscous,
            rate=rate,
            delay=float(rng.choice([0.0, rng.uniform(0.0, 3.0)])) / rate,
            estimator=LINEAR[rng.integers(len(LINEAR))],
            hand=str(rng.choice(["released", "light", "firm"])),
        )
        damping = float(rng.choice([0.0, 0.3 * rng.random() * mass * rate]))
        if exact(setting, damping) > 0.0:
            count -= 1
            yield setting, damping


@pytest.mark.parametrize("count", [6, pytest.param(24, marks=pytest.mark.slow)])
def test_the_boundary_is_the_exact_one_within_one_percent(rng, threads, count):
    for setting, damping in some_settings(rng, count):
        found = rendered.boundary(setting, [damping], executor=threads)
        assert found == pytest.approx([exact(setting, damping)], rel=0.01), setting


@pytest.mark.parametrize("estimator", LINEAR)
@pytest.mark.parametrize("delay", [0.0, 1.37e-3])
def test_one_percent_inside_decays_and_outside_grows(estimator, delay):
    setting = LoopSettings(delay=delay, estimator=estimator)
    limit = exact(setting, 0.5)
    found = rendered.judge(rendered.rendered(setting), [0.99 * limit, 1.01 * limit], [0.5, 0.5])
    assert found.tolist() == [DECAYS, GROWS]


SLOW = LoopSettings(mass=0.05, viscous=1.0, estimator=("butterworth", {"cutoff": 5.0}))


@pytest.mark.parametrize(
    "setting", [LoopSettings(), LoopSettings(delay=1.3e-3, estimator="iir", hand="light"), SLOW]
)
def test_the_map_of_a_linear_loop_equals_rendering_of_each_cell(setting):
    """Each row is one stiffness, each column one damping; in half of the settings only a strip is stable."""
    damping, stiffness = np.linspace(0.0, 12.0, 13), np.geomspace(20.0, 40_000.0, 31)
    found = rendered.classes(setting, damping, stiffness)
    assert found.dtype == np.int8
    k, b = np.meshgrid(stiffness, damping, indexing="ij")
    simulated = rendered.judge(rendered.rendered(setting), k.ravel(), b.ravel())
    assert (found == simulated.reshape(found.shape)).all()
    assert set(found.ravel().tolist()) == {DECAYS, GROWS}
    assert setting is not SLOW or (np.diff((found == DECAYS).astype(int), axis=0) > 0).any()


@pytest.mark.parametrize("share", [0.25, 0.4, 0.6, 1.0, 2.0])
def test_friction_and_steps_divide_the_plane_as_in_diolaiti(share, threads):
    """``share`` is b / (K T). Below 1/2, a large motion grows.

    Above 1/2, friction below K Δ / 2 never stops a motion.
    """
    for friction in (0.0, 0.1, 0.25, 0.4, 0.495, 0.505, 1.0):
        setting = LoopSettings(
            mass=0.05, viscous=share * STIFFNESS * 1e-3, coulomb=friction * STIFFNESS * STEP, quantum=STEP
        )
        verdict = rendered.classes(setting, [0.0], [STIFFNESS], real=True, executor=threads)
        wanted = GROWS if share < 0.5 else BUZZES if friction < 0.5 else DECAYS
        assert verdict.tolist() == [[wanted]], friction


def test_friction_sustains_a_motion_of_known_amplitude(threads):
    """A motion of A = 4 f_c / (π ω (K T / 2 - b)) neither grows nor decays; ω² = K / m (theory.md 2)."""
    setting = replace(LoopSettings(), quantum=5e-6)
    start = rendered.STARTS[0] * setting.quantum

    def beyond(stiffness):
        turning = math.sqrt(stiffness / setting.mass)
        gained = math.pi * turning * (0.5 * stiffness / setting.rate - setting.viscous)
        return gained * start - 4.0 * setting.coulomb

    found = rendered.boundary(setting, [0.0], real=True, executor=threads)
    assert found == pytest.approx([brentq(beyond, 1000.0, 1e4)], rel=0.02)
    assert found[0] > 1.05 * exact(setting, 0.0)


def test_the_adaptive_window_may_buzz_without_growing(threads):
    setting = LoopSettings(mass=0.05, viscous=0.5, estimator="foaw")
    limit = stiffness_limit(0.05, 0.5, damping=2.0)
    found = rendered.classes(setting, [2.0], [0.01 * limit, 0.5 * limit, 1.1 * limit], executor=threads)
    assert found.tolist() == [[DECAYS], [BUZZES], [GROWS]]


@pytest.mark.parametrize("real", [False, True])
@pytest.mark.parametrize("delay", [0.0, 1e-3])
def test_the_passivity_controller_raises_the_boundary(real, delay, threads):
    """The controller dissipates excess energy until its force is too late (Hannaford and Ryu 2002)."""
    plain, damping = LoopSettings(delay=delay), [0.0, 1.0]
    held = replace(plain, controller=True)
    before, after = (rendered.boundary(s, damping, real=real, executor=threads) for s in (plain, held))
    assert (after > 3.0 * before).all()
    # without the controller, oscillations grow slowly with the first two springs, and fast with the third
    stiffness = [1.005 * before[0], 1.02 * before[0], 1.2 * before.max()]
    beyond = rendered.classes(held, damping, stiffness, real=real, executor=threads)
    assert (beyond != GROWS).all()


def test_many_maps_in_one_sweep_equal_single_ones(threads):
    settings = [
        LoopSettings(),
        LoopSettings(delay=1e-3),
        LoopSettings(coulomb=0.0, quantum=0.0, hand="light"),
    ]
    damping, stiffness = [0.0, 1.0, 7.0, 20.0], np.geomspace(200.0, 20_000.0, 6)
    found = rendered.maps(settings, damping, stiffness, real=True, executor=threads)
    for one, setting in zip(found, settings, strict=True):
        assert (one == rendered.classes(setting, damping, stiffness, real=True, executor=threads)).all()
    assert not (found[0] == found[1]).all()


def test_progress_is_reported_and_a_map_can_be_cancelled(threads):
    reports = []
    cells = [1.0, 2.0], [50.0, 60.0, 70.0]
    rendered.classes(LoopSettings(), *cells, real=True, progress=lambda *now: reports.append(now))
    assert (reports[0], reports[-1]) == ((0, 6), (6, 6))

    def stop(done, of):
        raise Cancelled("Cancelled.")

    for work in (rendered.boundary, lambda s, b, **k: rendered.classes(s, b, b, **k)):
        with pytest.raises(Cancelled):
            work(LoopSettings(), [1.0, 2.0], real=True, progress=stop)


@pytest.mark.parametrize(("stiffness", "damping"), [(1415.0, 8.0), (1464.0, 10.46)])
def test_convergence_to_a_limit_cycle_is_not_growth(stiffness, damping):
    """Both springs are inside the linear limit: an amplitude of 200 sensor steps decays to 9 or 16 steps."""
    coarse = LoopSettings(
        viscous=0.18, coulomb=0.02, quantum=61.4e-6, delay=1e-3, estimator=("iir", {"cutoff": 35.5})
    )
    limit = exact_boundary(coarse, [damping])[0]
    assert stiffness < 0.985 * limit
    around = [stiffness, 1.03 * limit]
    found = rendered.classes(coarse, [damping], around, real=True).ravel().tolist()
    assert found == [rendered.BUZZES, rendered.GROWS]


def test_with_controller_the_boundary_gives_the_bounded_amplitude():
    """The amplitude equals that of a delayed spring without friction, rendered for the same time."""
    setting, damping = LoopSettings(delay=1e-3, controller=True), np.array([0.0])
    points = rendered.measure_points(setting, damping)
    stiffness = points.stiffness[0]
    assert stiffness > 3.0 * exact_boundary(setting, damping)[0]
    values = {"stiffness": (1.0 - 2e-4) * stiffness, "damping": 0.0, "center": 0.0}
    device = simulated_handle(setting, False, 200.3 * setting.quantum)
    scene = headless.Scene(environments.named("spring"), values, device, setting)
    out, _ = headless.render(scene, None, 12_000)
    assert points.swing[0] == pytest.approx(0.5 * np.ptp(out[8000:, rows.TRUE_POSITION]), rel=1e-3)
    assert points.name == f"Bounded to ±{1e3 * points.swing[0]:.2g} mm"
    found = replace(kb_plane.plane(setting, 100.0, 0.0), points=points)
    measured = kb_plane.as_json(found)["measured"]
    assert (measured["kind"], measured["swing"]) == ("bounded", points.swing.tolist())
    plain = rendered.measure_points(replace(setting, controller=False), damping)
    assert (plain.name, plain.swing) == ("Measured boundary", None)
