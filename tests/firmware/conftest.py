"""What several tests of sketches build from."""

import pytest

from tests.firmware import sketches


@pytest.fixture(scope="session")
def archive(tmp_path_factory):
    """Return the Arduino core, compiled once."""
    return sketches.core(tmp_path_factory.mktemp("core"))
