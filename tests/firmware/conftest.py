"""What several tests of sketches build from."""

import pytest

from tests.firmware import sketches
from tests.once import built_once


@pytest.fixture(scope="session")
def archive(tmp_path_factory):
    """Return the Arduino core, compiled once."""
    return built_once(tmp_path_factory, "core", sketches.core) / "core.a"
