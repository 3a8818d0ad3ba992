"""A new benchmark is one module: it is listed and run by its name, and its rows are printed and stored."""

import json

import pytest

from tests.project_copy import copy_with, run_program, run_tests

NEW = '''"""Time to sort a thousand numbers."""

import random
import timeit

from tests.bench.frame import Row

NAME = "sorting"


def run() -> list[Row]:
    numbers = random.Random(1).sample(range(1_000_000), 1_000)
    seconds = min(timeit.repeat(lambda: sorted(numbers), number=1))
    return [Row("sort 1,000 numbers", 1e6 * seconds, "µs", target="< 1 s", ok=seconds < 1.0)]
'''


@pytest.mark.slow
def test_a_new_benchmark_needs_one_module(tmp_path):
    copy = copy_with(tmp_path, "tests/bench/bench_sorting.py", NEW)
    output = run_tests(copy, "tests/bench/test_every_benchmark.py")
    assert "test_it_is_listed_and_described[sorting] PASSED" in output
    printed = run_program(copy, "-m", "tests.bench", "sorting").splitlines()
    assert printed[2].startswith("| sort 1,000 numbers | ")
    assert printed[2].endswith(" µs |  |  | < 1 s | yes |")
    (stored,) = (copy / "bench-results").iterdir()
    (row,) = json.loads(stored.read_text("utf-8"))["rows"]
    assert (row["what"], row["unit"]) == ("sort 1,000 numbers", "µs")
