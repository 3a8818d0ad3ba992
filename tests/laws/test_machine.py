"""The firmware's header of operations is up to date, and the table can be encoded."""

from hapkit_studio.laws import machine
from hapkit_studio.laws.machine import OPERATIONS


def test_the_header_is_up_to_date():
    assert machine.HEADER.read_text() == machine.text()


def test_codes_names_and_cycles_are_valid():
    assert len({o.code for o in OPERATIONS}) == len({o.name for o in OPERATIONS}) == len(OPERATIONS)
    assert all(o.usual <= o.most for o in OPERATIONS)
