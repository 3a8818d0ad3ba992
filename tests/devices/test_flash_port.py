"""A port that somebody reads: flashing it would fail in a way that nobody understands."""

import os
import subprocess
import sys

import pytest

from hapkit_studio.devices import flash
from hapkit_studio.errors import PortBusyError


@pytest.mark.skipif(sys.platform != "linux", reason="Linux tells who has a port open")
def test_a_port_that_another_program_reads_without_a_lock_is_not_flashed():
    controller, port = os.openpty()
    path = os.ttyname(port)
    reader = subprocess.Popen(["sleep", "60"], stdin=port)
    os.close(port)
    try:
        with pytest.raises(PortBusyError, match=rf"is used by sleep \(process {reader.pid}\)"):
            flash.try_port(path)
    finally:
        reader.kill()
        reader.wait()
    flash.try_port(path)
    os.close(controller)
