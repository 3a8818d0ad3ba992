"""The search for the stiffest wall: how far it goes, how near it comes, what it never tries."""

import pytest

from hapkit_studio.analysis.zwidth.result import BUZZES, HIGHEST, TrialOutcome, stiffest


def up_to(limit, tried, clamped_from=float("inf")):
    def held(stiffness):
        tried.append(stiffness)
        return TrialOutcome(BUZZES if stiffness > limit else "", stiffness >= clamped_from)

    return held


@pytest.mark.parametrize("limit", [200.0, 201.0, 700.0, 999.0])
def test_it_comes_within_what_the_halvings_leave(limit):
    tried = []
    found = stiffest(up_to(limit, tried), 200.0, 1.3, 1e6, 14)
    assert 0.0 <= limit - found.stiffness <= 0.3 * limit / 2**14
    assert found.ended == BUZZES


def test_it_never_tries_beyond_the_first_that_fails():
    tried = []
    stiffest(up_to(500.0, tried), 200.0, 1.3, 1e6, 8)
    first = next(i for i, k in enumerate(tried) if k > 500.0)
    assert all(k < tried[first] for k in tried[first + 1 :])
    assert len(tried) == first + 9


def test_it_goes_below_the_softest():
    found = stiffest(up_to(30.0, []), 200.0, 1.3, 1e6, 14)
    assert found.stiffness == pytest.approx(30.0, abs=200.0 / 2**14)


def test_nothing_holds():
    found = stiffest(lambda k: TrialOutcome(BUZZES), 200.0, 1.3, 1e6, 14)
    assert found.stiffness == 0.0


def test_it_ends_at_the_highest():
    tried = []
    found = stiffest(up_to(1e9, tried, clamped_from=900.0), 200.0, 2.0, 1000.0, 5)
    assert tried == [200.0, 400.0, 800.0, 1000.0]
    assert (found.stiffness, found.ended, found.clamped) == (1000.0, HIGHEST, True)


def test_the_clamp_of_a_wall_that_failed_does_not_count():
    found = stiffest(up_to(500.0, [], clamped_from=501.0), 200.0, 1.3, 1e6, 8)
    assert not found.clamped
