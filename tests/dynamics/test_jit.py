"""Compiled code is cached even without a writable folder, and outdated code is removed."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from hapkit_studio.dynamics import jit

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


@pytest.mark.slow
@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_temporary_cache_is_used_without_a_writable_folder():
    environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
    command = [sys.executable, "-c", REFUSE]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    velocity, folder = done.stdout.split()
    assert float(velocity) == 1.0
    assert not Path(folder).exists()


def test_outdated_compiled_code_is_removed(tmp_path):
    source, kept = (
        tmp_path / "dynamics" / "paddle.py",
        tmp_path / "haptics" / "__pycache__" / "tick-1.py311.nbi",
    )
    for file in (source, kept):
        file.parent.mkdir(parents=True)

    def remains():
        kept.write_text("compiled")
        jit.forget_outdated(tmp_path)
        return kept.exists()

    source.write_text("x = 1")
    assert not remains()  # code of unknown sources counts as outdated
    assert remains()
    os.utime(source, (1.0, 1.0))
    assert not remains()
    source.rename(source.with_name("motor.py"))
    assert not remains()
    assert remains()
    assert len(list((tmp_path / "__pycache__").iterdir())) == 1
