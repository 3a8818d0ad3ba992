"""Numbers and units are formatted for people."""

import json
import math
import re
from importlib.resources import files
from pathlib import Path

import pytest

from hapkit_studio.analysis.stability.behaviour import Behaviour, Lasting
from hapkit_studio.formatting import (
    compact,
    hertz,
    interval,
    number,
    on_screen,
    power_of_ten,
    printable,
    quoted,
    shortened,
    significant,
    tick_labels,
    unbroken,
    with_unit,
)


def test_numbers_have_a_true_minus_thousands_separators_and_no_sign_on_zero():
    assert number(-1.234, 2) == "−1.23"
    assert number(-0.001, 2, sign=True) == "0.00"
    assert number(7.25, 2, sign=True) == "+7.25"
    assert number(1000.0, 0) == "1,000"
    assert number(-37, 0) == "−37"
    assert number(math.inf, 2) == "inf"


def test_significant_digits_are_kept_without_an_exponent():
    numbers = (0.0, 3.24, 32.4, 324.0, 9.96, -0.00123, 123_456.0, math.nan)
    assert [significant(x) for x in numbers] == ["0", "3.2", "32", "324", "10", "−0.0012", "123,456", "–"]
    assert significant(0.5, 3) == "0.500"


@pytest.mark.parametrize(
    ("frequency", "text"), [(13.51, "13.5 Hz"), (19.94, "19.9 Hz"), (19.96, "20 Hz"), (133.6, "134 Hz")]
)
def test_low_frequencies_have_a_decimal(frequency, text):
    assert hertz(frequency) == text
    swing = Lasting(2e-3, frequency)
    assert Behaviour(0.0, swing, swing, (frequency, frequency)).swing == f" at {text} (±2 mm)"


def test_very_small_or_large_values_are_powers_of_ten():
    assert [power_of_ten(x) for x in (2e-6, 2180.0, -3e-12)] == ["2 × 10⁻⁶", "2 × 10³", "−3 × 10⁻¹²"]
    assert [power_of_ten(x, 3) for x in (1e-6, -1e7, 2.504e8)] == ["10⁻⁶", "−10⁷", "2.5 × 10⁸"]
    numbers = (600.0, 1e0, 1e4, 999_999.0, 1e6, 1.5e6, 1e-4, 1e-5, -0.25, 0.0)
    texts = ["600", "1", "10,000", "999,999", "10⁶", "1.5 × 10⁶", "0.0001", "10⁻⁵", "−0.25", "0"]
    assert [compact(x) for x in numbers] == texts
    assert [compact(x, 2, sign=True) for x in (1234.0, -1e-9, 0.0)] == ["+1,200", "−10⁻⁹", "0"]


def test_texts_for_people_are_rounded_by_these_functions_only():
    """In these folders, an f-string may have a precision (such as ".3g") only if the text is parsed again."""
    own = Path(str(files("hapkit_studio")))
    found = []
    for folder in ("gui", "analysis", "charts", "environments", "commands", "haptics"):
        for path in (own / folder).rglob("*.py"):
            for row, line in enumerate(path.read_text("utf-8").splitlines(), 1):
                if re.search(r"\{[^{}]+:[+,]*\.\d+[ge]\}", line) and "float(f" not in line:
                    found.append(f"{path.relative_to(own)}:{row}: {line.strip()}")
    assert found == []


def test_an_interval_is_never_shown_as_exact():
    assert interval(-600.0, 1e-14, 1) == "−600.0 ± 0.1"
    assert interval(-1600.04, 12.3, 0) == "−1,600 ± 12"


def test_tick_labels_have_a_true_minus_and_the_decimals_of_their_distance():
    assert tick_labels([-0.5, 0.0, 0.5]) == ["−0.5", "0.0", "0.5"]
    assert tick_labels([-100.0, 0.0, 100.0]) == ["−100", "0", "100"]
    assert tick_labels([-20000.0, 0.0, 20000.0]) == ["−20,000", "0", "20,000"]
    assert tick_labels([1234.5, 1235.0]) == ["1,234.5", "1,235.0"]
    assert tick_labels([0.0, 2.5, 5.0]) == ["0.0", "2.5", "5.0"]
    assert tick_labels([0.0, 0.1, 0.2, 0.1 + 0.2]) == ["0.0", "0.1", "0.2", "0.3"]
    assert tick_labels([-0.01, 0.0, 0.0025]) == ["−0.0100", "0.0000", "0.0025"]
    assert tick_labels([1e-13, 1.0]) == ["0", "1"]
    assert tick_labels([]) == []
    assert tick_labels([0.25, 0.5, 0.75]) == ["0.25", "0.50", "0.75"]
    assert tick_labels([0.0, 2.5, 5.0]) == ["0.0", "2.5", "5.0"]
    assert tick_labels([0.7, 0.8, 0.9]) == ["0.7", "0.8", "0.9"]


def test_units_follow_the_number_and_length_and_time_use_display_units():
    assert with_unit(0.5, "N") == "0.5 N"
    assert with_unit(-1234.56, "N/m") == "−1,230 N/m"
    assert with_unit(2.0, "N", sign=True) == "+2 N"
    assert with_unit(2.0) == "2"
    assert on_screen(0.0123456, "m") == "12.35 mm"
    assert on_screen(0.004, "s") == "4 ms"
    assert on_screen(12.0, "s") == "12 s"


def test_a_number_stays_on_the_line_of_its_unit_and_other_words_may_wrap():
    text = "Calm, 36 × below the limit of 1,002 N/m at 2 N·s/m, 5 mm and 30 % in 4 more steps, 10 mixed."
    assert unbroken(text) == (
        "Calm, 36\u00a0×\u00a0below\u00a0the\u00a0limit of 1,002\u00a0N/\u2060m at 2\u00a0N·s/\u2060m, "
        "5\u00a0mm and 30\u00a0% in 4 more steps, 10 mixed."
    )
    assert unbroken("5.5 JND, 0.06 1/s, 0.01 m²/s³") == (
        "5.5\u00a0JND, 0.06\u00a01/\u2060s, 0.01\u00a0m²/\u2060s³"
    )
    assert unbroken("either/or, 9.8 m/s² in /media/sound") == "either/or, 9.8\u00a0m/\u2060s² in /media/sound"


HIDDEN = "a\x1b[2K\r\u202eb\u200b\x9b\x7f\0\t\ud800\U000e0001c"


def test_no_control_or_invisible_character_is_printed():
    shown = printable(f"{HIDDEN}\nN·s/m −\u00a0Zoë\n")
    escaped = r"a\u001b[2K\r\u202eb\u200b\u009b\u007f\u0000\t\ud800\udb40\udc01c"
    assert shown == f"{escaped}\nN·s/m −\u00a0Zoë\n"


def test_a_printable_json_text_has_the_same_value():
    value = {HIDDEN: [HIDDEN, "\\x1b", 1.5]}
    shown = printable(json.dumps(value, ensure_ascii=False))
    assert shown.isprintable()
    assert json.loads(shown) == value


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        ("a" * 40, "a" * 40),
        ("a" * 41, "a" * 40 + "…"),
        ("9" * 5000, "9" * 40 + "…"),
        ("\x1b[31m", "\\u001b[31m"),
        ("\x1b" * 7, "\\u001b" * 6 + "\\u00…"),
    ],
)
def test_a_foreign_text_is_printable_and_at_most_40_characters_in_a_message(value, wanted):
    assert shortened(value) == wanted


def test_a_foreign_value_is_quoted_like_pythons_repr_and_shortened():
    assert quoted("two") == "'two'"
    assert quoted([1, "x"]) == "[1, 'x']"
    assert quoted("a" * 38) == "'" + "a" * 38 + "'"
    assert quoted("a" * 39) == "'" + "a" * 39 + "…"
    assert quoted(10**5000) == "a very long number"
