"""Every workshop test has its own home folder, list of trusted files and working folder."""

import pytest


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    """Return the shared cache, in which each text of a law is compiled and tried only once."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def own_home(tmp_path, cache, monkeypatch):
    """Isolate a test, and the programs it starts, from the user's own files."""
    monkeypatch.setenv("HAPKIT_STUDIO_FOLDER", str(tmp_path / "studio"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.chdir(tmp_path)
