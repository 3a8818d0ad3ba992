"""The board's machine on this computer, for all tests of a file."""

import pytest

from tests.laws.machine_pc import Machine, build


@pytest.fixture(scope="module")
def machine():
    with Machine(build()) as made:
        yield made
