"""A program for the simulated chip that is asked with two words and answers with one."""

import subprocess

import numpy as np

from hapkit_studio.devices.virtual_board import VirtualBoard
from tests.firmware.test_firmware import SKETCH
from tests.firmware.vb import Host


def chip(folder, compiler, *words):
    """Yield a function that calculates in the chip: (n,) float32 with (n,) float32."""
    elf, still = folder / "chip.elf", folder / "still.txt"
    still.write_text("0 freeze")
    flags = ["-mmcu=atmega328p", "-DF_CPU=16000000UL", "-Os", "-o", elf]
    own = (SKETCH / "float_avr.S", SKETCH / "compare_avr.S")
    subprocess.run([compiler, *flags, *words, *own], check=True)
    board = VirtualBoard("fast", firmware=elf, script=still)
    board.start()
    host = Host(board.port)
    board.send("resume")
    assert host.read(1) == b"R"

    def product(a, b):
        out = []
        for x, y in zip(a.tobytes().hex(" ", 4).split(), b.tobytes().hex(" ", 4).split(), strict=True):
            host.write(bytes.fromhex(x))
            assert host.read(1) == b"A"
            host.write(bytes.fromhex(y))
            out.append(host.read(4))
        return np.frombuffer(b"".join(out), np.float32)

    yield product
    host.close()
    board.end()
