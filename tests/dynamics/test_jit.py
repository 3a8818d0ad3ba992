"""Where compiled code is kept when nothing may be written."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

ROOT = Path(__file__).parents[2]
REFUSE = """
import numba.core.caching as caching
impl = getattr(caching, "CacheImpl", None) or caching._CacheImpl
known = impl._locator_classes
impl._locator_classes = [c for c in known if "UserProvided" in c.__name__]
import os
from hapkit_studio.dynamics import jit, paddle
import numba
folder = numba.config.CACHE_DIR
assert os.environ["NUMBA_CACHE_DIR"] == folder
print(paddle.transition(1.0, 0.0, 0.0, 1.0)[1])
assert any(f.endswith(".nbc") for _, _, files in os.walk(folder) for f in files)
print(folder)
"""


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_without_a_place_to_write_a_folder_serves_while_the_program_runs():
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    words = [sys.executable, "-c", REFUSE]
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    velocity, folder = done.stdout.split()
    assert float(velocity) == 1.0
    assert not Path(folder).exists()
