"""The law language in C++: a person's own laws, built with the board's others, give what Python gives."""

import zlib

import numpy as np
import pytest

from hapkit_studio.laws import firmware
from hapkit_studio.workshop import firmware as written
from hapkit_studio.workshop import reading
from tests.laws import board_laws
from tests.laws.board_laws import ENVIRONMENTS, Job, needs_compiler

HEAD = """
import math

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter

FAR = 1e100
TINY = 1e-60


def both(a, b):
    return a + b, a - b


def flag(a):
    return 1.0 if a > 0.5 else 0.0


def stepped(double, λ):
    for i in range(3, -1, -1):
        double += i * λ
        if double > 2.0:
            break
    return double


"""
TAIL = """

ENVIRONMENT = Environment(
    key="own_law", title="Own", summary="Own",
    parameters=(Parameter("gain", "Gain", "", 2.5, -5.0, 5.0), Choice("kind", "Kind", ("a", "b", "c"), "b")),
    force=force,
)
"""
LAWS = {
    "division": "return x // 0.3 + x % 0.3 + (-x) % 0.7 + x % -0.4 + (x // -0.25)",
    "powers": "return x ** 2 + abs(x) ** 0.5 + x ** 3.0 - 2.0 ** v",
    "extremes": "return min(x, v, p.gain) - max(x, 0.1) + max(min(v, 0.2), -0.2)",
    "logic": (
        "a = x > 0.0 and v > 0.0\n    b = x or v\n    c = x and p.gain\n    return a + b + c + (not a)"
    ),
    "chain": "return 1.0 if -0.2 < x <= 0.3 != v else -1.0",
    "whole": "return int(x * 9.0) + math.floor(x * 9.0) + math.ceil(v * 9.0) + float(x > v)",
    "options": 'return 1.0 if p.kind == "b" else 2.0 if p.kind != "c" else 3.0',
    "several": "a, b = both(x, v)\n    a, b = b, a\n    return a - 2.0 * b",
    "loops": (
        "n = 0.0\n"
        "    for i in range(5):\n"
        "        if i == 3:\n"
        "            continue\n"
        "        n += i * x\n"
        "    return n"
    ),
    "helper": "return stepped(x, v) + flag(x)",
    "signs": (
        "side = 1.0 if x < 0.0 else -1.0\n    return side * (x - side * 0.3) * 0.5 - math.copysign(v, -x)"
    ),
    "names": "new = x\n    F = v\n    double = new + F\n    max_ = double\n    return max_ * 2.0",
    "state": (
        "s.sum += x\n"
        "    s.row[1] = v\n"
        "    s.row[s.at] = s.row[1] + x\n"
        "    s.at = 1.0 - s.at\n"
        "    return s.sum + s.row[0]"
    ),
    "functions": (
        "return math.sin(9.0 * x) + math.exp(v) + math.tanh(x) + math.sqrt(abs(x)) + math.atan2(x, v + 2.0)"
    ),
    "turns": "return math.cos(math.tau * x * 3.0) + math.sin(2.0 * math.pi * x / 0.07)",
    "ends": "return min(x, FAR) + TINY * x + (0.0 if x < FAR else 1.0)",
    "unused": "a = x * v\n    return x",
}
STATE = '@law(state={"sum": 0.5, "row": (0.0, 1.0, 2.0), "at": 0.0})\n'
FAULTS = {
    "zero": "return 1.0 if 1.0 / (p.gain - p.gain) > 0.0 else 2.0",
    "parameter": "return 1.0 if x / (p.gain * 0.0) > 0.0 else 2.0",
    "rest": "return 1.0 if math.fmod(x, 0.0 * v) > 0.0 else 2.0",
    "index": "return 1.0 if s.row[x * 1000.0 + 3.0] > 0.0 else 2.0",
    "turns": (
        "n = 0.0\n    for i in range(100):\n        for j in range(100):\n            n += 1e-9\n    return n"
    ),
    "root": "return math.sqrt(-1.0 - abs(x))",
}


def own(folder, body):
    """Return a file with an environment whose law has this body."""
    decorator = STATE if "s." in body else "@law\n"
    file = folder / f"own_{zlib.crc32(body.encode())}.py"
    file.write_text(f"{HEAD}{decorator}def force(p, s, x, v, dt):\n    {body}\n{TAIL}", encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    """Return what a law's body gives: (environment, rows, board's force and state), all built at once."""
    folder = tmp_path_factory.mktemp("own")
    made, found = {}, {}
    for name, body in [*LAWS.items(), *((f"fault_{n}", b) for n, b in FAULTS.items())]:
        made[f"own_{name}"] = reading.load(own(folder, body))
    firmware.write(
        written.by_hand() | firmware.headers({k: e.force for k, e in made.items()}), folder / "hapkit"
    )
    driver = folder / "driver"
    words = ["make", "-s", "-C", board_laws.FOLDER, f"BUILD={folder}", f"SKETCH={folder / 'hapkit'}", driver]
    board_laws.subprocess.run(words, check=True)
    rng = np.random.default_rng(20241108)
    rows = np.float32(rng.uniform(-1.0, 1.0, (300, 2))).astype(float)
    jobs = [Job(e, e.values(), 1e-3, rows, number=n) for n, e in enumerate(made.values())]
    for key, job, answer in zip(made, jobs, board_laws.run(driver, jobs), strict=True):
        found[key.removeprefix("own_")] = (job, *answer)
    return found


@needs_compiler
@pytest.mark.parametrize("name", LAWS)
def test_own_laws_give_what_python_gives(name, answers):
    job, force, after = answers[name]
    wanted, state = board_laws.by_python(job)
    assert np.isfinite(wanted).all()
    assert force == pytest.approx(wanted, abs=2e-5, rel=2e-6)
    assert after == pytest.approx(state, abs=2e-5, rel=2e-6)


@needs_compiler
@pytest.mark.parametrize("name", FAULTS)
def test_what_goes_wrong_is_no_number(name, answers):
    assert np.isnan(answers[f"fault_{name}"][1]).all()


def test_the_committed_laws_are_up_to_date():
    files = firmware.headers(written.laws())
    assert firmware.outdated(files, written.default_folder()) == []
    assert written.main(["--check"]) == 0


def test_a_change_of_the_law_is_another_fingerprint(tmp_path):
    one, other = (
        firmware.headers({"own": reading.load(own(tmp_path, f"return x * {k}")).force}) for k in (2, 3)
    )
    assert one["laws/own.h"] != other["laws/own.h"]
    marks = [text["laws/own.h"].split("kFingerprint = ")[1][:10] for text in (one, other)]
    assert marks[0] != marks[1]


def test_an_own_law_is_added_after_the_others(tmp_path):
    out = tmp_path / "hapkit"
    assert written.main(["--out", str(out), "--with", str(own(tmp_path, "return x"))]) == 0
    table = (out / "laws" / "table.h").read_text()
    places = [table.index(f"{{{key}::kKey, ") for key in (*ENVIRONMENTS, "own_law")]
    assert places == sorted(places)
    assert (out / "laws" / "moving.h").is_file()


def test_a_law_that_the_board_cannot_hold_is_said_so(tmp_path, capsys):
    file = own(tmp_path, "return x")
    file.write_text(file.read_text().replace("own_law", "a_key_that_is_far_too_long"))
    assert written.main(["--out", str(tmp_path / "out"), "--with", str(file)]) == 2
    assert "24 characters" in capsys.readouterr().err
