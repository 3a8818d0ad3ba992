"""The firmware's header agrees with the declarations, and a C++ compiler uses the same offsets."""

import shutil
import subprocess

import pytest

from hapkit_studio.protocol import header
from hapkit_studio.protocol.messages import MESSAGES, PROTOCOL_VERSION, BoardFlag


def test_the_header_is_up_to_date():
    assert header.default_path().read_text() == header.text()


@pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")
def test_a_compiler_agrees_on_every_offset(tmp_path):
    checks = [f"static_assert(protocol::kVersion == {PROTOCOL_VERSION});"]
    for message in MESSAGES:
        name = f"protocol::{message.__name__}"
        checks.append(f"static_assert({name}::kId == {message.ID} && {name}::kSize == {message.size()});")
        for wire in message.layout():
            at = message.offset(wire.name) - 1
            checks.append(f"static_assert(offsetof({name}, {wire.name}) == {at});")
            checks.append(f"static_assert(sizeof({name}::{wire.name}) == {wire.size});")
    flags = {flag.name.title().replace("_", ""): flag.value for flag in BoardFlag}
    checks += [f"static_assert(protocol::kFlag{name} == {value});" for name, value in flags.items()]
    source = tmp_path / "checks.cpp"
    source.write_text("#include <cstddef>\n#include <protocol.h>\n" + "\n".join(checks))
    folder = header.default_path().parent
    command = ["g++", "-std=c++17", "-fsyntax-only", f"-I{folder}", str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
