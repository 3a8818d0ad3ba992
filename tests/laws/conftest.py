"""The board's virtual machine, built for this computer once for the tests of a module."""

import pytest

from tests.laws.machine_pc import Machine, build


@pytest.fixture(scope="module")
def machine():
    with Machine(build()) as made:
        yield made
