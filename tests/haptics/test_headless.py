"""Headless runs for sweeps have complete rows, may exceed a user's limits, and can be cancelled."""

import math

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Hand, Prescribed
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, rows


def scene(key="spring", rate=1000.0, delay=0.0, device=None, max_speed=math.inf, **values):
    chosen = environments.named(key)
    return headless.Scene(
        chosen,
        {**chosen.values(), **values},
        device or SimulatedHapkit(),
        LoopSettings(rate, delay),
        max_speed,
    )


def test_the_hand_releases_the_handle_at_the_first_sample_after_its_release_time():
    for release, last in ((0.010, 9), (0.0105, 10), (0.0, -1), (9.0, 49)):
        out, _ = headless.render(scene(), Hand(0.0, 1.0, 50.0, lambda t: 0.01, release), 50)
        held = np.flatnonzero(~np.isnan(out[:, rows.HAND_TARGET]))
        assert len(held) == last + 1
        assert not len(held) or held[-1] == last


def test_sweeps_may_exceed_a_users_limits_but_need_finite_numbers():
    out, _ = headless.render(scene(stiffness=50_000.0, damping=-3.0), None, 20)
    assert np.isfinite(out[:, rows.TRUE_POSITION]).all()
    with pytest.raises(ParameterError, match=r"Stiffness must be a finite number, not nan\."):
        headless.render(scene(stiffness=math.nan), None, 20)
    with pytest.raises(ParameterError, match=r"Centre must be a finite number, not inf\."):
        headless.render(scene(center=math.inf), None, 20)


def test_an_unstable_loop_stays_within_the_clamps_range():
    device = SimulatedHapkit(initial_position=1e-3)
    out, _ = headless.render(scene(stiffness=50_000.0, device=device), None, 3000)
    assert np.isfinite(out[:, : rows.HAND_TARGET]).all()
    assert np.abs(out[:, rows.APPLIED_FORCE]).max() == 3.0


def test_a_cancelled_run_ends_at_once():
    r, body = scene().prepare()
    r.control.quit[0] = 1
    out = headless.new_rows(10)
    zeros = np.zeros(11)
    assert headless.run_batch(r, body, np.zeros(3), zeros, np.zeros(10, dtype=np.int64), out) == 0
    assert not out.any()
    r.control.quit[0] = 0
    assert headless.run_batch(r, body, np.zeros(3), zeros, np.zeros(10, dtype=np.int64), out) == 10


def test_an_imposed_motion_may_have_one_sample():
    out, _ = headless.render(scene("wall"), Prescribed(lambda t: 0.01), 1)
    assert out[0, rows.FORCE] == pytest.approx(-250.0 * (math.floor(0.01 / 20.7e-6) * 20.7e-6 - 0.005))
