"""Every test of the workshop has a folder, a list of trusted texts and a record of trials of its own."""

import pytest


@pytest.fixture(autouse=True)
def own_home(tmp_path, monkeypatch):
    """Keep this test, and the programs it starts, away from what a person has."""
    monkeypatch.setenv("HAPKIT_STUDIO_FOLDER", str(tmp_path / "studio"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
