"""A setting is checked once, and gives the loops and devices that are made of it."""

import math

import pytest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import ParameterError


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        ({"mass": 0.0}, "The mass goes from 1e-06 to 10000 kg, not 0."),
        ({"viscous": -0.1}, "The viscous damping goes from 0 to 100000 N·s/m, not -0.1."),
        ({"coulomb": math.nan}, "The Coulomb friction goes from 0 to 10000 N, not nan."),
        ({"quantum": "20 µm"}, "The sensor quantum takes a number in m, not '20 µm'."),
        ({"rate": 0}, "The rate goes from 1 to 1e+06 Hz, not 0."),
        ({"delay": math.inf}, "The delay goes from 0 to 10 s, not inf."),
        ({"estimator": "guess"}, "The velocity estimator is one of"),
        ({"hand": "glove"}, "The grip is one of released, light, medium, firm, not 'glove'."),
        ({"mass": True}, "The mass takes a number in kg, not True."),
        ({"mass": 1e300}, "The mass goes from 1e-06 to 10000 kg, not 1e+300."),
        ({"quantum": 1.0}, "The sensor quantum goes from 0 to 0.1 m, not 1."),
        ({"hand": []}, "The hand takes a grip's name, not []."),
        ({"delay": 0.0101, "rate": 2e5}, "A delay of 0.0101 s at 200000 Hz is 2020 periods; 2000 at most:"),
    ],
)
def test_refuses_what_no_loop_can_be(bad, says):
    with pytest.raises(ParameterError) as e:
        Setting(**bad)
    assert str(e.value).startswith(says)
    assert "\n" not in str(e.value)


def test_gives_loop_device_and_hand():
    setting = Setting(rate=500.0, delay=0.3e-3, estimator=("iir", {"cutoff": 20.0}), hand="firm")
    assert (setting.period, setting.loop.rate, setting.loop.delay) == (0.002, 500.0, 0.3e-3)
    assert setting.grip == GRIPS["firm"]
    assert Setting().grip is None
    ideal, real = setting.device(real=False, position=1e-3), setting.device(velocity=0.1)
    assert (ideal.coulomb_force, ideal.quantum, ideal.initial_position) == (0.0, 0.0, 1e-3)
    assert (real.coulomb_force, real.quantum, real.initial_velocity) == (0.10, 20.7e-6, 0.1)
    assert ideal.max_force == math.inf


def test_equal_settings_are_one_key_and_only_windows_are_not_linear():
    first, second = (Setting(estimator=("iir", {"cutoff": 20.0})) for _ in range(2))
    assert len({first: 0, second: 1}) == 1
    assert first.linear
    assert not Setting(estimator="foaw").linear
