"""The sampled spring over a grid of loops, with every filter, and with damping that lowers its limit."""

import itertools
import math

import numpy as np
import pytest

from hapkit_studio.analysis.failures import failures, spring
from hapkit_studio.analysis.failures.base import show
from hapkit_studio.analysis.failures.filters import ESTIMATORS
from hapkit_studio.errors import ParameterError

SPRING, FILTERS, WORSE = (failures()[k] for k in ("sampled_spring", "filters", "filtered_damping"))

# Spring: K = 500 N/m, B = 1 N·s/m. Handle: 0.05 kg, 0.5 N·s/m. Rate: 1 kHz. Columns: delay in periods,
# largest roots from the table.
ROOTS = [
    (0.0, (0.9874025, 0.9874025, 0.0101887)),
    (0.5, (0.9899131, 0.9899131, 0.0592341, 0.0427125)),
    (1.0, (0.9924966, 0.9924966, 0.1083127, 0.0931040)),
]


@pytest.mark.parametrize(("late", "table"), ROOTS)
def test_the_loops_map_has_the_roots_of_the_table(late, table):
    matrix = spring.step_matrix(0.05, 0.5, 500.0, 1.0, 1e-3, late * 1e-3)
    roots = np.sort(np.abs(np.linalg.eigvals(matrix)))[::-1]
    assert roots[: len(table)] == pytest.approx(table, abs=6e-8)
    assert roots[len(table) :] == pytest.approx(0.0, abs=1e-8)


# columns: mass, virtual damping, the handle's own damping, rate, delay in periods
GRID = list(itertools.product((0.02, 0.2), (0.0, 1.0), (0.2, 1.0), (500.0, 2000.0), (0.0, 2.5)))


def test_one_percent_inside_decays_and_outside_grows_over_the_grid():
    """The grid has 32 loops; the growth rate is that of the dominant roots."""
    for mass, damping, viscous, rate, late in GRID:
        given = {"mass": mass, "damping": damping, "viscous": viscous, "rate": rate, "delay": late / rate}
        case = SPRING.case(given)
        limit = SPRING.limit(case)
        for part in (0.99, 1.01):
            found = SPRING.probe(part * limit, case)
            assert found.holds == (part < 1.0), given
            want = spring.exact(case, part * limit).real
            assert found.measure == pytest.approx(want, rel=0.02, abs=2e-4), given


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_one_percent_inside_decays_and_outside_grows_with_every_filter(estimator):
    for late, damping in ((0.0, 0.5), (0.0, 3.0), (1.0, 0.5), (1.0, 3.0)):
        case = FILTERS.case({"estimator": estimator, "damping": damping, "delay": late * 1e-3})
        assert FILTERS.probe(FILTERS.inside(case), case).holds, (late, damping)
        assert not FILTERS.probe(FILTERS.outside(case), case).holds, (late, damping)


def test_filtered_damping_lowers_the_stable_stiffness():
    """The limit is 1002 N/m without virtual damping, and 760 N/m with 1 N·s/m.

    The handle has 0.05 kg and 0.5 N·s/m; the filter is a Butterworth filter of 20 Hz at 1 kHz.
    """
    case = FILTERS.case({"estimator": "butterworth_20", "damping": 1.0, "mass": 0.05})
    assert FILTERS.limit(case) == pytest.approx(760.0, abs=0.5)
    plain = FILTERS.case({"estimator": "butterworth_20", "damping": 0.0, "mass": 0.05})
    assert FILTERS.limit(plain) == pytest.approx(1001.7, abs=0.5)
    given = {"mass": 0.05, "stiffness": 900.0}
    assert WORSE.try_at(0.0, given).holds
    assert not WORSE.try_at(0.6, given).holds
    unfiltered = FILTERS.case({"estimator": "difference", "damping": 0.6, "mass": 0.05})
    assert FILTERS.probe(900.0, unfiltered).holds


def test_a_case_without_limit_is_reported():
    """No damping stabilises 5,000 N/m; a handle of 1 kg is stable with any damping."""
    for given, limit, text in (
        ({"stiffness": 5000.0}, 0.0, "every value fails"),
        ({"mass": 1.0}, math.inf, "every value works"),
    ):
        assert WORSE.limit(WORSE.case(given)) == limit
        with pytest.raises(ParameterError, match=text):
            show(WORSE, given)
