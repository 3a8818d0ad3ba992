"""The machine code of a bundle: where it is, which processors it suits, and who may write it."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from llvmlite import binding
from numba.core import caching

from hapkit_studio import program
from hapkit_studio.dynamics import jit


@pytest.mark.slow
def test_modules_are_started_by_this_interpreter_outside_the_current_folder(tmp_path):
    (tmp_path / "hapkit_studio.py").write_text("raise SystemExit('the wrong one')")
    command = program.module_command("hapkit_studio", "--version")
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert (done.returncode, command[0]) == (0, sys.executable), done.stderr


@pytest.fixture
def bundle(tmp_path, monkeypatch):
    """Make this program appear to be a bundle with machine code; return the bundle's folder."""
    package, shipped = tmp_path / "hapkit_studio", tmp_path / "machine-code"
    (shipped / "hapkit_studio" / "dynamics").mkdir(parents=True)
    (shipped / "stamp").write_text("1234")
    for name, value in {
        "BUNDLED": True,
        "PACKAGE": package,
        "SHIPPED": shipped,
        "STAMP": shipped / "stamp",
    }.items():
        monkeypatch.setattr(program, name, value)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    for cached in (program.baseline, program.uses_shipped_code, jit._shipped_stamp):
        cached.cache_clear()
    yield tmp_path
    for cached in (program.baseline, program.uses_shipped_code, jit._shipped_stamp):
        cached.cache_clear()


@pytest.mark.parametrize(
    ("missing", "used"), [("", True), ("avx2", False), ("sse4.2", False), ("avx512f", True)]
)
def test_a_bundle_uses_its_machine_code_on_processors_with_all_features_of_its_baseline(
    bundle, monkeypatch, missing, used
):
    # these are the features of the psABI's x86-64-v3 that LLVM reports
    v3 = "avx avx2 bmi bmi2 cx16 f16c fma lzcnt movbe popcnt sahf sse3 sse4.1 sse4.2 ssse3 xsave avx512f"
    features = {name: name != missing for name in v3.split()}
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: features)
    monkeypatch.setattr("platform.machine", lambda: "AMD64")  # Windows' name of x86-64
    assert program.uses_shipped_code() is used
    assert program.baseline() == ("x86-64-v3" if used else None)


def test_a_folder_for_machine_code_that_the_user_sets_is_used_instead(bundle, monkeypatch):
    monkeypatch.setattr("platform.machine", lambda: "any")
    assert program.uses_shipped_code()
    program.uses_shipped_code.cache_clear()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(bundle))
    assert not program.uses_shipped_code()


def test_machine_code_has_the_folders_of_the_sources(bundle):
    inside = program.SHIPPED / "hapkit_studio" / "dynamics"
    assert program.machine_code_folder(bundle / "hapkit_studio" / "dynamics" / "paddle.py") == inside
    assert program.machine_code_folder(program.SHIPPED / "laws" / "law_1.py") == program.SHIPPED / "laws"
    assert program.machine_code_folder("/elsewhere/mine.py") is None


def _twice(x):
    return 2.0 * x


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_machine_code_in_a_bundle_is_read_and_never_written(bundle, monkeypatch):
    source = bundle / "hapkit_studio" / "dynamics" / "paddle.py"
    source.parent.mkdir(parents=True)
    text = "def twice(x):\n    return 2.0 * x\n"
    source.write_text(text)

    def compiled():
        scope = {"__name__": "paddle"}
        exec(compile(text, str(source), "exec"), scope)
        return numba.njit(cache=True)(scope["twice"])

    found = f"{jit.__name__}.ShippedCacheLocator,UserProvidedCacheLocator"
    for name, value in (("CACHE_LOCATOR_CLASSES", found), ("CACHE_DIR", str(bundle / "users"))):
        monkeypatch.setattr(numba.config, name, value)
        monkeypatch.setenv(f"NUMBA_{name}", value)
    monkeypatch.setattr(program, "FILLING", True)  # the program fills the cache, as when the bundle is built
    assert compiled()(21.0) == 42.0
    shipped = sorted(program.SHIPPED.rglob("*.nb[ci]"))
    assert [file.suffix for file in shipped] == [".nbc", ".nbi"]
    monkeypatch.setattr(program, "FILLING", False)
    again = compiled()
    assert again(21.0) == 42.0
    assert again.stats.cache_hits == {(numba.float64,): 1}
    program.STAMP.write_text("5678")  # the sources have changed, so the machine code is not used
    jit._shipped_stamp.cache_clear()
    other = compiled()
    assert other(21.0) == 42.0
    assert not other.stats.cache_hits


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_compiled_code_that_cannot_be_saved_is_used(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    function = numba.njit(cache=True)(_twice)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(caching.IndexDataCacheFile, "save", full)
    assert function(21.0) == 42.0


def test_machine_code_of_an_installed_copy_is_in_the_users_cache_and_leaves_after_sixty_days(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("platformdirs.user_cache_dir", lambda *_, **__: str(tmp_path))
    for name in ("NUMBA_CACHE_DIR", program.OWN_CACHE):
        monkeypatch.setenv(name, "")  # setting it here lets monkeypatch restore it after the test
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    kept, old = tmp_path / "machine-code" / "kept", tmp_path / "machine-code" / "old"
    day = 86_400.0
    for folder, age in ((kept, 59 * day), (old, 61 * day)):
        folder.mkdir(parents=True)
        then = folder.stat().st_mtime - age
        os.utime(folder, (then, then))
    jit.use_user_cache()
    now = Path(numba.config.CACHE_DIR)
    assert set((tmp_path / "machine-code").iterdir()) == {now, kept}
    assert os.environ["NUMBA_CACHE_DIR"] == str(now)
    # a folder that the studio has chosen does not count as the user's choice
    assert program.configured_cache() == ""


@pytest.mark.parametrize("original", [None, "/opt/lib"])
def test_other_programs_started_by_a_bundle_get_the_systems_libraries(monkeypatch, original):
    start = runpy.run_path(str(Path(__file__).parents[1] / ".ci" / "bundle" / "start.py"))
    monkeypatch.setenv("LD_LIBRARY_PATH", "/bundle/_internal")  # PyInstaller's loader sets this variable
    monkeypatch.delenv("LD_LIBRARY_PATH_ORIG", raising=False)
    if original is not None:
        monkeypatch.setenv("LD_LIBRARY_PATH_ORIG", original)
    for name in ("PYINSTALLER_RESET_ENVIRONMENT", "MPLCONFIGDIR"):
        monkeypatch.setenv(name, "/tmp")
    start["restore_environment"]()
    assert os.environ.get("LD_LIBRARY_PATH") == original
    assert "MPLCONFIGDIR" not in os.environ
    assert os.environ["PYINSTALLER_RESET_ENVIRONMENT"] == "1"  # a second bundle sets the path again
