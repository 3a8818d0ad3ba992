"""Stiffness limits with the velocity estimators that have more memory than one sample."""

import pytest

from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.analysis.stability.rendered import measured_stiffness_limit
from hapkit_studio.errors import ParameterError

FILTERED = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0)
BUTTERWORTH = [
    (60.0, 0, (1002, 1981, 2382, 2547, 1867, 0)),
    (20.0, 0, (1002, 760, 624, 318, 0, 0)),
    (20.0, 1, (334, 410, 382, 188, 0, 0)),
]


@pytest.mark.parametrize(("cutoff", "late", "limits"), BUTTERWORTH)
def test_second_order_filter(cutoff, late, limits):
    """0.05 kg, 0.5 N·s/m, 1 kHz: at 20 Hz, damping makes the stiffest spring softer."""
    for damping, limit in zip(FILTERED, limits, strict=True):
        found = stiffness_limit(
            0.05, 0.5, damping=damping, delay=late * 1e-3, estimator=("butterworth", {"cutoff": cutoff})
        )
        assert found == pytest.approx(limit, rel=0.005, abs=0.5)


@pytest.mark.parametrize("estimator", ["butterworth", ("butterworth", {"cutoff": 20.0}), "kalman"])
@pytest.mark.parametrize("loop", [{"damping": 2.0, "delay": 0.6e-3}, {"damping": 5.0}, {"damping": 60.0}])
def test_measured_limit_is_the_exact_one(estimator, loop):
    assert measured_stiffness_limit(0.05, 0.5, estimator=estimator, **loop) == pytest.approx(
        stiffness_limit(0.05, 0.5, estimator=estimator, **loop), rel=5e-4
    )


def test_adaptive_window_has_a_measured_limit_only():
    with pytest.raises(ParameterError, match=r"foaw is not linear.*: measured_stiffness_limit finds it") as e:
        stiffness_limit(0.05, 0.5, damping=1.0, estimator="foaw")
    assert "\n" not in str(e.value)


@pytest.mark.parametrize("late", [0.0, 1e-3])
def test_adaptive_window_is_as_stiff_as_any_without_damping_and_softer_with_it(late):
    """Without damping it has no say; with damping it lags behind the plain difference."""
    alone = measured_stiffness_limit(0.05, 0.5, delay=late, estimator="foaw")
    assert alone == pytest.approx(stiffness_limit(0.05, 0.5, delay=late), rel=0.01)
    limits = [measured_stiffness_limit(0.05, 0.5, damping=b, delay=late, estimator="foaw") for b in (1, 2, 5)]
    plain = [stiffness_limit(0.05, 0.5, damping=b, delay=late) for b in (1, 2, 5)]
    assert alone < limits[0] < limits[1] < limits[2]
    assert all(0.4 * most < limit < most for limit, most in zip(limits, plain, strict=True))
