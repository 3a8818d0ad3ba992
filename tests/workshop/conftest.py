"""Every test of the workshop has a folder, a list of trusted texts and a folder to stand in of its own."""

import pytest


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    """Return where these tests keep compiled laws and how trials ended: each text is compiled once."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def own_home(tmp_path, cache, monkeypatch):
    """Keep this test, and the programs it starts, away from what a person has."""
    monkeypatch.setenv("HAPKIT_STUDIO_FOLDER", str(tmp_path / "studio"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.chdir(tmp_path)
