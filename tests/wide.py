"""Wide parameter ranges: `make test` runs a few cases, `make test-all` runs all of them."""

from collections.abc import Callable, Iterable

import pytest


def wide(cases: Iterable, quick: Callable[..., object]) -> list:
    """Return test cases (tuples for several parameters), marked slow unless quick(*case)."""
    given = [case if isinstance(case, tuple) else (case,) for case in cases]
    return [pytest.param(*case, marks=() if quick(*case) else pytest.mark.slow) for case in given]
