"""The cat's mood is a reproducible function of the strokes' direction and speed."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.hand import SCRIPTS
from hapkit_studio.environments import cat
from tests.environments.calling import column, imposed
from tests.wide import wide

STROKE = {"pet": 1.2, "rub": 0.3}  # duration in s of a stroke from one end to the other


def grown(gain, speed, start, seconds):
    """Return the contentment c after some seconds at one speed in m/s.

    If c is positive and the speed exceeds 3 mm/s, dc/dt = gain speed; else dc/dt = gain speed - c / 10 s.
    """
    if start > 0.0 and speed > 0.003:
        return start + gain * speed * seconds
    return start * math.exp(-seconds / 10.0) + 10.0 * gain * speed * -math.expm1(-seconds / 10.0)


# columns: speed in m/s in the direction of the fur (the nap), change of an easy cat's contentment per metre
BANDS = [
    (0.05, 3.0), (0.00495, 0.0), (0.00505, 3.0), (0.1188, 3.0), (0.1212, 0.0), (0.1386, 0.0),
    (0.1414, -3.5), (0.2, -3.5), (-0.05, -0.8), (-0.0099, -0.8), (-0.1188, -0.8), (-0.1212, -3.5),
    (-0.2475, -3.5), (-0.2525, -3.5),
    (0.0015, 0.0), (-0.0015, 0.0), (1.0, -3.5),
]  # fmt: skip


@pytest.mark.parametrize(
    ("temper", "liking", "dislike"),
    wide(
        [("easy", 1, 1), ("choosy", 0.8, 1.25), ("grumpy", 0.7, 1.5)], lambda temper, *_: temper == "grumpy"
    ),
)
@pytest.mark.parametrize(("speed", "gain"), BANDS)
def test_mood_depends_on_distance_and_speed(speed, gain, temper, liking, dislike):
    """The mood is read after 0.15 s at one speed, when the initial state has no effect any more."""
    seconds = 0.15 + min(0.5, 0.05 / abs(speed))
    run = moved(lambda t: speed * t, seconds + 1e-3, temperament=temper)
    c = column(run, "contentment")
    scaled = gain * (liking if gain > 0.0 else dislike)
    assert c[-1] == pytest.approx(grown(scaled, abs(speed), c[150], run.time[-1] - run.time[150]), abs=2e-5)


def test_left_alone_the_mood_decays_in_ten_seconds():
    run = moved(contented, RESTED + 10.0)
    c = column(run, "contentment")[round(RESTED * 1000) :]
    assert c[0] > 0.4
    assert np.log(c / c[0]) == pytest.approx(-np.arange(c.size) * 1e-4, abs=1e-3)


@pytest.mark.parametrize(("speed", "content"), [(0.05, True), (0.1, True), (0.15, False), (0.2, False)])
def test_it_purrs_when_stroked_slowly_to_and_fro_and_swats_in_haste(speed, content):
    period = 0.12 / speed  # the strokes are 60 mm long, at a constant speed

    def position(t):
        share = t / period % 1.0
        return 0.12 * min(share, 1.0 - share) - 0.03

    run = moved(position, 12.0)
    assert (column(run, "contentment").max() > cat.PURRS_ABOVE) == content
    assert (column(run, "swats")[-1] > 0) == (not content)


LOOPS = [(500.0, 0.0), (1000.0, 1e-3), (4000.0, 0.0)]
EVERY_LOOP = wide(
    ((r, d, e) for r, d in LOOPS for e in ("difference", "iir")),
    lambda rate, delay, estimator: rate == 1000.0,
)


def strokes(run, hand):
    """Return the number of cycles (one stroke to and fro) at each sample, counted from the head."""
    return (run.time - STROKE[hand] / 2) / (2 * STROKE[hand])


@pytest.mark.parametrize(("rate", "delay", "estimator"), EVERY_LOOP)
def test_it_purrs_by_the_third_pet(rate, delay, estimator):
    """The purr starts 31.3 mm into the third cycle of 120 mm, where the contentment reaches 0.3.

    The target moves 60 mm per stroke, but the hand 55 mm, because at the ends it lags by
    0.35 or 0.63 N over 200 N/m. Two cycles give 2 (3.0 - 0.8) per metre times 55 mm, less 0.8 per metre times
    27 mm at the start, which is 0.22. The rest takes 26 mm at 3.0 per metre, and the hand starts the third
    stroke 5 mm late.
    """
    run = hs.simulate("cat", hand="pet", rate=rate, delay=delay, estimator=estimator, seconds=15.0)
    assert run.faults == ()
    purring = column(run, "phase") != 0.0
    assert strokes(run, "pet")[purring.argmax()] == pytest.approx(2.0 + 31.3 / 120.0, abs=0.05)
    assert purring[strokes(run, "pet") > 5.0].mean() > 0.95
    assert not column(run, "swat").any()


@pytest.mark.parametrize(("rate", "delay", "estimator"), EVERY_LOOP)
def test_it_swats_at_the_second_rub(rate, delay, estimator):
    run = hs.simulate("cat", hand="rub", rate=rate, delay=delay, estimator=estimator, seconds=5.0)
    assert run.faults == ()
    swatting = column(run, "swat") > 0.0
    # Rubbing changes the contentment by −3.5 per metre. The hand moves 27 mm to the head and then 55 mm per
    # stroke, so the contentment reaches −0.5, at which the cat swats, after 1.1 cycles. The swat comes later,
    # because near the ends the hand is slower than FAST and ROUGH.
    assert 1.1 < strokes(run, "rub")[swatting.argmax()] < 1.4
    assert np.count_nonzero(np.diff(swatting.astype(int)) > 0) == 1
    assert not column(run, "phase").any()


def test_it_sulks_for_five_seconds_whatever_the_stroke():
    def rub_then_pet(t):
        return SCRIPTS["rub"].target(np.minimum(t, 1.2)) + SCRIPTS["pet"].target(np.maximum(t - 1.2, 0.0))

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


def test_left_alone_it_never_swats():
    def rubbed_for_long(t):
        flicker = 20.7e-6 * (np.fmod(np.round(np.asarray(t) * 1000.0), 2.0) == 0.0)
        return SCRIPTS["rub"].target(np.minimum(t, 5.85)) + flicker

    run = moved(rubbed_for_long, 12.0)
    over = (run.time > 5.9) & (column(run, "sulk") == 0.0)
    assert column(run, "contentment")[over][0] < -0.7
    assert column(run, "swats")[-1] == 1.0


@pytest.mark.parametrize("frequency", wide([20.0, 26.3, 30.0], lambda hertz: hertz == 26.3))
def test_the_purr_is_higher_and_louder_while_breathing_out(frequency):
    run = moved(contented, RESTED + 4.0, purr_frequency=frequency, purr_force=1.0, hair=0.0)
    rest = slice(round(RESTED * 1000), None)
    out = column(run, "breath")[rest] < math.pi
    c = column(run, "contentment")[rest]
    hum = (run.force[rest] - -0.35) / c
    for breathing, pitch, strength in ((out, frequency + 1.2, 1.2), (~out, frequency - 1.2, 0.8)):
        first = np.flatnonzero(np.diff(breathing.astype(int)) > 0)[0] + 1
        part = hum[first : first + 1200]
        assert breathing[first : first + 1200].all()
        rising = np.flatnonzero((part[:-1] < 0.0) & (part[1:] >= 0.0))
        exact = rising - part[rising] / (part[rising + 1] - part[rising])
        assert 1000.0 / np.diff(exact).mean() == pytest.approx(pitch, rel=2e-3)
        assert np.abs(part).max() == pytest.approx(strength, rel=0.02)


def test_the_theory_curve_is_a_slow_stroke():
    """The curve has both branches with bent hair; the force of the tufts oscillates around them."""
    for branch, sign in ((0, 1.0), (1, -1.0)):
        quiet = {"fur_damping": 0.0, "purr_force": 0.0, "nap_ratio": 2.5}
        run = moved(lambda t, sign=sign: sign * (-0.02 + 0.005 * t), 6.0, **quiet)
        ripple = 0.06 * np.sin(2.0 * np.pi * run.position / 0.003)
        theory = cat.over_position(cat.ENVIRONMENT.values({"nap_ratio": 2.5}), run.position)
        assert theory.shape == (2, run.position.size)
        assert run.force[2000:] - ripple[2000:] == pytest.approx(theory[branch, 2000:], abs=1e-9)
        assert theory[branch, 0] == (-0.35, 0.875)[branch]


def test_tufts_are_3_mm_apart_and_six_hundredths_of_a_newton():
    run = moved(lambda t: 0.005 * t, 6.0, fur_friction=0.0, fur_damping=0.0, purr_force=0.0)
    assert run.force == pytest.approx(0.06 * np.sin(2.0 * np.pi * run.position / 0.003), abs=1e-12)


def test_the_swat_is_one_push_against_the_hands_motion():
    """The swat is the force minus the force of the fur: a push of 0.3 s and at most 1.5 N."""
    for sign in (1.0, -1.0):  # the first stroke is too fast with the nap, the second is fast against it
        run = moved(lambda t, s=sign: s * np.minimum(0.26 * t, 0.2), 1.5, purr_force=0.0, hair=0.0)
        fur = np.clip(run.force + 1.5 * run.velocity, -0.35, 0.63)
        push = run.force + 1.5 * run.velocity - fur
        swat = column(run, "swat")
        assert (swat > 0.0).sum() == pytest.approx(300, abs=1)
        assert np.abs(push[swat == 0.0]).max() < 1e-9
        assert 1.4 < np.abs(push).max() <= 1.5 + 1e-9
        assert np.all(sign * push[swat > 0.0] <= 1e-9)


def test_the_fur_is_passive():
    """The energy given by the device never exceeds the energy stored in bent hair and tufts."""
    run = hs.simulate("cat", {"purr_force": 0.0}, hand="pet", seconds=10.0)
    stored = (0.35 * 1.8) ** 2 / (2.0 * cat.FUR_STIFFNESS) + 0.06 * 0.003 / math.pi
    assert run.energy.max() <= stored
    assert run.energy[-1] < -0.1


def moved(position, seconds, **values):
    """Return the run of a handle that moves along position(t) whatever the cat's force is."""
    return imposed("cat", values, position, seconds)


def contented(t):
    """Return a path of 5.5 cycles that the cat likes. After a last stroke along the nap, the hand rests."""
    return SCRIPTS["pet"].target(np.minimum(t, 0.6 + 11 * 1.2))


RESTED = 0.6 + 11 * 1.2 + 0.2  # time in s at which the handle has rested long enough
