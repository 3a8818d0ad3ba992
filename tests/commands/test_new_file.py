"""A new command is one module: the help lists it, its options are read, and it answers as text and JSON."""

import json

import pytest

from tests.project_copy import copy_with, run_program, run_tests

NEW = '''"""The command that says how many samples a recording of some length has."""

from hapkit_studio.commands.base import Command, Result, option


def run(options):
    samples = round(options.rate * options.seconds)
    return Result(f"{samples:,} samples", {"samples": samples})


OPTIONS = (
    option("seconds", type=float, help="length in s"),
    option("--rate", type=float, default=1000.0, metavar="Hz", help="samples a second; 1,000"),
)
COMMAND = Command("samples", "say how many samples a recording has", run, OPTIONS)
'''


@pytest.mark.slow
def test_a_new_command_needs_one_module(tmp_path):
    copy = copy_with(tmp_path, "hapkit_studio/commands/samples.py", NEW)
    output = run_tests(copy, "-m", "not slow and not alone", "tests/test_cli.py", "tests/test_imports.py")
    assert "test_the_help_lists_and_describes_every_command[samples] PASSED" in output
    program = "-m", "hapkit_studio", "samples", "2.5", "--rate", "4000"
    assert run_program(copy, *program) == "10,000 samples\n"
    assert json.loads(run_program(copy, *program, "--json")) == {"samples": 10_000}
