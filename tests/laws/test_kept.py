"""Whether a law's machine code is kept is known without compiling it, wherever numba keeps it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hapkit_studio.laws import native
from tests.laws.law_files import environment, law_text

# says whether the law is compiled: before, after it was translated anew and, if wished, after it was compiled
PROGRAM = """
import sys
from pathlib import Path
from tests.laws.law_files import environment, law_text
made = environment(Path(sys.argv[1]), law_text("return -{} * x".format(sys.argv[2])))
print(made.force.is_compiled())
if sys.argv[3:]:
    made.force.compiled()
    print(made.force.is_compiled())
"""


def said(folder, cache, gain, *compiling):
    """Return what a program of its own says that keeps machine code in this place."""
    kept = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")}
    command = [sys.executable, "-c", PROGRAM, str(folder), gain, *compiling]
    done = subprocess.run(command, env=kept | cache, capture_output=True, text=True, timeout=120, check=True)
    return done.stdout.split()


@pytest.fixture(params=["NUMBA_CACHE_DIR", "XDG_CACHE_HOME"])
def cache(request, tmp_path):
    """Return numba's own place for machine code, and that beside the generated file."""
    if request.param == "XDG_CACHE_HOME" and sys.platform != "linux":
        pytest.skip("The user's cache is elsewhere here.")
    return {request.param: str(tmp_path / "kept")}


@pytest.mark.slow
def test_it_is_known_in_another_program(cache, tmp_path):
    assert said(tmp_path, cache, "2.0", "compile") == ["False", "True"]
    assert said(tmp_path, cache, "2.0") == ["True"]
    assert said(tmp_path, cache, "3.0") == ["False"]


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """Return a law compiled into a place of its own, and a twin of it that is not loaded."""
    monkeypatch.setattr(native.numba.config, "CACHE_DIR", str(tmp_path / "kept"))
    text = law_text("return -2.0 * x")
    law, twin = environment(tmp_path, text).force, environment(tmp_path, text).force
    assert not law.is_compiled()
    law.compiled()
    assert twin.is_compiled()
    return law, twin


@pytest.mark.skipif(native.INTERPRETED, reason="Nothing is compiled.")
@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_half_of_it_is_not_enough(kept, tmp_path, ending):
    """numba writes the index first: a law whose data are still missing would be compiled here."""
    law, twin = kept
    for part in (tmp_path / "kept").rglob(f"law_*.law-*.{ending}"):
        part.unlink()
    assert not twin.is_compiled()
    assert law.is_compiled()


@pytest.mark.skipif(native.INTERPRETED, reason="Nothing is compiled.")
def test_another_numba_s_is_not_ours(kept, monkeypatch):
    _, twin = kept
    monkeypatch.setattr(native.numba, "__version__", "0.1")
    assert not twin.is_compiled()


@pytest.mark.skipif(native.INTERPRETED, reason="Nothing is compiled.")
def test_loading_leaves_a_generated_file_as_old_as_it_is(kept):
    """Some versions of numba take a file of another time for another file, and would compile it anew."""
    law, twin = kept
    path = Path(law.compiled().keepalive.__file__)
    os.utime(path, (0.0, 1e9))
    twin.compiled()
    assert path.stat().st_mtime == 1e9
    assert path.stat().st_atime > 1e9


def test_interpreted_laws_need_no_compiling(tmp_path, monkeypatch):
    monkeypatch.setattr(native, "INTERPRETED", True)
    monkeypatch.setattr(native.numba.config, "CACHE_DIR", str(tmp_path / "kept"))
    assert environment(tmp_path, law_text("return -2.0 * x")).force.is_compiled()
