"""The firmware builds and fits the chip, and its hardware-independent parts pass their own tests."""

import hashlib
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from hapkit_studio import resources
from hapkit_studio.devices import virtual_board
from tests.firmware.vb import opened

FIRMWARE = Path(__file__).resolve().parents[2] / "firmware"
SKETCH = FIRMWARE / "hapkit"
FREE = 250
"""Number of bytes of RAM that stay free at the deepest stack."""

needs_avr = pytest.mark.skipif(shutil.which("avr-g++") is None, reason="no avr-gcc")
needs_gcc = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")


def make(*arguments, folder=FIRMWARE):
    command = ["make", "-C", str(folder), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


BUILD = FIRMWARE / "build"


@pytest.fixture(scope="module")
def output():
    """Build the firmware; return the sizes that the build prints."""
    done = make()
    assert done.returncode == 0, done.stderr
    return done.stdout


def stack_counted():
    """Return the stack size in bytes that the build assumes."""
    return int(re.search(r"^STACK \?= (\d+)$", (FIRMWARE / "Makefile").read_text(), re.MULTILINE)[1])


def image(path):
    """Return the contents of the flash in an Intel hex file."""
    records = [bytes.fromhex(line[1:]) for line in path.read_text().split()]
    assert all(sum(r) % 256 == 0 for r in records)
    return b"".join(r[4 : 4 + r[0]] for r in records if r[3] == 0)


@pytest.mark.slow
@needs_gcc
def test_chip_independent_parts_pass_their_tests():
    done = make(f"BUILD={BUILD / 'tests'}", folder=FIRMWARE / "tests")
    assert done.returncode == 0, done.stdout + done.stderr
    count, failures = map(int, re.search(r"(\d+) tests, (\d+) failures", done.stdout).groups())
    assert count > 25
    assert failures == 0


@pytest.mark.slow
@needs_avr
def test_flash_and_ram_are_printed_and_fit(output):
    flash, flash_limit = map(int, re.search(r"flash (\d+) of (\d+) bytes", output).groups())
    pattern = r"RAM +(\d+) of (\d+) bytes, (\d+) of them the arena; the stack takes (\d+), (\d+) stay free"
    ram, ram_limit, arena, stack, free = map(int, re.search(pattern, output).groups())
    assert (flash_limit, ram_limit) == (24000, 2048)
    assert 1000 < flash <= flash_limit
    assert arena >= 600
    assert free == ram_limit - ram - stack >= FREE
    for limit in ("FLASH_LIMIT=1000", "RAM_LIMIT=100", "STACK=600"):
        assert make("sizes", limit).returncode != 0
    if virtual_board.built():
        with opened("fast", firmware=BUILD / "hapkit.elf") as board:
            assert board.hello.arena == arena


def test_the_prebuilt_firmware_belongs_to_these_sources():
    parts = (*SKETCH.glob("*.cpp"), *SKETCH.glob("*.S"), *SKETCH.rglob("*.h"), *SKETCH.glob("*.ino"))
    sources = sorted(parts, key=lambda p: p.relative_to(SKETCH).as_posix())
    fingerprint = hashlib.sha256(b"".join(p.read_bytes() for p in sources)).hexdigest()[:8]
    assert fingerprint.encode() in image(resources.path("firmware", "hapkit.hex"))


@needs_avr
def test_the_prebuilt_firmware_is_reproducible_with_its_compiler(output):
    recorded = resources.path("firmware", "made-with.txt").read_text()
    if make("-s", "--no-print-directory", "made-with").stdout != recorded:
        pytest.skip("another compiler than the prebuilt one's; test_vb_firmware.py looks at what it does")
    assert (BUILD / "hapkit.hex").read_bytes() == resources.path("firmware", "hapkit.hex").read_bytes()


def test_the_sketch_consists_of_setup_and_loop():
    text = (SKETCH / "hapkit.ino").read_text()
    assert re.findall(r"(\w+)\(\) \{", text) == ["setup", "loop"]
    assert len(text.splitlines()) < 10


def test_only_the_hardware_files_depend_on_the_chip():
    files = [p for p in SKETCH.rglob("*") if p.is_file()]
    knows = re.compile(r"#include <(avr|util)/(?!pgmspace)|Arduino\.h")
    chip = {p.name for p in files if knows.search(p.read_text())}
    assert {name for name in chip if not name.endswith("_avr.cpp")} == {"lock.h"}
