"""The firmware's header of operations is what the table says, and the table can be coded."""

from hapkit_studio.laws import machine
from hapkit_studio.laws.machine import OPERATIONS


def test_header_is_up_to_date():
    assert machine.default_path().read_text() == machine.text()
    assert machine.main(["--check"]) == 0


def test_check_notices_a_change(tmp_path):
    copy = tmp_path / "opcodes.h"
    assert machine.main([str(copy), "--check"]) == 1
    assert machine.main([str(copy)]) == 0
    assert machine.main([str(copy), "--check"]) == 0
    copy.write_text(copy.read_text().replace("kAdd = ", "kAdd = 1"))
    assert machine.main([str(copy), "--check"]) == 1


def test_codes_names_and_cycles():
    assert len({o.code for o in OPERATIONS}) == len({o.name for o in OPERATIONS}) == len(OPERATIONS)
    assert all(o.usual <= o.most for o in OPERATIONS)
