"""The cat's mood: what it likes by the way and the pace, and the same story every time."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.hand import GRIPS, SCRIPTS, Hand
from tests.environments.cat_runs import RESTED, column, contented, moved

STROKE = {"pet": 1.2, "rub": 0.3}  # s from one end to the other


def grown(gain, speed, start, seconds):
    """Solve dc/dt = gain speed - c / 10 s."""
    return start * math.exp(-seconds / 10.0) + 10.0 * gain * speed * -math.expm1(-seconds / 10.0)


# speed in m/s along the nap, contentment per metre of an easy cat
BANDS = [
    (0.05, 3.0), (0.0099, 0.0), (0.0101, 3.0), (0.099, 3.0), (0.101, 0.0), (0.2475, 0.0), (0.2525, -3.5),
    (-0.05, -0.8), (-0.0099, -0.8), (-0.099, -0.8), (-0.101, -3.5), (-0.2475, -3.5), (-0.2525, -3.5),
    (0.0015, 0.0), (-0.0015, 0.0), (1.0, -3.5),
]  # fmt: skip


@pytest.mark.parametrize(
    ("temper", "liking", "dislike"), [("easy", 1, 1), ("choosy", 0.8, 1.25), ("grumpy", 0.7, 1.5)]
)
@pytest.mark.parametrize(("speed", "gain"), BANDS)
def test_mood_goes_by_the_way_and_by_the_pace(speed, gain, temper, liking, dislike):
    """After 0.15 s at one speed nothing is left of how it began."""
    seconds = 0.15 + min(0.5, 0.05 / abs(speed))
    run = moved(lambda t: speed * t, seconds + 1e-3, temperament=temper)
    c = column(run, "contentment")
    scaled = gain * (liking if gain > 0.0 else dislike)
    assert c[-1] == pytest.approx(grown(scaled, abs(speed), c[150], run.time[-1] - run.time[150]), abs=2e-5)


def test_left_alone_it_forgets_in_ten_seconds():
    run = moved(contented, RESTED + 10.0)
    c = column(run, "contentment")[round(RESTED * 1000) :]
    assert c[0] > 0.4
    assert np.log(c / c[0]) == pytest.approx(-np.arange(c.size) * 1e-4, abs=1e-3)


@pytest.mark.parametrize("counts", [1, 2, 20])
@pytest.mark.parametrize("every", [2, 7])
def test_a_hand_that_rests_is_felt_as_rest_whatever_the_sensor_flickers(counts, every):
    """Back and forth by a few counts: 20 of them at 1 kHz would be 20 cm/s, on the way 4 m in 20 s."""

    def flickering(t):
        ticks = np.round(np.asarray(t) * 1000.0)
        return contented(t) + 20.7e-6 * counts * (np.fmod(ticks, every) == 0.0)

    still, shaken = (moved(p, RESTED + 5.0) for p in (contented, flickering))
    a, b = (column(run, "contentment")[round(RESTED * 1000) :] for run in (still, shaken))
    assert b[-1] / b[0] == pytest.approx(a[-1] / a[0], abs=4e-3)


@pytest.mark.parametrize("grip", ["light", "firm"])
def test_its_own_purr_is_no_hand(grip):
    g = GRIPS[grip]
    hand = Hand(g.mass, g.damping, g.stiffness, contented, vectorised=True)
    run = hs.simulate("cat", hand=hand, seconds=RESTED + 1.2)
    c = column(run, "contentment")[round(RESTED * 1000) :]
    assert c[0] > 0.35
    assert np.ptp(run.true_position[-500:]) > 20e-6
    assert c[1000] / c[0] == pytest.approx(math.exp(-0.1), abs=1e-3)


LOOPS = [(500.0, 0.0), (1000.0, 0.0), (1000.0, 0.5e-3), (1000.0, 1e-3), (2000.0, 0.5e-3), (4000.0, 0.0)]
EVERY_LOOP = [(r, d, e) for r, d in LOOPS for e in ("difference", "iir")]


def strokes(run, hand):
    """Return for each sample how many times the hand had been there and back, from the head on."""
    return (run.time - STROKE[hand] / 2) / (2 * STROKE[hand])


@pytest.mark.parametrize(("rate", "delay", "estimator"), EVERY_LOOP)
def test_it_purrs_by_the_fourth_pet(rate, delay, estimator):
    run = hs.simulate("cat", hand="pet", rate=rate, delay=delay, estimator=estimator, seconds=15.0)
    assert run.faults == ()
    purring = column(run, "phase") != 0.0
    assert 2.0 < strokes(run, "pet")[purring.argmax()] < 4.0
    assert strokes(run, "pet")[purring.argmax()] == pytest.approx(3.35, abs=0.05)
    assert purring[strokes(run, "pet") > 5.0].mean() > 0.95
    assert not column(run, "swat").any()


@pytest.mark.parametrize(("rate", "delay", "estimator"), EVERY_LOOP)
def test_it_swats_at_the_third_rub(rate, delay, estimator):
    run = hs.simulate("cat", hand="rub", rate=rate, delay=delay, estimator=estimator, seconds=5.0)
    assert run.faults == ()
    swatting = column(run, "swat") > 0.0
    assert 2.0 < strokes(run, "rub")[swatting.argmax()] < 3.0
    assert strokes(run, "rub")[swatting.argmax()] == pytest.approx(2.81, abs=0.05)
    assert np.count_nonzero(np.diff(swatting.astype(int)) > 0) == 1
    assert not column(run, "phase").any()


@pytest.mark.parametrize(
    ("temper", "purrs", "swats"), [("easy", 4, 3), ("choosy", 8, 2), ("grumpy", None, 2)]
)
def test_temper_is_a_matter_of_how_much_it_takes(temper, purrs, swats):
    pets = hs.simulate("cat", {"temperament": temper}, hand="pet", seconds=30.0)
    rubs = hs.simulate("cat", {"temperament": temper}, hand="rub", seconds=3.0)
    purring, swatting = column(pets, "phase") != 0.0, column(rubs, "swat") > 0.0
    first = math.ceil(strokes(pets, "pet")[purring.argmax()]) if purring.any() else None
    assert first == purrs
    assert math.ceil(strokes(rubs, "rub")[swatting.argmax()]) == swats


def test_even_a_grumpy_cat_purrs_for_a_hand_just_below_10_cm_per_second():
    for faster, purrs in ((1.8, True), (2.05, False)):  # times 5 cm/s
        run = moved(lambda t, k=faster: SCRIPTS["pet"].target(k * t), 20.0, temperament="grumpy")
        assert column(run, "phase").any() == purrs


def test_it_sulks_for_five_seconds_and_no_stroke_pleases_it():
    def rub_then_pet(t):
        return SCRIPTS["rub"].target(np.minimum(t, 2.1)) + SCRIPTS["pet"].target(np.maximum(t - 2.1, 0.0))

    run = moved(rub_then_pet, 24.0)
    sulk, c = column(run, "sulk"), column(run, "contentment")
    assert (sulk > 0.0).sum() == pytest.approx(5000, abs=2)
    assert sulk.max() == 5.0
    sulking = np.flatnonzero(sulk > 0.0)
    assert np.diff(c[sulking]).max() < 5e-5 + 1e-4 * 0.9
    assert c[sulking[0]] < -0.4
    assert c[sulking[-1]] < 0.0
    assert c[-1] > 0.3
    assert np.count_nonzero(np.diff((column(run, "swat") > 0.0).astype(int)) > 0) == 1


def test_rubbed_on_it_swats_again_when_it_has_sulked_long_enough():
    run = moved(SCRIPTS["rub"].target, 14.0)
    begins = run.time[1:][np.diff((column(run, "swat") > 0.0).astype(int)) > 0]
    assert len(begins) == 3
    assert np.all(np.diff(begins) >= 5.3 - 2e-3)
    assert np.all(np.diff(begins) < 5.3 + 0.7)


def test_left_alone_it_does_not_swat_however_cross_it_is():
    def rubbed_for_long(t):
        flicker = 20.7e-6 * (np.fmod(np.round(np.asarray(t) * 1000.0), 2.0) == 0.0)
        return SCRIPTS["rub"].target(np.minimum(t, 6.45)) + flicker

    run = moved(rubbed_for_long, 12.0)
    over = (run.time > 6.5) & (column(run, "sulk") == 0.0)
    assert column(run, "contentment")[over][0] < -0.7
    assert column(run, "swats")[-1] == 1.0
